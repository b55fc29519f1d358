//! A drive with two equal sides does not distinguish left from right; the mirror image of any other drive makes the mirrored motion.

use proptest::prelude::*;

use model_core::drive::{Drive, DriveInput, Load};
use model_core::machine::{Machine, Parameter as P, Tick};
use model_core::number::{PerUnit, Scalar};
use model_core::ports::{ChamberState, Spool};
use recording::excitation::signals::Excitation;
use system_tests::any_effects::{LUGRE, STOPS, any_effects, without};
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::simulate::{DELAY, Distance, Row, State, core, distance, drive};
use virtual_plant::InitialState;

use super::cases;

/// Parameters that make one side differ from the other: a drive with two equal sides has none of them.
const ONE_SIDED: [P; 13] = [
    P::ValveOffset,
    P::LoadForce,
    P::NullDriftTravel,
    P::DeadZoneDifference,
    P::MeteringPorts,
    P::MeteringDirections,
    P::ExternalLeakageA,
    P::ExternalLeakageB,
    P::PositionFrictionSlope,
    P::PositionDragSlope,
    P::LoadSpringForce,
    P::LoadSpringBow,
    P::AsymmetricExtending,
];

fn alike_on_both_sides(machine: &Machine<f64>) -> Machine<f64> {
    // The larger oil column: with it the drive certainly fits the format.
    let volume_m3 = machine.get(P::VolumeA).max(machine.get(P::VolumeB));
    without(machine, &ONE_SIDED).with(&[
        (P::AreaA, machine.get(P::AreaB)),
        (P::VolumeA, volume_m3),
        (P::VolumeB, volume_m3),
        (P::AsymmetricRetracting, 0.0),
    ])
}

/// The same drive with its chambers exchanged: it extends where the other retracts.
fn mirror_image(machine: &Machine<f64>) -> Machine<f64> {
    let exchanged = [
        (P::AreaA, P::AreaB),
        (P::VolumeA, P::VolumeB),
        (P::ExternalLeakageA, P::ExternalLeakageB),
        (P::AsymmetricExtending, P::AsymmetricRetracting),
    ];
    let turned = [
        P::ValveOffset,
        P::LoadForce,
        P::NullDriftTravel,
        P::DeadZoneDifference,
        P::PositionFrictionSlope,
        P::PositionDragSlope,
        P::LoadSpringForce,
        P::LoadSpringBow,
    ];
    let stroke_m = machine.get(P::Stroke);
    // The other edges are sized relative to the supply edge of A while extending; in the image that edge is the one of B while retracting.
    let [ports, directions] = [P::MeteringPorts, P::MeteringDirections].map(|more| 1.0 + machine.get(more));
    let mut image = machine.with(&turned.map(|parameter| (parameter, -machine.get(parameter)))).with(&[
        (P::StopRetracted, stroke_m - machine.get(P::StopExtended)),
        (P::StopExtended, stroke_m - machine.get(P::StopRetracted)),
        (P::FlowCoefficient, machine.get(P::FlowCoefficient) * ports * directions),
        // The leakage of all edges at the centre is sized relative to that edge too.
        (P::ValveLeakageOpening, machine.get(P::ValveLeakageOpening) / (ports * directions)),
        (P::MeteringPorts, 1.0 / ports - 1.0),
        (P::MeteringDirections, 1.0 / directions - 1.0),
    ]);
    for (one, other) in exchanged {
        image = image.with(&[(one, machine.get(other)), (other, machine.get(one))]);
    }
    image
}

/// Without effects in which the last bit decides: whether a rod or a spool sticks, or in which tick a rod meets a stop.
fn without_decisions(machine: &Machine<f64>) -> Machine<f64> {
    let deciding = [
        P::CoulombFriction,
        P::StribeckForce,
        P::StribeckExcess,
        P::AsymmetricExtending,
        P::AsymmetricRetracting,
        P::PositionFriction,
        P::PositionFrictionSlope,
        P::PositionFrictionBow,
        P::PressureFriction,
        P::StictionBand,
    ];
    without(machine, &[&deciding[..], &LUGRE, &STOPS].concat())
}

/// Without a flow limit, at which some drives oscillate forever (`settling`), and rounding errors with them.
fn unlimited(machine: &Machine<f64>) -> Machine<f64> {
    machine.with(&[(P::FlowLimit, f64::INFINITY)])
}

/// Without effects that depend on the position, except those that decide something.
fn without_places(machine: &Machine<f64>) -> Machine<f64> {
    without(machine, &[P::VolumeShare, P::PositionDragBow, P::LoadSpring])
}

/// Size to which rounding of f64 grows where edges keep a drive from settling: strokes, and supply pressures.
const ALIKE: f64 = 1e-5;

/// Distance of a drive from its mirror image under the mirrored command, from `start_m` and from the same distance to the other end.
fn unlikeness<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, seed: u64, start_m: f64) -> Distance {
    let volts = Excitation::random_steps(seed).sample(tick.seconds());
    let mirrored: Vec<f64> = volts.iter().map(|volts| -volts).collect();
    let initial = InitialState::at_rest(machine, start_m);
    let image = mirror_image(machine);
    let beside = InitialState {
        pressure_a_pa: initial.pressure_b_pa,
        pressure_b_pa: initial.pressure_a_pa,
        position_m: machine.get(P::Stroke) - start_m,
        ..initial
    };
    let there = core::<N>(machine, tick, &volts, &initial);
    let back: Vec<Row> = core::<N>(&image, tick, &mirrored, &beside)
        .into_iter()
        .map(|row| Row { pressure_a: row.pressure_b, pressure_b: row.pressure_a, position: 1.0 - row.position })
        .collect();
    distance(&there, &back)
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn a_mirrored_command_mirrors_the_motion(
        machine in any_machine(),
        tick in any_tick(),
        effects in any_effects(),
        seed in any::<u64>(),
    ) {
        let machine = without_decisions(&without_places(&alike_on_both_sides(&effects.on(&machine))));
        prop_assume!(Drive::<PerUnit>::new::<DELAY>(&machine, tick).is_ok());
        let real = unlikeness::<f64>(&machine, tick, seed, 0.0);
        prop_assert!(real.position < ALIKE && real.pressure < ALIKE, "{real:?}");
        // In fixed point, halves are rounded up on both sides.
        let fixed = unlikeness::<PerUnit>(&unlimited(&machine), tick, seed, 0.0);
        prop_assert!(fixed.position < 2e-5 && fixed.pressure < 2e-5, "in fixed point {fixed:?}");
    }

    /// In f64: the scales of the fixed-point format depend on side A.
    #[test]
    fn the_mirror_image_of_any_drive_moves_as_its_mirror_image(
        machine in any_machine(),
        tick in any_tick(),
        effects in any_effects(),
        seed in any::<u64>(),
        start in 0.0..1.0_f64,
    ) {
        // The least volume of a chamber far beyond the stroke is set by the format. Without stops, a load that pushes away from the middle never
        // stops.
        let machine = unlimited(&without_decisions(&effects.on(&machine)));
        let machine = machine.with(&[
            (P::VolumeShare, 0.0),
            (P::LoadSpring, machine.get(P::LoadSpring).abs()),
            (P::LoadSpringBow, 0.0),
        ]);
        let both_fit = [machine, mirror_image(&machine)].map(|machine| Drive::<f64>::new::<DELAY>(&machine, tick).is_ok());
        prop_assume!(both_fit == [true; 2]);
        let real = unlikeness::<f64>(&machine, tick, seed, start * machine.get(P::Stroke));
        prop_assert!(real.position < ALIKE && real.pressure < ALIKE, "{real:?}");
    }
}

/// Any state of a drive: spool before and after the tick, pressures, velocity (per unit) and position (strokes).
type Moment = [f64; 6];

/// Both pressures, velocity and position one tick after this state.
fn after_a_tick(machine: &Machine<f64>, tick: Tick, [from, to, a, b, velocity, position]: Moment) -> [f64; 4] {
    let drive = drive::<f64>(machine, tick);
    let mut state: State<f64> = drive.at_rest(0.0, ChamberState { a, b }, position);
    state.motion.velocity = velocity;
    drive.step(&mut state, DriveInput::Spool(Spool { from, to }), Load::NONE);
    [state.chambers.a, state.chambers.b, state.motion.velocity, state.motion.position]
}

proptest! {
    #![proptest_config(cases(2000))]

    /// All effects are on, dry friction and stops as well: within one tick, no decision of the last bit has accumulated. Excluded are volumes that
    /// follow the piston, because their least volume is set by the format.
    #[test]
    fn a_tick_of_the_mirror_image_is_the_mirror_image_of_the_tick(
        machine in any_machine(),
        tick in any_tick(),
        effects in any_effects(),
        moment in prop::array::uniform6(-1.0..1.0_f64),
        place in 0.0..1.0_f64,
    ) {
        let machine = without(&effects.on(&machine), &[P::VolumeShare]);
        let image = mirror_image(&machine);
        prop_assume!([machine, image].map(|machine| Drive::<f64>::new::<DELAY>(&machine, tick).is_ok()) == [true; 2]);
        let [from, to, a, b, velocity, _] = moment;
        let there = after_a_tick(&machine, tick, [from, to, a, b, velocity, place]);
        // The base of velocities depends on side A.
        let base = |machine: &Machine<f64>| drive::<f64>(machine, tick).bases().velocity_m_per_s;
        let ratio = base(&machine) / base(&image);
        let back = after_a_tick(&image, tick, [-from, -to, b, a, -velocity * ratio, 1.0 - place]);
        let back = [back[1], back[0], -back[2] / ratio, 1.0 - back[3]];
        for (there, back) in there.into_iter().zip(back) {
            prop_assert!((there - back).abs() < 1e-9 * there.abs().max(1.0), "{there} {back}");
        }
    }
}
