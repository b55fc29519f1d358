//! The drive that the effects are tried on.

use proptest::test_runner::{Config, RngSeed};

use model_core::drive::{Drive, DriveInput, DriveState, Interfaces, Load};
use model_core::effects::{Effect, Link};
use model_core::machine::{Form, Machine, Parameter as P, Source, Tick};
use model_core::number::Scalar;
use model_core::ports::ChamberState;

pub(crate) type State<N> = DriveState<N, 64>;

pub(crate) const TICK: Tick = Tick::OneMillisecond;
/// Position of mid-stroke, and the stroke, m.
pub(crate) const STROKE_M: f64 = 0.3;

/// A 63/40 × 300 mm cylinder with a closed valve at command 0.
pub(crate) fn press() -> Machine<f64> {
    with(
        &Machine::with_defaults(Source::Valve),
        &[
            (P::AreaA, 3.117e-3),
            (P::AreaB, 1.861e-3),
            (P::VolumeA, 5.2e-4),
            (P::VolumeB, 3.3e-4),
            (P::DeadZone, 0.05),
            (P::TimeConstant1, 0.01),
            (P::ViscousFriction, 1e4),
            (P::MovingMass, 50.0),
        ],
    )
}

pub(crate) fn with(machine: &Machine<f64>, changes: &[(P, f64)]) -> Machine<f64> {
    let mut changed = *machine;
    for &(parameter, value) in changes {
        changed.set(parameter, value);
    }
    changed
}

pub(crate) fn drive<N: Scalar<Real = f64>>(machine: &Machine<f64>) -> Drive<N> {
    Drive::new::<64>(machine, TICK).unwrap_or_else(|error| panic!("{error}"))
}

/// At rest, pressures in supply pressures, position in strokes.
pub(crate) fn at_rest<N: Scalar<Real = f64>>(drive: &Drive<N>, [a, b]: [f64; 2], position: f64) -> State<N> {
    drive.at_rest(N::ZERO, ChamberState { a: N::saturated(a), b: N::saturated(b) }, N::travel(position))
}

/// One tick under a force of the oil alone, N.
pub(crate) fn pushed<N: Scalar<Real = f64>>(drive: &Drive<N>, state: &mut State<N>, force_n: f64) -> Interfaces<N> {
    let force = N::saturated(force_n / drive.bases().force_n);
    drive.step(state, DriveInput::Force { from: force, to: force }, Load::NONE)
}

/// One tick under a command, in 10 V.
pub(crate) fn commanded<N: Scalar<Real = f64>>(drive: &Drive<N>, state: &mut State<N>, command: f64) -> Interfaces<N> {
    drive.step(state, DriveInput::Command(N::saturated(command)), Load::NONE)
}

/// A command that goes out, rests, comes back and reverses quickly.
pub(crate) fn command(tick: usize) -> f64 {
    [0.5, 0.0, -0.6, 0.3, -0.3, 0.9, 0.0, -0.8][tick / 150 % 8]
}

/// Sets the measured temperature of the oil, °C.
pub(crate) fn oil_at<N: Scalar<Real = f64>>(drive: &Drive<N>, state: &mut State<N>, temperature_c: f64) {
    state.oil_temperature = N::saturated(temperature_c / drive.bases().temperature_c);
}

pub(crate) fn velocity_m_per_s<N: Scalar<Real = f64>>(drive: &Drive<N>, state: &State<N>) -> f64 {
    state.motion.velocity.to_f64() * drive.bases().velocity_m_per_s
}

pub(crate) fn position_m<N: Scalar<Real = f64>>(drive: &Drive<N>, state: &State<N>) -> f64 {
    N::strokes(state.motion.position) * drive.bases().stroke_m
}

pub(crate) fn cases(cases: u32) -> Config {
    Config { cases, rng_seed: RngSeed::Fixed(20_200), failure_persistence: None, ..Config::default() }
}

/// The strong forms of every effect in the table that acts on a valve-controlled drive.
pub(crate) fn every_effect() -> impl Iterator<Item = (Effect, &'static Form)> {
    let on_a_valve = Effect::ALL.iter().filter(|effect| **effect != Effect::PumpSlip);
    on_a_valve.flat_map(|effect| effect.strong().iter().map(|form| (*effect, form)))
}

/// Those of chambers, mechanics and sensors.
pub(crate) fn effects() -> impl Iterator<Item = (Effect, &'static Form)> {
    every_effect().filter(|(effect, _)| matches!(effect.link(), Link::Chambers | Link::Mechanics | Link::Sensing))
}
