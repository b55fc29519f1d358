//! Effects drawn at random, in sizes that suit the given machine: effects of the valve and the flow link by number, and effects of every link.

use proptest::prelude::*;

use model_core::effects::Effect;
use model_core::machine::{Machine, Parameter as P};

/// The effects, by their number.
pub const EFFECTS: [Effect; 12] = [
    Effect::ValveHysteresis,
    Effect::NullDrift,
    Effect::SolenoidSaturation,
    Effect::FlowForce,
    Effect::DeadZoneAsymmetry,
    Effect::FlowGainNonlinearity,
    Effect::MeteringAsymmetry,
    Effect::SupplyDroop,
    Effect::TankBackPressure,
    Effect::ValveLeakage,
    Effect::LaminarTransition,
    Effect::SpoolStiction,
];

/// The number of `spool-stiction`: the only effect whose last bit may decide.
pub const STICTION: usize = 11;

/// The drawn numbers: shares of the largest size that any machine is given.
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

/// From −size to size.
fn both(share: f64, size: f64) -> f64 {
    (2.0 * share - 1.0) * size
}

/// Lowest possible floor of the pressures, Pa.
const VACUUM_PA: f64 = -1.013e5;
/// Value that switches this effect off: its floor of 0 is a floor as well.
pub const NO_FLOOR: (P, f64) = (P::CavitationFloor, -1e9);

/// Evenly over the decades between two values.
fn decades(share: f64, from: f64, to: f64) -> f64 {
    from * (to / from).powf(share)
}

impl SideEffects {
    /// The machine with those of the effects that `on` selects; parameters that are not amounts are set for all effects.
    #[must_use]
    pub fn on(&self, machine: &Machine<f64>, on: impl Fn(usize) -> bool) -> Machine<f64> {
        let supply_pa = machine.get(P::SupplyPressure);
        let coefficient = machine.get(P::FlowCoefficient);
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
            (P::EdgeRounding, if on(9) { 0.1 * reach } else { 0.0 }),
            (P::LaminarPressure, 0.02 * s(10) * supply_pa * pairs),
            (P::StictionBand, 0.05 * s(STICTION)),
        ] {
            machine.set(parameter, value);
        }
        machine
    }
}

/// Effects that are not drawn here: leakage past the piston, hoses and Coulomb friction come with the machines, and a valve-controlled
/// drive has no pump; a load-holding valve, whose pilot may keep a drive swinging, has its own laws in model-core (`tests/effects/load_holding.rs`).
/// A new effect belongs in one of the three lists.
pub const NOT_DRAWN: [Effect; 5] = [
    Effect::InternalLeakage,
    Effect::HoseCompliance,
    Effect::CoulombFriction,
    Effect::PumpSlip,
    Effect::Counterbalance,
];

/// The effects behind the valve and the flow link that [`AnyEffects`] draws, by their number.
const BEHIND: [Effect; 15] = [
    Effect::ExternalLeakage,
    Effect::EntrainedAir,
    Effect::PositionDependentVolume,
    Effect::StribeckFriction,
    Effect::FrictionAsymmetry,
    Effect::PositionDependentFriction,
    Effect::PressureDependentFriction,
    Effect::PositionDependentLoad,
    Effect::EndStop,
    Effect::Presliding,
    Effect::LinkageBacklash,
    Effect::PositionSensorLag,
    Effect::SensorOffset,
    Effect::OilTemperature,
    Effect::Cavitation,
];

/// All effects that [`AnyEffects`] draws, by their number.
pub fn every_drawn() -> impl Iterator<Item = Effect> {
    EFFECTS.into_iter().chain(BEHIND)
}

/// Shares of the amounts behind the flow link.
const AMOUNTS: usize = 29;

/// Effects of every link, any of them on; no unnamed table.
#[derive(Clone, Debug)]
pub struct AnyEffects {
    side: SideEffects,
    which: u32,
    amounts: Vec<f64>,
    forms: [f64; 9],
}

/// No effect, one alone, a few, about half of them.
pub fn any_effects() -> impl Strategy<Value = AnyEffects> {
    let bits = 0..EFFECTS.len() + BEHIND.len();
    let which = prop_oneof![
        1 => Just(0_u32),
        3 => bits.clone().prop_map(|bit| 1 << bit),
        3 => prop::collection::vec(bits, 2..5).prop_map(|bits| bits.into_iter().fold(0, |which, bit| which | 1 << bit)),
        2 => any::<u32>(),
    ];
    let amounts = prop::collection::vec(0.0..1.0_f64, AMOUNTS);
    (any_side_effects(), which, amounts, prop::array::uniform9(0.0..1.0_f64))
        .prop_map(|(side, which, amounts, forms)| AnyEffects { side, which, amounts, forms })
}

impl AnyEffects {
    /// Whether the effect of this number is on, in the order of [`every_drawn`].
    #[must_use]
    pub fn has(&self, number: usize) -> bool {
        self.which >> number & 1 == 1
    }

    /// The same effects, none of them on.
    #[must_use]
    pub fn off(&self) -> Self {
        Self { which: 0, ..self.clone() }
    }

    /// The machine with the effects that are on; parameters that are not amounts are set for all effects.
    ///
    /// # Panics
    /// More amounts are asked for than are drawn.
    #[must_use]
    pub fn on(&self, machine: &Machine<f64>) -> Machine<f64> {
        let is_on = |effect: Effect| every_drawn().zip(0..).any(|(known, number)| known == effect && self.has(number));
        let mut left = self.amounts.iter();
        let mut amount = |effect: Effect| {
            let share = *left.next().expect("a share is drawn for each");
            if is_on(effect) { share } else { 0.0 }
        };
        let signed = |share: f64, size: f64| if share == 0.0 { 0.0 } else { both(share, size) };
        let [fall, stiffness, damping, within, warms, lags, bristles, at_c, reach] = self.forms;
        let (supply_pa, stroke_m) = (machine.get(P::SupplyPressure), machine.get(P::Stroke));
        let force_n = machine.get(P::AreaB) * supply_pa;
        let laminar = 0.05 * machine.get(P::FlowCoefficient) / supply_pa.sqrt();
        // A load that grows with the square of the position runs away where nothing stops the rod.
        let stops = amount(Effect::EndStop) > 0.0 || is_on(Effect::PositionDependentLoad);
        let reach_m = stroke_m * (0.2 + 0.3 * within);
        // So stiff that the drive's full force compresses the stop by a thousandth to a tenth of the stroke.
        let stop_n_per_m = force_n / stroke_m * decades(stiffness, 10.0, 1000.0);
        let values = [
            (P::ExternalLeakageA, amount(Effect::ExternalLeakage) * laminar),
            (P::ExternalLeakageB, amount(Effect::ExternalLeakage) * laminar),
            (P::AirShare, 0.05 * amount(Effect::EntrainedAir)),
            (P::VolumeShare, amount(Effect::PositionDependentVolume)),
            (P::StribeckForce, 0.05 * force_n * amount(Effect::StribeckFriction)),
            (P::StribeckExcess, 0.05 * force_n * amount(Effect::StribeckFriction)),
            (P::StribeckVelocity, decades(fall, 1e-3, 0.1)),
            (P::AsymmetricExtending, 0.05 * force_n * amount(Effect::FrictionAsymmetry)),
            (P::AsymmetricRetracting, 0.05 * force_n * amount(Effect::FrictionAsymmetry)),
            (P::PositionFriction, 0.05 * force_n * amount(Effect::PositionDependentFriction)),
            (P::PositionFrictionSlope, signed(amount(Effect::PositionDependentFriction), 0.03 * force_n)),
            (P::PositionFrictionBow, signed(amount(Effect::PositionDependentFriction), 0.03 * force_n)),
            (P::PositionDragSlope, signed(amount(Effect::PositionDependentFriction), 0.5)),
            (P::PositionDragBow, signed(amount(Effect::PositionDependentFriction), 0.5)),
            (P::PressureFriction, 0.02 * machine.get(P::AreaB) * amount(Effect::PressureDependentFriction)),
            (P::LoadSpring, signed(amount(Effect::PositionDependentLoad), 0.3 * force_n / stroke_m)),
            (P::LoadSpringForce, signed(amount(Effect::PositionDependentLoad), 0.1 * force_n)),
            (P::LoadSpringBow, signed(amount(Effect::PositionDependentLoad), 0.3 * force_n / (stroke_m * stroke_m))),
            (P::StopStiffness, if stops { stop_n_per_m } else { 0.0 }),
            (P::StopDamping, if stops { decades(damping, 1e2, 1e6) } else { 0.0 }),
            (P::StopRetracted, 0.5 * stroke_m - reach_m),
            (P::StopExtended, 0.5 * stroke_m + reach_m),
            (P::PreslidingForce, 0.05 * force_n * amount(Effect::Presliding)),
            (P::PreslidingStiffness, if amount(Effect::Presliding) > 0.0 { decades(bristles, 1e6, 1e9) } else { 0.0 }),
            (P::BacklashPlay, 1e-3 * amount(Effect::LinkageBacklash)),
            (P::PositionLag, 0.05 * amount(Effect::PositionSensorLag)),
            (P::PositionDelay, 0.02 * lags * amount(Effect::PositionSensorLag)),
            (P::PressureAOffset, signed(amount(Effect::SensorOffset), 0.02 * supply_pa)),
            (P::SpoolOffset, signed(amount(Effect::SensorOffset), 0.02)),
            (P::PositionFactor, signed(amount(Effect::SensorOffset), 0.02)),
            (P::ViscosityLoss, signed(amount(Effect::OilTemperature), 0.8)),
            (P::WarmingTime, decades(warms, 0.1, 10.0)),
            (P::ViscosityLossPerKelvin, 0.05 * amount(Effect::OilTemperature)),
            (P::ReferenceTemperature, 80.0 * at_c),
            (P::FlowGainNotch, 0.02 + 0.5 * reach),
            // At most 0: the tank pressure is never below that.
            (
                P::CavitationFloor,
                if is_on(Effect::Cavitation) { VACUUM_PA * amount(Effect::Cavitation) } else { NO_FLOOR.1 },
            ),
        ];
        self.side.on(machine, |number| self.has(number)).with(&values)
    }
}

/// Parameters of a load that depends on the position.
pub const LOAD: [P; 3] = [P::LoadSpring, P::LoadSpringForce, P::LoadSpringBow];
/// Parameters of the end stops.
pub const STOPS: [P; 2] = [P::StopStiffness, P::StopDamping];
/// Parameters of presliding.
pub const LUGRE: [P; 2] = [P::PreslidingForce, P::PreslidingStiffness];

/// The machine with these parameters switched off.
#[must_use]
pub fn without(machine: &Machine<f64>, none: &[P]) -> Machine<f64> {
    let none: Vec<(P, f64)> = none.iter().map(|&parameter| (parameter, 0.0)).collect();
    machine.with(&none)
}

/// The machine with an overlap, so that no edge of the valve is open on both sides of the centre, however the sides differ.
#[must_use]
pub fn overlapped(machine: &Machine<f64>) -> Machine<f64> {
    machine.with(&[(P::DeadZone, machine.get(P::DeadZone).max(0.01 + machine.get(P::DeadZoneDifference).abs()))])
}
