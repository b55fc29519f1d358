//! The plant's differential equations, written from the physics.
//!
//! x > 0 opens P-A and B-T and extends. Qa > 0 flows into chamber A, Qb > 0 flows out of chamber B.
//! The states are scaled so that one tolerance fits them all: pressures relative to the supply
//! pressure, position relative to the stroke, velocity in m/s, an effect's own states of order one.

use model_core::machine::{Machine, Parameter, Source};

use crate::effect::chambers::moving_volumes;
use crate::effect::{Fixed, PlantEffect};
use crate::excitation::input::PumpCommand;
use crate::flow::edges::{Edges, GainCurve, Ports, SeriesLine};
use crate::flow::orifice::signed_root;
use crate::tangent::Real;
pub(crate) use crate::terms::{Conditions, Inputs, State, Terms};

/// Number of the drive's own states: pa, pb, v, y.
pub(crate) const BASE_STATES: usize = 4;

/// The plant: parameters and effects. Immutable; the caller holds all state.
#[derive(Clone, Debug)]
pub(crate) struct Physics {
    source: Source,
    supply_pa: f64,
    tank_pa: f64,
    edges: Edges,
    return_coefficient: f64,
    displacement: f64,
    transition_pa: f64,
    area_a: f64,
    area_b: f64,
    volume_a: f64,
    volume_b: f64,
    modulus: f64,
    mass: f64,
    damping: f64,
    load_n: f64,
    stroke_m: f64,
    /// Whether the chambers' volumes follow the piston.
    breathes: bool,
    effects: Vec<PlantEffect>,
}

impl Physics {
    pub(crate) fn new(machine: &Machine<f64>, effects: &[PlantEffect]) -> Self {
        let get = |parameter| machine.get(parameter);
        // A volume that the file does not give is half the stroke times the area (7).
        let half_stroke = 0.5 * get(Parameter::Stroke);
        let volume = |given: f64, area: f64| if given.is_nan() { half_stroke * area } else { given };
        let (area_a, area_b) = (get(Parameter::AreaA), get(Parameter::AreaB));
        let dead_zone = get(Parameter::DeadZone);
        let mut edges = Edges {
            coefficient: get(Parameter::FlowCoefficient),
            dead_zone: [dead_zone, dead_zone],
            transition_pa: get(Parameter::LaminarTransition),
            laminar_pa: 0.0,
            flow_limit: get(Parameter::FlowLimit),
            gain: GainCurve::Proportional,
            sizes: [1.0; 4],
            supply_line: SeriesLine::default(),
            return_line: SeriesLine::default(),
        };
        for effect in effects {
            if let PlantEffect::Flow(effect) = effect {
                effect.configure(&mut edges);
            }
        }
        Self {
            source: machine.source,
            supply_pa: get(Parameter::SupplyPressure),
            tank_pa: get(Parameter::TankPressure),
            edges,
            return_coefficient: get(Parameter::ReturnCoefficient),
            displacement: get(Parameter::PumpDisplacement),
            transition_pa: get(Parameter::LaminarTransition),
            area_a,
            area_b,
            volume_a: volume(get(Parameter::VolumeA), area_a),
            volume_b: volume(get(Parameter::VolumeB), area_b),
            modulus: get(Parameter::BulkModulus),
            mass: get(Parameter::MovingMass),
            damping: get(Parameter::ViscousFriction),
            load_n: get(Parameter::LoadForce),
            stroke_m: get(Parameter::Stroke),
            breathes: get(Parameter::VolumeFollows) > 0.0,
            effects: effects.to_vec(),
        }
    }

    pub(crate) fn source(&self) -> Source {
        self.source
    }

    pub(crate) fn edges(&self) -> &Edges {
        &self.edges
    }

    pub(crate) fn effects(&self) -> &[PlantEffect] {
        &self.effects
    }

    /// States to integrate: the drive's and the effects'.
    pub(crate) fn states(&self) -> usize {
        BASE_STATES + self.effects.iter().map(PlantEffect::states).sum::<usize>()
    }

    /// One unit of each of the drive's states, in SI: Pa, Pa, m/s, m.
    pub(crate) fn scales(&self) -> [f64; BASE_STATES] {
        [self.supply_pa, self.supply_pa, 1.0, self.stroke_m]
    }

    pub(crate) fn inputs(&self, time_s: f64, spool: f64, pump: Option<PumpCommand>, force_n: f64) -> Inputs {
        Inputs {
            time_s,
            spool,
            pump,
            force_n,
            supply_pa: self.supply_pa,
            tank_pressure_pa: self.tank_pa,
            laminar_transition_pa: self.transition_pa,
        }
    }

    /// The state in SI units, with the supply pressure and viscosity as the effects have changed them.
    pub(crate) fn state<R: Real>(&self, inputs: &Inputs, scaled: &[R]) -> State<R> {
        let mut conditions = Conditions { supply: self.supply_pa.into(), ports: [None; 2], viscosity: 1.0.into() };
        let mut from = BASE_STATES;
        for effect in &self.effects {
            let to = from + effect.states();
            effect.condition(inputs, &scaled[from..to], &mut conditions);
            from = to;
        }
        let (pressure_a, pressure_b) = (scaled[0] * self.supply_pa, scaled[1] * self.supply_pa);
        let [port_a, port_b] = conditions.ports;
        State {
            pressure_a,
            pressure_b,
            port_a: port_a.unwrap_or(pressure_a),
            port_b: port_b.unwrap_or(pressure_b),
            velocity: scaled[2],
            position: scaled[3] * self.stroke_m,
            supply: conditions.supply,
            viscosity: conditions.viscosity,
        }
    }

    /// Qa and Qb, m³/s, through the valve (3), (4), or from the pump and through the return line.
    pub(crate) fn flows<R: Real>(&self, inputs: &Inputs, state: &State<R>) -> (R, R) {
        match self.source {
            Source::Valve => {
                let (a, b, supply) = (state.port_a, state.port_b, state.supply);
                self.edges.flows(inputs.spool, &Ports { supply, tank_pa: self.tank_pa, a, b })
            }
            Source::Pump => {
                let Some(pump) = inputs.pump else { return (0.0.into(), 0.0.into()) };
                let delivered: R = (self.displacement * pump.speed_rev_per_s).into();
                let returned = |port: R| signed_root(port - self.tank_pa, self.transition_pa) * self.return_coefficient;
                match pump.direction {
                    1.. => (delivered, returned(state.pressure_b)),
                    0 => (0.0.into(), 0.0.into()),
                    ..=-1 => (-returned(state.pressure_a), -delivered),
                }
            }
            // No plant is made of such a machine.
            Source::Force => (0.0.into(), 0.0.into()),
        }
    }

    /// Derivatives of the scaled states, 1/s: (1), (2), (8) and dy/dt = v, with the effects added.
    pub(crate) fn rates<R: Real>(&self, inputs: &Inputs, scaled: &[R], rates: &mut [R]) {
        let state = self.state(inputs, scaled);
        let (flow_a, flow_b) = self.flows(inputs, &state);
        let (none, damping) = (R::from(0.0), state.viscosity * self.damping);
        let mut terms = Terms {
            into_a: flow_a - state.velocity * self.area_a,
            into_b: state.velocity * self.area_b - flow_b,
            delivered: self.edges.delivered(inputs.spool, (flow_a, flow_b)),
            volume_a: self.volume_a.into(),
            volume_b: self.volume_b.into(),
            softness_a: none,
            softness_b: none,
            capacity_a: none,
            capacity_b: none,
            force: state.pressure_a * self.area_a - state.pressure_b * self.area_b - state.velocity * damping
                + (self.load_n + inputs.force_n),
        };
        if self.breathes {
            moving_volumes([self.area_a, self.area_b], self.stroke_m, &state, &mut terms);
        }
        let plant = Fixed { edges: &self.edges, areas_m2: [self.area_a, self.area_b], stroke_m: self.stroke_m };
        let mut from = BASE_STATES;
        for effect in &self.effects {
            let own = from..from + effect.states();
            from = own.end;
            effect.apply(&plant, inputs, &state, (&scaled[own.clone()], &mut rates[own]), &mut terms);
        }
        let capacity_a = terms.volume_a * (terms.softness_a + 1.0 / self.modulus) + terms.capacity_a;
        let capacity_b = terms.volume_b * (terms.softness_b + 1.0 / self.modulus) + terms.capacity_b;
        rates[0] = terms.into_a / capacity_a / self.supply_pa;
        rates[1] = terms.into_b / capacity_b / self.supply_pa;
        rates[2] = terms.force / self.mass;
        rates[3] = state.velocity / self.stroke_m;
    }
}
