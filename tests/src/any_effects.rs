//! Effects of the valve and the flow link drawn at random, in sizes that suit the machine they come upon.

use model_core::machine::Machine;
use model_core::parameter::Parameter as P;
use proptest::prelude::*;

/// The effects, by their number.
pub const EFFECTS: [&str; 12] = [
    "valve-hysteresis",
    "null-drift",
    "solenoid-saturation",
    "flow-force",
    "dead-zone-asymmetry",
    "flow-gain-nonlinearity",
    "metering-asymmetry",
    "supply-droop",
    "tank-back-pressure",
    "valve-leakage",
    "laminar-transition",
    "spool-stiction",
];

/// The number of `spool-stiction`: the only effect whose last bit may decide.
pub const STICTION: usize = 11;

/// What is drawn: shares of the largest size that any machine is given.
#[derive(Clone, Copy, Debug)]
pub struct SideEffects {
    shares: [f64; 12],
    others: [f64; 9],
}

/// Every effect, in any size.
pub fn any_side_effects() -> impl Strategy<Value = SideEffects> {
    (prop::array::uniform12(0.0..1.0_f64), prop::array::uniform9(0.0..1.0_f64))
        .prop_map(|(shares, others)| SideEffects { shares, others })
}

impl SideEffects {
    /// The machine with those of the effects that `on` says; what has no strength is set for all.
    #[must_use]
    pub fn on(&self, machine: &Machine<f64>, on: impl Fn(usize) -> bool) -> Machine<f64> {
        let supply_pa = machine.get(P::SupplyPressure);
        let coefficient = machine.get(P::FlowCoefficient);
        let both = |share: f64, size: f64| (2.0 * share - 1.0) * size;
        let decades = |share: f64, from: f64, to: f64| from * (to / from).powf(share);
        let s = |index: usize| if on(index) { self.shares[index] } else { 0.0 };
        let signed = |index: usize, size: f64| if on(index) { both(self.shares[index], size) } else { 0.0 };
        let [spread, drift, onset, bend, memory, reach, pairs, ports, directions] = self.others;
        let mut machine = *machine;
        for (parameter, value) in [
            (P::HysteresisWidth, 0.1 * s(0)),
            (P::HysteresisSpread, spread),
            (P::NullDriftTravel, signed(1, 0.1)),
            (P::NullDriftTime, decades(drift, 1e-2, 1e5)),
            (P::SolenoidCurvature, 3.0 * s(2)),
            (P::SolenoidLoss, 0.5 * s(2)),
            (P::SolenoidOnset, 0.8 * onset),
            (P::FlowForce, s(3) / supply_pa),
            (P::DeadZoneDifference, signed(4, 0.2)),
            (P::FlowGainLinear, signed(5, 0.5)),
            (P::FlowGainBeyond, if on(5) { both(bend, 0.5) } else { 0.0 }),
            (P::MeteringRatio, signed(6, 0.5)),
            (P::MeteringPorts, if on(6) { both(ports, 0.3) } else { 0.0 }),
            (P::MeteringDirections, if on(6) { both(directions, 0.2) } else { 0.0 }),
            (P::DroopResistance, 0.3 * s(7) * supply_pa.sqrt() / coefficient),
            (P::DroopTime, if memory < 0.2 { 0.0 } else { decades(memory, 1e-4, 1e3) }),
            (P::ReturnResistance, 0.5 * s(8) / (coefficient * coefficient)),
            (P::ValveLeakageOpening, 0.05 * s(9)),
            (P::ValveLeakageReach, decades(reach, 0.01, 0.5)),
            (P::LaminarPressure, 0.02 * s(10) * supply_pa * pairs),
            (P::StictionBand, 0.05 * s(STICTION)),
        ] {
            machine.set(parameter, value);
        }
        machine
    }
}
