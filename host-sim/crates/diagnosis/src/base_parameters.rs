//! Which values of a machine file a diagnosis may refit.

use identification::fit::{Free, Freedom};
use machine_file::MachineFile;
use model_core::machine::{Machine, Parameter, Tick};
use recording::Recording;
use simulation::{is_carried, is_driven_by_pressures};

/// Base parameters that may move: those of `[fit.sigma]`, else every one that the file gives and that is usually
/// uncertain, by a tenth of its value; and what is within its tolerance by `[fit.tolerance]`.
#[must_use]
pub fn base_parameters(file: &MachineFile) -> Vec<Free> {
    const USUALLY_UNCERTAIN: &[Parameter] = &[
        Parameter::ValveGain,
        Parameter::DeadZone,
        Parameter::RateLimit,
        Parameter::TimeConstant1,
        Parameter::TimeConstant2,
        Parameter::TransportDelay,
        Parameter::FlowCoefficient,
        Parameter::BulkModulus,
        Parameter::ViscousFriction,
        Parameter::PumpDisplacement,
    ];
    let value = |parameter| file.machine.get(parameter);
    let around = |parameter: Parameter, sigma: f64| {
        // A chamber that follows its piston has oil left when the piston is at its end.
        let displaced = match parameter {
            Parameter::VolumeA => Parameter::AreaA,
            Parameter::VolumeB => Parameter::AreaB,
            _ => return Free::around(parameter, value(parameter), sigma),
        };
        let swept_m3 = 0.5 * value(displaced) * value(Parameter::Stroke);
        if value(Parameter::VolumeFollows) > 0.0 && swept_m3 < value(parameter) {
            Free::above(swept_m3, parameter, value(parameter), sigma)
        } else {
            Free::around(parameter, value(parameter), sigma)
        }
    };
    let mut free: Vec<Free> = if file.has_sigma_table {
        file.sigma.iter().map(|(&parameter, &sigma)| around(parameter, sigma)).collect()
    } else {
        let sigma = |parameter: Parameter| 0.1 * value(parameter).abs();
        let given = USUALLY_UNCERTAIN.iter().copied().filter(|parameter| file.given.contains(parameter));
        given
            .filter(|&parameter| sigma(parameter) > 0.0 && sigma(parameter).is_finite())
            .map(|parameter| around(parameter, sigma(parameter)))
            .collect()
    };
    free.extend(file.tolerance.iter().map(|(&parameter, &most)| Free {
        parameter,
        freedom: Freedom::Within {
            most: carried_tolerance(&file.machine, parameter, most),
            is_signed: parameter.description().min < 0.0,
        },
    }));
    free
}

/// As much of a tolerance as the step computes at every tick that computes the drive. The data sheet of a small valve may allow it more, as a
/// tolerance in bar at its full flow.
fn carried_tolerance(machine: &Machine<f64>, parameter: Parameter, most: f64) -> f64 {
    /// From the largest tolerance of a file to nothing of it.
    const HALVINGS: usize = 100;
    let ticks = [Tick::HalfMillisecond, Tick::OneMillisecond, Tick::TwoMilliseconds];
    let ticks: Vec<Tick> = ticks.into_iter().filter(|tick| is_carried(machine, *tick)).collect();
    let is_computed = |value: &f64| {
        let machine = machine.with(&[(parameter, value.min(parameter.description().max))]);
        ticks.iter().all(|tick| is_carried(&machine, *tick))
    };
    let mut halved = std::iter::successors(Some(most), |most| Some(0.5 * most)).take(HALVINGS);
    halved.find(is_computed).unwrap_or(most)
}

/// The base parameters, and what the zeros of two pressure sensors make of a force that is computed from both: a bar on the larger area. It moves the rod as a
/// constant load does.
pub(crate) fn with_zero_of_force(mut free: Vec<Free>, file: &MachineFile, recordings: &[Recording]) -> Vec<Free> {
    /// 0.3 % of 250 bar, and what warms up.
    const ZERO_PA: f64 = 1e5;
    let is_free = free.iter().any(|free| free.parameter == Parameter::LoadForce);
    if !is_free && recordings.iter().any(|recording| is_driven_by_pressures(file.machine.source, recording)) {
        let area = file.machine.get(Parameter::AreaA).max(file.machine.get(Parameter::AreaB));
        free.push(Free::around(Parameter::LoadForce, file.machine.get(Parameter::LoadForce), ZERO_PA * area));
    }
    free
}
