//! The first search of a drive that is known only roughly: from several starts, and in stages.
//!
//! With many free values a search from the nominal ones ends in a valley where a wrong spool is made up for by a wrong flow. Where the spool was
//! recorded, the valve is therefore fitted to it alone, then what is below to the other signals, driven by the recorded spool, and all values together
//! only from there. Of this search and those from the nominal values the best is taken: none is worse for the others.

use model_core::effects::Link;
use model_core::machine::{Machine, Parameter};
use recording::Signal;

use super::{Fit, FitError, Free, From, StartState, fit, set_tolerances};
use crate::experiment::Prepared;
use crate::parallel;

/// How much harder a spool can be pulled than its largest speed takes, where the pull is limited and where the speed alone is.
pub const STRUCTURES: [f64; 2] = [0.05, 20.0];

/// Parameters of the valve itself, without its effects.
pub const OF_VALVE: &[Parameter] = &[
    Parameter::ValveGain,
    Parameter::ValveOffset,
    Parameter::RateLimit,
    Parameter::TimeConstant1,
    Parameter::TimeConstant2,
    Parameter::NaturalFrequency,
    Parameter::SpoolDamping,
    Parameter::SpoolSpeedLimit,
    Parameter::SpeedOverdrive,
    Parameter::TransportDelay,
];

/// Whether a parameter changes what the spool's sensor reads.
#[must_use]
pub fn moves_spool(parameter: Parameter) -> bool {
    parameter.effect().is_some_and(|effect| effect.link() == Link::Valve)
        || matches!(parameter, Parameter::SpoolOffset | Parameter::SpoolFactor)
        || OF_VALVE.contains(&parameter)
}

/// The best fit from the nominal values: where the valve's structure is known, by one search.
pub fn first_search(
    machine: &Machine<f64>,
    free: &[Free],
    cases: &[&Prepared],
    precision: f64,
) -> Result<Fit, FitError> {
    let Some(overdrive) = free.iter().find(|free| free.parameter == Parameter::SpeedOverdrive) else {
        return fit(machine, free, cases, &From::default(), precision);
    };
    let mut found = of_each_structure(machine, free, cases, overdrive, precision)?;
    if let Some(sides) = Sides::of(cases) {
        let (of_valve, below): (Vec<Free>, Vec<Free>) = free.iter().partition(|free| moves_spool(free.parameter));
        let spools: Vec<&Prepared> = sides.valve.iter().collect();
        let valve = best(of_each_structure(machine, &of_valve, &spools, overdrive, precision)?);
        let others: Vec<&Prepared> = sides.below.iter().collect();
        let driven = fit(&valve.machine, &below, &others, &From::default(), precision)?.beside(&valve);
        found.push(fit(machine, free, cases, &From { solution: Some(&driven), ..From::default() }, precision)?);
    }
    Ok(best(found))
}

/// A fit from each structure that the valve may have: nobody knows whether the speed of a spool is limited or the pull on it, and from one of these a
/// search does not come to the other.
fn of_each_structure(
    machine: &Machine<f64>,
    free: &[Free],
    cases: &[&Prepared],
    overdrive: &Free,
    precision: f64,
) -> Result<Vec<Fit>, FitError> {
    let structures = STRUCTURES.map(|value| [(overdrive.parameter, overdrive.coordinate(value))]);
    parallel::try_each(&structures, |start| {
        fit(machine, free, cases, &From { coordinates: start, ..From::default() }, precision)
    })
}

/// The structure that the valve of a machine does not have, if nobody knows which it is: the parameter and its value.
#[must_use]
pub fn other_structure(machine: &Machine<f64>, free: &[Free]) -> Option<(Parameter, f64)> {
    let overdrive = free.iter().find(|free| free.parameter == Parameter::SpeedOverdrive)?.parameter;
    let [of_pull, of_speed] = STRUCTURES;
    Some((overdrive, if machine.get(overdrive) > 1.0 { of_pull } else { of_speed }))
}

/// What moves the spool, fitted to the spool alone, and the recordings judged by it; `None` unless each recording has the spool and other signals, and
/// nobody knows the valve's structure.
pub fn spool_alone(
    machine: &Machine<f64>,
    free: &[Free],
    cases: &[Prepared],
) -> Result<Option<(Fit, Vec<Prepared>)>, FitError> {
    const PRECISION: f64 = 1e-6;
    let of_valve: Vec<Free> = free.iter().filter(|free| moves_spool(free.parameter)).copied().collect();
    let overdrive = of_valve.iter().find(|free| free.parameter == Parameter::SpeedOverdrive);
    let (Some(overdrive), Some(Sides { mut valve, .. })) = (overdrive, Sides::of(&cases.iter().collect::<Vec<_>>()))
    else {
        return Ok(None);
    };
    set_tolerances(machine, &mut valve, &vec![StartState::default(); cases.len()])?;
    let spools: Vec<&Prepared> = valve.iter().collect();
    let fit = best(of_each_structure(machine, &of_valve, &spools, overdrive, PRECISION)?);
    Ok(Some((fit, valve)))
}

/// The one with the least loss.
fn best(fits: Vec<Fit>) -> Fit {
    fits.into_iter().min_by(|a, b| a.loss.total_cmp(&b.loss)).expect("there is at least one start")
}

/// Recordings judged by the spool alone, and by the other signals with the recorded spool metering the oil.
struct Sides {
    valve: Vec<Prepared>,
    below: Vec<Prepared>,
}

impl Sides {
    /// `None` unless each recording has both.
    fn of(cases: &[&Prepared]) -> Option<Self> {
        let following =
            |case: &&Prepared| case.following().map(|case| case.judged_by(|signal| signal != Signal::Spool));
        let below: Vec<Prepared> = cases.iter().map(following).collect::<Option<_>>()?;
        let valve = cases.iter().map(|case| case.judged_by(|signal| signal == Signal::Spool)).collect();
        below.iter().all(|case| !case.channels.is_empty()).then_some(Self { valve, below })
    }
}
