//! What a fit used of the tolerances of `[fit.tolerance]`.

use identification::experiment::Prepared;
use identification::fit::{Estimate, Free};
use model_core::machine::Parameter;
use recording::Signal;
use simulation::InputPoint;

/// From this share of a tolerance on it is used up. A fit moves ever more stiffly towards the limit, three standard deviations and more up to here,
/// so that only recordings that press for more come so far.
pub(crate) const USED_UP: f64 = 0.95;

/// An effect parameter within its tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerated {
    /// Which.
    pub parameter: Parameter,
    /// The fitted value, SI.
    pub value: f64,
    /// Its standard deviation, SI; NaN where the recordings do not determine it.
    pub std: f64,
    /// The largest magnitude within the tolerance, SI.
    pub most: f64,
    /// Whether the fit used the tolerance up to its end: then there may be more of it than a drive has within its drawing.
    pub at_limit: bool,
}

/// Those of fitted values that are base parameters and no tolerances.
#[must_use]
pub fn not_tolerated(free: &[Free], estimates: &[Estimate]) -> Vec<Estimate> {
    let is_tolerance = |parameter| free.iter().any(|free| free.parameter == parameter && free.tolerance().is_some());
    estimates.iter().filter(|estimate| !is_tolerance(estimate.parameter)).copied().collect()
}

/// Whether one of these recordings has the sensor whose reading a parameter changes, or the parameter is of no such sensor.
pub fn has_sensor<'a>(cases: impl IntoIterator<Item = &'a Prepared>, parameter: Parameter) -> bool {
    use Parameter as P;
    let (signal, driven_by) = match parameter {
        P::PressureAOffset | P::PressureAFactor => (Signal::PressureA, InputPoint::Force),
        P::PressureBOffset | P::PressureBFactor => (Signal::PressureB, InputPoint::Force),
        P::SpoolOffset | P::SpoolFactor => (Signal::Spool, InputPoint::Spool),
        _ => return true,
    };
    cases.into_iter().any(|case| {
        case.stimulus.input_point == driven_by || case.channels.iter().any(|channel| channel.signal == signal)
    })
}

/// Those of fitted values that are tolerances.
#[must_use]
pub fn tolerated(free: &[Free], estimates: &[Estimate]) -> Vec<Tolerated> {
    let of = |estimate: &Estimate| {
        let most = free.iter().find(|free| free.parameter == estimate.parameter)?.tolerance()?;
        let Estimate { parameter, value, std, .. } = *estimate;
        Some(Tolerated { parameter, value, std, most, at_limit: value.abs() > USED_UP * most })
    };
    estimates.iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use identification::fit::Freedom;
    use machine_file::LoadSource;
    use test_press::{press, recorded_for};

    use super::*;

    #[test]
    fn a_sensor_that_no_recording_has_is_none() {
        let machine = press(&[]);
        let sensors = [(Signal::Position, 1e-5), (Signal::PressureA, 1e4)];
        let case = Prepared::new(&recorded_for(&machine, &sensors, 500), &machine, LoadSource::Constant, None).unwrap();
        let has = |parameter| has_sensor([&case], parameter);
        assert!(has(Parameter::PressureAOffset) && has(Parameter::StribeckForce));
        assert!(!has(Parameter::PressureBOffset) && !has(Parameter::SpoolOffset));
    }

    #[test]
    fn a_tolerance_that_is_used_up_is_told_from_one_that_is_not_and_from_a_base_parameter() {
        let within = |parameter, most, is_signed| Free { parameter, freedom: Freedom::Within { most, is_signed } };
        let free = [
            within(Parameter::StribeckForce, 870.0, false),
            within(Parameter::MeteringRatio, 0.08, true),
            within(Parameter::AirShare, 0.01, false),
            Free::around(Parameter::MovingMass, 20.0, 1.0),
        ];
        let estimate = |parameter, value: f64| Estimate { parameter, before: 0.0, value, std: 0.01, at_bound: false };
        let estimates = [
            estimate(Parameter::StribeckForce, 869.0),
            estimate(Parameter::MeteringRatio, -0.078),
            estimate(Parameter::AirShare, 1e-5),
            estimate(Parameter::MovingMass, 21.0),
        ];
        let told: Vec<_> = tolerated(&free, &estimates).iter().map(|one| (one.parameter, one.at_limit)).collect();
        let expected =
            [(Parameter::StribeckForce, true), (Parameter::MeteringRatio, true), (Parameter::AirShare, false)];
        assert_eq!(told, expected);
        assert_eq!(not_tolerated(&free, &estimates), estimates[3..]);
    }
}
