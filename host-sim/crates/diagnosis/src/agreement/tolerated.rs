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
    /// Where only a part of the tolerance is left, around a value of then: that value, if the fit used up the part. Then it may have changed, within the
    /// drawing.
    pub left_then: Option<f64>,
}

/// Those of fitted values that are base parameters and no tolerances.
#[must_use]
pub fn not_tolerated(free: &[Free], estimates: &[Estimate]) -> Vec<Estimate> {
    let is_tolerance = |parameter| free.iter().any(|free| free.parameter == parameter && free.tolerance().is_some());
    estimates.iter().filter(|estimate| !is_tolerance(estimate.parameter)).copied().collect()
}

/// The signal whose sensor reads otherwise by a parameter, of the signals that every drive has not.
#[must_use]
pub fn sensor_of(parameter: Parameter) -> Option<Signal> {
    use Parameter as P;
    match parameter {
        P::PressureAOffset | P::PressureAFactor => Some(Signal::PressureA),
        P::PressureBOffset | P::PressureBFactor => Some(Signal::PressureB),
        P::SpoolOffset | P::SpoolFactor => Some(Signal::Spool),
        _ => None,
    }
}

/// Whether one of these recordings has the sensor whose reading a parameter changes, or the parameter is of no such sensor.
pub fn has_sensor<'a>(cases: impl IntoIterator<Item = &'a Prepared>, parameter: Parameter) -> bool {
    let Some(signal) = sensor_of(parameter) else { return true };
    let driven_by = if signal == Signal::Spool { InputPoint::Spool } else { InputPoint::Force };
    cases.into_iter().any(|case| {
        case.stimulus.input_point == driven_by || case.channels.iter().any(|channel| channel.signal == signal)
    })
}

/// Those of fitted values that are tolerances.
#[must_use]
pub fn tolerated(free: &[Free], estimates: &[Estimate]) -> Vec<Tolerated> {
    let of = |estimate: &Estimate| {
        let free = free.iter().find(|free| free.parameter == estimate.parameter)?;
        let most = free.tolerance()?;
        let Estimate { parameter, value, std, .. } = *estimate;
        let at_limit = value.abs() > USED_UP * most;
        let is_used_up = free.share_used(value).is_some_and(|share| share > USED_UP);
        let left_then = (is_used_up && !at_limit).then(|| free.nominal());
        Some(Tolerated { parameter, value, std, most, at_limit, left_then })
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
        let part = Free::part_of_tolerance(Parameter::StribeckForce, 870.0, false, 300.0, 87.0);
        let left = |value| tolerated(&[part], &[estimate(Parameter::StribeckForce, value)])[0].left_then;
        assert_eq!((left(386.0), left(340.0)), (Some(300.0), None));
        assert_eq!(not_tolerated(&free, &estimates), estimates[3..]);
    }
}
