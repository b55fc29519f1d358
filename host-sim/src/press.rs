//! The drive that tests use: a valve on a 63/40 × 300 mm cylinder.

use model_core::machine::{Machine, Source};
use model_core::parameter::Parameter;

use crate::hypothesis::Scene;
use crate::machine_file::LoadSource;
use crate::recording::Signal;
use crate::simulate::EntryPoint;

/// The press, with what a test sets beside its cylinder, the valve's gain and its speed.
pub(crate) fn press(further: &[(Parameter, f64)]) -> Machine<f64> {
    let mut machine = Machine::with_defaults(Source::Valve);
    let always = [
        (Parameter::AreaA, 3.117e-3),
        (Parameter::AreaB, 1.861e-3),
        (Parameter::VolumeA, 5.2e-4),
        (Parameter::VolumeB, 3.3e-4),
        (Parameter::ValveGain, 0.0559),
        (Parameter::TimeConstant1, 0.018),
        (Parameter::RateLimit, 12.0),
    ];
    for (parameter, value) in always.iter().chain(further) {
        machine.set(*parameter, *value);
    }
    machine
}

/// The press with the paper's valve: a dead zone, an offset, two lags and a delay, a light rod and viscous friction.
pub(crate) fn with_papers_valve() -> Machine<f64> {
    use Parameter as P;
    press(&[
        (P::ValveOffset, 0.0345),
        (P::DeadZone, 0.105),
        (P::TimeConstant2, 0.0279),
        (P::TransportDelay, 0.007),
        (P::MovingMass, 18.3),
        (P::ViscousFriction, 1.0e5),
    ])
}

/// What is known of it where these signals are measured: driven by its command over most of its stroke, for 5 s.
pub(crate) fn scene<'a>(machine: &'a Machine<f64>, judged: &'a [Signal]) -> Scene<'a> {
    Scene {
        machine,
        entry: EntryPoint::Command,
        load: LoadSource::Constant,
        judged,
        travel_m: (0.05, 0.25),
        duration_s: 5.0,
    }
}
