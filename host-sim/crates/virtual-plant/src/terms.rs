//! The data that the equations of the plant and its effects exchange: inputs, state, and the terms that effects may change.

use crate::excitation::input::PumpCommand;

/// What acts on the hydraulics from outside at one moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inputs {
    pub(crate) time_s: f64,
    /// Spool position, 1 (valve drives).
    pub(crate) spool: f64,
    /// The pump and its directional valve (pump drives).
    pub(crate) pump: Option<PumpCommand>,
    /// Force on the rod in addition to the machine's own load, N; positive extends.
    pub(crate) force_n: f64,
    /// Nominal value from the machine, Pa.
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
    /// Pressure at the valve's port P.
    pub(crate) supply: R,
    /// Pressure at its port A: that of the chamber, unless something is between them.
    pub(crate) port_a: R,
    /// The same at port B.
    pub(crate) port_b: R,
    /// Relative to the viscosity that the machine's parameters are for.
    pub(crate) viscosity: R,
}

/// Conditions on which every term depends, and which effects may change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conditions<R> {
    /// Pressure at the valve's port P, Pa.
    pub(crate) supply: R,
    /// Pressures at its ports A and B where they are not the chambers', Pa.
    pub(crate) ports: [Option<R>; 2],
    /// Viscosity relative to the one that the machine's parameters are for.
    pub(crate) viscosity: R,
}

/// Terms that the effects may change: net flows into the chambers, their capacities, the force on the rod.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms<R> {
    /// m³/s, compression included: raises pa.
    pub(crate) into_a: R,
    /// m³/s: raises pb.
    pub(crate) into_b: R,
    /// m³/s, out of the supply through the valve.
    pub(crate) delivered: R,
    /// m³ of oil in chamber A.
    pub(crate) volume_a: R,
    /// m³ in chamber B.
    pub(crate) volume_b: R,
    /// 1/Pa: compressibility of the oil in A in addition to 1/E0.
    pub(crate) softness_a: R,
    /// 1/Pa, the same in B.
    pub(crate) softness_b: R,
    /// m³/Pa: capacity in addition to the oil of chamber A.
    pub(crate) capacity_a: R,
    /// m³/Pa, the same for chamber B.
    pub(crate) capacity_b: R,
    /// N, positive extends.
    pub(crate) force: R,
}
