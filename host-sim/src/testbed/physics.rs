//! The plant's differential equations, written from the physics.
//!
//! x > 0 opens P-A and B-T and extends. Qa > 0 flows into chamber A, Qb > 0 flows out of chamber B.
//! The states are scaled so that one tolerance fits them all: pressures in parts of the supply
//! pressure, position in parts of the stroke, velocity in m/s, an effect's own states of order one.

use model_core::machine::{Machine, Source};
use model_core::parameter::Parameter;

use super::effect::PlantEffect;
use super::input::PumpCommand;
use super::orifice::{limited, opening, signed_root};
use super::tangent::Real;

/// Number of the drive's own states: pa, pb, v, y.
pub(super) const BASE_STATES: usize = 4;

/// What acts on the hydraulics from outside at one moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inputs {
    /// Slider position, 1 (valve drives).
    pub(super) spool: f64,
    /// The pump and its directional valve (pump drives).
    pub(super) pump: Option<PumpCommand>,
    /// Force on the rod beside the machine's own load, N; positive extends.
    pub(super) force_n: f64,
    pub(super) tank_pressure_pa: f64,
    pub(super) laminar_transition_pa: f64,
}

/// The drive's state in SI units.
#[derive(Clone, Copy, Debug)]
pub(super) struct State<R> {
    pub(super) pressure_a: R,
    pub(super) pressure_b: R,
    pub(super) velocity: R,
}

/// What the effects may change: net flows into the chambers, their capacities, the force on the rod.
#[derive(Clone, Copy, Debug)]
pub(super) struct Terms<R> {
    /// m³/s, compression included: what raises pa.
    pub(super) into_a: R,
    /// m³/s: what raises pb.
    pub(super) into_b: R,
    /// m³/Pa: dV/dp of chamber A, V/E0 and whatever else yields.
    pub(super) capacity_a: R,
    /// m³/Pa, of chamber B.
    pub(super) capacity_b: R,
    /// N, positive extends.
    pub(super) force: R,
}

/// The plant: parameters and effects. Immutable; all state is the caller's.
#[derive(Clone, Debug)]
pub(super) struct Physics {
    source: Source,
    supply_pa: f64,
    tank_pa: f64,
    flow_limit: f64,
    dead_zone: f64,
    flow_coefficient: f64,
    return_coefficient: f64,
    displacement: f64,
    transition_pa: f64,
    area_a: f64,
    area_b: f64,
    capacity_a: f64,
    capacity_b: f64,
    mass: f64,
    damping: f64,
    load_n: f64,
    stroke_m: f64,
    effects: Vec<PlantEffect>,
}

impl Physics {
    pub(super) fn new(machine: &Machine<f64>, effects: &[PlantEffect]) -> Self {
        let get = |parameter| machine.get(parameter);
        // A volume that the file does not give is half the stroke times the area (7).
        let half_stroke = 0.5 * get(Parameter::Stroke);
        let volume = |given: f64, area: f64| if given.is_nan() { half_stroke * area } else { given };
        let (area_a, area_b) = (get(Parameter::AreaA), get(Parameter::AreaB));
        let modulus = get(Parameter::BulkModulus);
        Self {
            source: machine.source,
            supply_pa: get(Parameter::SupplyPressure),
            tank_pa: get(Parameter::TankPressure),
            flow_limit: get(Parameter::FlowLimit),
            dead_zone: get(Parameter::DeadZone),
            flow_coefficient: get(Parameter::FlowCoefficient),
            return_coefficient: get(Parameter::ReturnCoefficient),
            displacement: get(Parameter::PumpDisplacement),
            transition_pa: get(Parameter::LaminarTransition),
            area_a,
            area_b,
            capacity_a: volume(get(Parameter::VolumeA), area_a) / modulus,
            capacity_b: volume(get(Parameter::VolumeB), area_b) / modulus,
            mass: get(Parameter::MovingMass),
            damping: get(Parameter::ViscousFriction),
            load_n: get(Parameter::LoadForce),
            stroke_m: get(Parameter::Stroke),
            effects: effects.to_vec(),
        }
    }

    pub(super) fn source(&self) -> Source {
        self.source
    }

    pub(super) fn dead_zone(&self) -> f64 {
        self.dead_zone
    }

    /// States to integrate: the drive's and the effects'.
    pub(super) fn states(&self) -> usize {
        BASE_STATES + self.effects.iter().map(PlantEffect::states).sum::<usize>()
    }

    /// One unit of each of the drive's states, in SI: Pa, Pa, m/s, m.
    pub(super) fn scales(&self) -> [f64; BASE_STATES] {
        [self.supply_pa, self.supply_pa, 1.0, self.stroke_m]
    }

    pub(super) fn inputs(&self, spool: f64, pump: Option<PumpCommand>, force_n: f64) -> Inputs {
        Inputs { spool, pump, force_n, tank_pressure_pa: self.tank_pa, laminar_transition_pa: self.transition_pa }
    }

    /// Qa and Qb, m³/s, through the valve (3), (4), or from the pump and through the return.
    pub(super) fn flows<R: Real>(&self, inputs: &Inputs, pressure_a: R, pressure_b: R) -> (R, R) {
        let root = |difference: R| signed_root(difference, self.transition_pa);
        let to_tank = |pressure: R| pressure - self.tank_pa;
        let from_supply = |pressure: R| -pressure + self.supply_pa;
        match self.source {
            Source::Valve => {
                let gain = self.flow_coefficient * opening(inputs.spool, self.dead_zone);
                let (across_a, across_b) = if gain > 0.0 {
                    (from_supply(pressure_a), to_tank(pressure_b))
                } else if gain < 0.0 {
                    (to_tank(pressure_a), from_supply(pressure_b))
                } else {
                    return (0.0.into(), 0.0.into());
                };
                (limited(root(across_a) * gain, self.flow_limit), limited(root(across_b) * gain, self.flow_limit))
            }
            Source::Pump => {
                let Some(pump) = inputs.pump else { return (0.0.into(), 0.0.into()) };
                let delivered: R = (self.displacement * pump.speed_rev_per_s).into();
                let returned = |pressure: R| root(to_tank(pressure)) * self.return_coefficient;
                match pump.direction {
                    1.. => (delivered, returned(pressure_b)),
                    0 => (0.0.into(), 0.0.into()),
                    ..=-1 => (-returned(pressure_a), -delivered),
                }
            }
        }
    }

    /// Derivatives of the scaled states, 1/s: (1), (2), (8) and dy/dt = v, with the effects added.
    pub(super) fn rates<R: Real>(&self, inputs: &Inputs, scaled: &[R], rates: &mut [R]) {
        let [pressure_scale, _, _, _] = self.scales();
        let state = State {
            pressure_a: scaled[0] * pressure_scale,
            pressure_b: scaled[1] * pressure_scale,
            velocity: scaled[2],
        };
        let (flow_a, flow_b) = self.flows(inputs, state.pressure_a, state.pressure_b);
        let mut terms = Terms {
            into_a: flow_a - state.velocity * self.area_a,
            into_b: state.velocity * self.area_b - flow_b,
            capacity_a: self.capacity_a.into(),
            capacity_b: self.capacity_b.into(),
            force: state.pressure_a * self.area_a - state.pressure_b * self.area_b - state.velocity * self.damping
                + (self.load_n + inputs.force_n),
        };
        let mut from = BASE_STATES;
        for effect in &self.effects {
            let own = from..from + effect.states();
            from = own.end;
            effect.apply(inputs, &state, &scaled[own.clone()], &mut rates[own], &mut terms);
        }
        rates[0] = terms.into_a / terms.capacity_a / pressure_scale;
        rates[1] = terms.into_b / terms.capacity_b / pressure_scale;
        rates[2] = terms.force / self.mass;
        rates[3] = state.velocity / self.stroke_m;
    }
}
