//! Load-holding (counterbalance) valves between the valve and the chambers.

use crate::flow::edges::{Edges, Ports};
use crate::flow::orifice::signed_root;
use crate::tangent::Real;
use crate::terms::{Conditions, Inputs, State, Terms};

/// Between each port and its chamber: a check valve into the chamber, and out of it a poppet that the chamber's own pressure and, as often as the pilot
/// ratio says, the other port's push open.
///
/// The port between valve and poppet has a volume and so a pressure of its own, from which the other side's poppet is piloted. The poppet's area grows faster
/// than its lift, which begins gradually and follows with a lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadHolding {
    /// Pressure of A and of B that opens its poppet without a pilot, Pa; infinite where there is no such valve.
    pub settings_pa: [f64; 2],
    /// How many times as much as the chamber's own pressure the other port's counts.
    pub pilot_ratio: f64,
    /// Pressure beyond the setting that lifts the poppet by 1: it is then as wide as a metering edge at full travel.
    pub span_pa: f64,
    /// Time constant of the lift, s.
    pub time_constant_s: f64,
}

/// A port's pressure over the supply's, and a poppet's lift: of A, then of B.
pub(super) const STATES: usize = 4;

/// Oil between valve and poppet, m³, and its stiffness, Pa.
const PORT_M3: f64 = 6e-5;
const MODULUS_PA: f64 = 1.2e9;
/// A check valve's size over a metering edge's.
const CHECK: f64 = 4.0;
/// Largest lift.
const LIFT: f64 = 2.0;
/// Lift over which a poppet begins to move.
const GRADUAL: f64 = 0.02;
/// Pressure difference up to which both valves are laminar, Pa.
const LAMINAR_PA: f64 = 2e4;

impl LoadHolding {
    fn has(&self, side: usize) -> bool {
        self.settings_pa[side].is_finite()
    }

    /// The valve sees the ports and not the chambers.
    pub(super) fn condition<R: Real>(&self, inputs: &Inputs, own: &[R], conditions: &mut Conditions<R>) {
        for (side, port) in conditions.ports.iter_mut().enumerate() {
            if self.has(side) {
                *port = Some(own[2 * side] * inputs.supply_pa);
            }
        }
    }

    /// Replaces the valve's flow into each chamber by that through check valve and poppet.
    pub(super) fn apply<R: Real>(
        &self,
        edges: &Edges,
        inputs: &Inputs,
        state: &State<R>,
        (own, rates): (&[R], &mut [R]),
        terms: &mut Terms<R>,
    ) {
        let (a, b) = (state.port_a, state.port_b);
        let ports = Ports { supply: state.supply, tank_pa: inputs.tank_pressure_pa, a, b };
        let (into_a, from_b) = edges.flows(inputs.spool, &ports);
        let [mut beside_a, mut beside_b] = [R::from(0.0); 2];
        let sides = [(state.pressure_a, a, b, into_a, &mut beside_a), (state.pressure_b, b, a, -from_b, &mut beside_b)];
        for (side, (chamber, port, other, metered, beside)) in sides.into_iter().enumerate() {
            if !self.has(side) {
                continue;
            }
            let lift = own[2 * side + 1];
            let area = lift * (lift * 0.2 + 0.8);
            let root = signed_root(port - chamber, LAMINAR_PA) * edges.coefficient;
            let through = root.at_least(0.0) * CHECK + root.at_most(0.0) * area;
            let beyond = (chamber + other * self.pilot_ratio - self.settings_pa[side]) / self.span_pa;
            let wanted = ((beyond + (beyond * beyond + GRADUAL * GRADUAL).sqrt()) * 0.5).at_most(LIFT);
            rates[2 * side] = (metered - through) * (MODULUS_PA / PORT_M3 / inputs.supply_pa);
            rates[2 * side + 1] = (wanted - lift) / self.time_constant_s;
            *beside = through - metered;
        }
        terms.into_a = terms.into_a + beside_a;
        terms.into_b = terms.into_b + beside_b;
    }
}
