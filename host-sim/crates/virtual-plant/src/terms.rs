//! What the equations of the plant and its effects exchange: inputs, state, and the terms that effects may change.

use crate::excitation::input::PumpCommand;

/// What acts on the hydraulics from outside at one moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inputs {
    pub(crate) time_s: f64,
    /// Spool position, 1 (valve drives).
    pub(crate) spool: f64,
    /// The pump and its directional valve (pump drives).
    pub(crate) pump: Option<PumpCommand>,
    /// Force on the rod beside the machine's own load, N; positive extends.
    pub(crate) force_n: f64,
    /// As the machine has it.
    pub(crate) supply_pa: f64,
    pub(crate) tank_pressure_pa: f64,
    pub(crate) laminar_transition_pa: f64,
}

/// The drive's state in SI units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State<R> {
    pub(crate) pressure_a: R,
    pub(crate) pressure_b: R,
    pub(crate) velocity: R,
    pub(crate) position: R,
    /// At the valve's port P.
    pub(crate) supply: R,
    /// In parts of what the machine's parameters hold for.
    pub(crate) viscosity: R,
}

/// What every term depends on, and effects may change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conditions<R> {
    /// Pressure at the valve's port P, Pa.
    pub(crate) supply: R,
    /// Viscosity in parts of what the machine's parameters hold for.
    pub(crate) viscosity: R,
}

/// What the effects may change: net flows into the chambers, their capacities, the force on the rod.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms<R> {
    /// m³/s, compression included: what raises pa.
    pub(crate) into_a: R,
    /// m³/s: what raises pb.
    pub(crate) into_b: R,
    /// m³/s out of the supply through the valve.
    pub(crate) delivered: R,
    /// m³ of oil in chamber A.
    pub(crate) volume_a: R,
    /// m³ in chamber B.
    pub(crate) volume_b: R,
    /// 1/Pa: what the oil in A yields beside 1/E0.
    pub(crate) softness_a: R,
    /// 1/Pa, in B.
    pub(crate) softness_b: R,
    /// m³/Pa: what yields beside the oil of chamber A.
    pub(crate) capacity_a: R,
    /// m³/Pa, of chamber B.
    pub(crate) capacity_b: R,
    /// N, positive extends.
    pub(crate) force: R,
}
