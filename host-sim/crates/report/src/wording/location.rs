//! Where an error arises and what it looks like.

use diagnosis::localisation::Habit;
use diagnosis::localisation::error_shape::Shape;
use diagnosis::localisation::operating_region::{Condition, Region};
use identification::visible::shows_share;
use recording::display_unit::{difference, significant, state_unit};

/// The operating region that shows best where an error arises.
#[must_use]
pub fn region(region: Option<Region>) -> String {
    let Some(Region { condition, threshold, share, of_time }) = region else { return "everywhere alike".to_owned() };
    let (scale, digits) = condition.display();
    let value = significant(scale * threshold, digits);
    let condition = match condition {
        Condition::OpeningBeyond => format!("beyond {value} % opening"),
        Condition::OpeningBelow => format!("below {value} % opening"),
        Condition::OpeningBelowWhileMoving => format!("below {value} % opening, while moving"),
        Condition::CommandBeyond => format!("at a command beyond {value} V"),
        Condition::After => format!("after {value} s"),
        Condition::SlowWhileExtending => format!("velocity within {value} mm/s of zero, while extending"),
        Condition::SlowWhileRetracting => format!("velocity within {value} mm/s of zero, while retracting"),
        Condition::Slow => format!("velocity within {value} mm/s of zero"),
        Condition::AtRest => "while the rod rests".to_owned(),
        Condition::ExtendingFast => format!("extending faster than {value} mm/s"),
        Condition::RetractingFast => format!("retracting faster than {value} mm/s"),
        Condition::PositionBeyond => format!("position beyond {value} mm"),
        Condition::PositionBelow => format!("position below {value} mm"),
        Condition::AfterReversal => format!("within {value} ms after a reversal"),
        Condition::AfterStart => format!("within {value} ms after a start"),
        Condition::PressureBelow => format!("with a chamber below {value} bar"),
        Condition::PressureAbove => format!("with a chamber above {value} bar"),
    };
    let (share, of_time) = (significant(100.0 * share, 2), significant(100.0 * of_time, 2));
    format!("{condition}: {share} % of the error in {of_time} % of the time")
}

/// What an error looks like.
#[must_use]
pub fn error_shape(shape: &Shape) -> String {
    match shape {
        Shape::Once { recording, from_s, to_s, share } => format!(
            "it happens once: {} % of the error lies in {recording} from {} to {} s",
            significant(100.0 * share, 2),
            significant(*from_s, 4),
            significant(*to_s, 4)
        ),
        Shape::Periodic { hz, amplitude, signal } => {
            format!("it oscillates at {} Hz: {} in {signal}", significant(*hz, 3), difference(*signal, *amplitude))
        }
        Shape::Over { state, unit, explained, bins, pair } => {
            let told = significant(100.0 * explained.max(0.0), 2);
            let peak = bins.iter().max_by(|a, b| a.mean.abs().total_cmp(&b.mean.abs()));
            let largest = peak.map_or_else(String::new, |peak| {
                let (unit, scale) = state_unit(unit);
                // The state says already what it is a share of.
                let unit = unit.trim_end_matches(" of travel");
                let (from, to) = (significant(scale * peak.from, 2), significant(scale * peak.to, 2));
                let range = if from == to { format!("at {from}") } else { format!("from {from} to {to}") };
                format!(" and is largest {range} {unit}")
            });
            let pair = pair.filter(|(_, _, share)| shows_share(*share));
            let together = pair.map_or_else(String::new, |(one, other, share)| {
                format!("; {one} and {other} together explain {} %", significant(100.0 * share, 2))
            });
            if !shows_share(*explained) {
                return pair.map_or_else(
                    || "it depends on no single state".to_owned(),
                    |(one, other, share)| {
                        format!(
                            "it depends on no single state; {one} and {other} together explain {} %",
                            significant(100.0 * share, 2)
                        )
                    },
                );
            }
            format!("it depends on the {state} (explains {told} % of its variance){largest}{together}")
        }
        Shape::Everywhere => "it depends on no single state".to_owned(),
    }
}

/// What a recorded spool does that the model's does not.
#[must_use]
pub fn spool_habit(habit: &Habit) -> String {
    let travel = |share: f64| significant(100.0 * share, 2);
    match habit {
        Habit::Sticks { recording, from_s, to_s, at, modelled, recordings, of } => format!(
            "the spool is stuck at {} % of its travel while the model's spool moves on by {} % ({recording} from {} to {} s; seen in {recordings} of {of} recordings)",
            travel(*at),
            travel(*modelled),
            significant(*from_s, 4),
            significant(*to_s, 4)
        ),
        Habit::BreaksAway { recording, at_s, speed_per_s, modelled_per_s } => format!(
            "it then breaks away at {} % of its travel per second; the model's spool moves at {} at most ({recording} at {} s)",
            travel(*speed_per_s),
            travel(*modelled_per_s),
            significant(*at_s, 4)
        ),
        Habit::RestsElsewhere { command_v, rests: [(one, here), (other, there)], modelled } => format!(
            "it does not return: at a command of {} V it rests at {} % of its travel ({one}) and at {} % ({other}); the model's two positions differ by {} %",
            significant(*command_v, 2),
            travel(*here),
            travel(*there),
            travel(*modelled)
        ),
    }
}

#[cfg(test)]
mod tests {
    use diagnosis::localisation::error_shape::Bin;
    use recording::Signal;

    use super::*;

    #[test]
    fn a_region_is_told_in_the_units_of_a_data_sheet() {
        let told = |condition, threshold| region(Some(Region { condition, threshold, share: 0.823, of_time: 0.214 }));
        assert_eq!(
            told(Condition::Slow, 0.012),
            "velocity within 12 mm/s of zero: 82 % of the error in 21 % of the time"
        );
        assert!(told(Condition::PressureBelow, 3.1e5).starts_with("with a chamber below 3.1 bar: "));
        assert!(told(Condition::PositionBeyond, 0.1234).starts_with("position beyond 123 mm: "));
        assert_eq!(region(None), "everywhere alike");
    }

    #[test]
    fn a_range_that_is_a_point_in_the_digits_that_are_told_is_told_as_one() {
        let shape = |from: f64, to: f64| {
            let bins = vec![Bin { from, to, mean: 4.0, count: 10 }, Bin { from: to, to: 0.2, mean: 0.1, count: 10 }];
            error_shape(&Shape::Over { state: "velocity", unit: "m/s", explained: 0.4, bins, pair: None })
        };
        assert!(shape(0.0, 0.0).ends_with("is largest at 0 mm/s"), "{}", shape(0.0, 0.0));
        assert!(shape(0.01, 0.02).ends_with("is largest from 10 to 20 mm/s"), "{}", shape(0.01, 0.02));
    }

    #[test]
    fn a_state_that_explains_nothing_is_not_told() {
        let shape = |pair| {
            error_shape(&Shape::Over { state: "velocity", unit: "m/s", explained: -0.1, bins: Vec::new(), pair })
        };
        assert_eq!(shape(None), "it depends on no single state");
        assert_eq!(
            shape(Some(("velocity", "position", 0.42))),
            "it depends on no single state; velocity and position together explain 42 %"
        );
    }

    #[test]
    fn an_oscillation_is_told_with_its_frequency_and_its_signal() {
        let told = error_shape(&Shape::Periodic { hz: 85.04, amplitude: 2e5, signal: Signal::PressureA });
        assert_eq!(told, "it oscillates at 85.0 Hz: 2.00 bar in pressure_a");
    }

    #[test]
    fn a_spool_that_does_not_return_is_told_with_both_places() {
        let rests = [("up".to_owned(), 0.0), ("down".to_owned(), 0.05)];
        let told = spool_habit(&Habit::RestsElsewhere { command_v: 2.0, rests, modelled: 0.0 });
        assert!(
            told.starts_with("it does not return: at a command of 2.0 V") && told.contains("at 5.0 % (down)"),
            "{told}"
        );
    }
}
