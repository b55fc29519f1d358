//! What the edges, the supply and the return line do beyond the paper's model.

use super::load_holding::{self, LoadHolding};
use crate::flow::edges::{Edges, GainCurve, SeriesLine};
use crate::flow::orifice::signed_root;
use crate::tangent::Real;
use crate::terms::{Conditions, Inputs, State, Terms};

/// An effect between spool and chambers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlowEffect {
    /// One side has more overlap than the machine file states.
    DeadZone {
        /// Spool travel added to the overlap of the extending side.
        extending: f64,
        /// Spool travel added to the overlap of the retracting side.
        retracting: f64,
    },
    /// The flow is not proportional to the opening.
    Gain(GainCurve),
    /// Each edge has its own size, relative to the nominal one: P-A, B-T, P-B, A-T.
    Metering {
        /// The four sizes.
        sizes: [f64; 4],
    },
    /// The supply behind a pressure-controlled pump, a gas accumulator and a turbulent line.
    SupplyDroop {
        /// Fall of the pump's pressure per delivered flow, Pa·s/m³.
        resistance_pa_s_per_m3: f64,
        /// Gas in the accumulator at the nominal pressure, m³.
        gas_volume_m3: f64,
        /// Resistance of the line between accumulator and valve, Pa·s²/m⁶.
        line_pa_s2_per_m6: f64,
    },
    /// A return line with a laminar and a turbulent part.
    BackPressure {
        /// Pa·s/m³.
        linear_pa_s_per_m3: f64,
        /// Pa·s²/m⁶.
        quadratic_pa_s2_per_m6: f64,
    },
    /// All four edges leak near the centre: an opening that falls off as a Gaussian; the flow is partly laminar.
    Leakage {
        /// Opening at the centre, 1.
        opening: f64,
        /// Spool travel at which the opening has fallen to 1/e.
        reach: f64,
        /// Pressure difference up to which the gap is laminar, Pa.
        laminar_pa: f64,
    },
    /// No edge is sharp, and the spool has play in its bore: an open edge is as wide as the hypotenuse of travel and play, and through the play of a
    /// covered one oil leaks the less the longer its overlap, in laminar flow up to a pressure difference.
    RoundedEdges {
        /// Play, and radius of the corners, in spool travel.
        play: f64,
        /// Pressure difference up to which the gap is laminar, Pa.
        laminar_pa: f64,
    },
    /// Sharp edges are laminar up to a pressure difference: a laminar and a turbulent resistance in series.
    LaminarTransition {
        /// Pressure difference at which both take the same share, Pa.
        pressure_pa: f64,
    },
    /// Load-holding valves between valve and chambers.
    Counterbalance(LoadHolding),
    /// The pump's pressure pulsates (not in the vocabulary).
    PumpRipple {
        /// Amplitude relative to the supply pressure.
        share: f64,
        /// Hz.
        frequency_hz: f64,
    },
    /// Another consumer on the same supply takes its flow in strokes, sin²(π·t/T) (not in the vocabulary). It acts on a supply that droops, and
    /// stands before that in the list of effects.
    OtherConsumer {
        /// Its largest flow, m³/s.
        flow_m3_per_s: f64,
        /// From one stroke to the next, s.
        period_s: f64,
    },
}

impl FlowEffect {
    /// The name in the project's vocabulary; a leading ~ marks an effect outside the vocabulary.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::DeadZone { .. } => "dead-zone-asymmetry",
            Self::Gain(_) => "flow-gain-nonlinearity",
            Self::Metering { .. } => "metering-asymmetry",
            Self::SupplyDroop { .. } => "supply-droop",
            Self::BackPressure { .. } => "tank-back-pressure",
            Self::Leakage { .. } | Self::RoundedEdges { .. } => "valve-leakage",
            Self::LaminarTransition { .. } => "laminar-transition",
            Self::Counterbalance(_) => "counterbalance",
            Self::PumpRipple { .. } => "~pump-ripple",
            Self::OtherConsumer { .. } => "~other-consumer",
        }
    }

    /// Number of its own states: the accumulator's deviation from the nominal pressure, relative to the nominal pressure; what load-holding valves have.
    pub(crate) const fn states(&self) -> usize {
        match self {
            Self::SupplyDroop { .. } => 1,
            Self::Counterbalance(_) => load_holding::STATES,
            _ => 0,
        }
    }

    /// Applies the part of the effect that is a property of the edges.
    pub(crate) fn configure(&self, edges: &mut Edges) {
        match *self {
            Self::DeadZone { extending, retracting } => {
                edges.dead_zone[0] += extending;
                edges.dead_zone[1] += retracting;
            }
            Self::Gain(curve) => edges.gain = curve,
            Self::Metering { sizes } => edges.sizes = sizes,
            Self::SupplyDroop { line_pa_s2_per_m6, .. } => edges.supply_line.quadratic = line_pa_s2_per_m6,
            Self::BackPressure { linear_pa_s_per_m3, quadratic_pa_s2_per_m6 } => {
                edges.return_line = SeriesLine { linear: linear_pa_s_per_m3, quadratic: quadratic_pa_s2_per_m6 };
            }
            Self::LaminarTransition { pressure_pa } => edges.laminar_pa = pressure_pa,
            Self::Leakage { .. }
            | Self::RoundedEdges { .. }
            | Self::Counterbalance(_)
            | Self::PumpRipple { .. }
            | Self::OtherConsumer { .. } => {}
        }
    }

    /// What another consumer takes from the supply at a time, m³/s.
    pub(crate) fn taken_m3_per_s(&self, time_s: f64) -> f64 {
        match *self {
            Self::OtherConsumer { flow_m3_per_s, period_s } => {
                flow_m3_per_s * libm::sin(std::f64::consts::PI * time_s / period_s).powi(2)
            }
            _ => 0.0,
        }
    }

    /// Applies the part of the effect that changes the supply.
    pub(crate) fn condition<R: Real>(&self, inputs: &Inputs, own: &[R], conditions: &mut Conditions<R>) {
        match *self {
            Self::SupplyDroop { .. } => {
                if let [fall] = own {
                    conditions.supply = conditions.supply * (*fall + 1.0);
                }
            }
            Self::Counterbalance(holding) => holding.condition(inputs, own, conditions),
            Self::PumpRipple { share, frequency_hz } => {
                let phase = std::f64::consts::TAU * frequency_hz * inputs.time_s;
                let ripple = share * (libm::sin(phase) + 0.3 * libm::sin(2.0 * phase + 1.0));
                conditions.supply = conditions.supply * (1.0 + ripple);
            }
            _ => {}
        }
    }

    /// Applies the part of the effect that has to be integrated or added to the flows.
    pub(crate) fn apply<R: Real>(
        &self,
        edges: &Edges,
        inputs: &Inputs,
        state: &State<R>,
        (own, rates): (&[R], &mut [R]),
        terms: &mut Terms<R>,
    ) {
        match *self {
            Self::SupplyDroop { resistance_pa_s_per_m3, gas_volume_m3, .. } => {
                if let ([fall], [rate]) = (own, rates) {
                    // Gas with p·Vⁿ = const, filled through the pump's resistance, emptied by the flow that the valve takes.
                    const POLYTROPIC: f64 = 1.25;
                    let relative = (*fall + 1.0).at_least(0.02);
                    let filled = *fall * (-inputs.supply_pa / resistance_pa_s_per_m3);
                    let net = filled - terms.delivered;
                    *rate = relative.powf(1.0 + 1.0 / POLYTROPIC) * net * (POLYTROPIC / gas_volume_m3);
                }
            }
            Self::Counterbalance(holding) => holding.apply(edges, inputs, state, (own, rates), terms),
            Self::OtherConsumer { .. } => terms.delivered = terms.delivered + self.taken_m3_per_s(inputs.time_s),
            Self::Leakage { opening, reach, laminar_pa } => {
                let gap = edges.coefficient * opening * libm::exp(-(inputs.spool / reach).powi(2));
                let flow = |across: R| signed_root(across, laminar_pa) * gap;
                let tank = inputs.tank_pressure_pa;
                let through = |port: R| flow(state.supply - port) - flow(port - tank);
                terms.into_a = terms.into_a + through(state.port_a);
                terms.into_b = terms.into_b + through(state.port_b);
            }
            Self::RoundedEdges { play, laminar_pa } => {
                let [extending, retracting] = edges.dead_zone;
                // What an edge passes beyond a sharp one, by the travel past it.
                let more = |past: f64| {
                    let opening = if past > 0.0 { past.hypot(play) - past } else { play / (1.0 - 0.5 * past / play) };
                    edges.coefficient * opening
                };
                let (out, back) = (more(inputs.spool - extending), more(-inputs.spool - retracting));
                let [supply_a, b_tank, supply_b, a_tank] = edges.sizes;
                let flow = |gap: f64, across: R| signed_root(across, laminar_pa) * gap;
                let tank = inputs.tank_pressure_pa;
                terms.into_a = terms.into_a + flow(out * supply_a, state.supply - state.pressure_a)
                    - flow(back * a_tank, state.pressure_a - tank);
                terms.into_b = terms.into_b + flow(back * supply_b, state.supply - state.pressure_b)
                    - flow(out * b_tank, state.pressure_b - tank);
            }
            _ => {}
        }
    }
}
