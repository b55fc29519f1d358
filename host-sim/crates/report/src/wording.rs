//! What the crates below found, in sentences: they return values, and the words are made here, once for the terminal, JSON and the page.
//! Each is a clause without full stop.

mod tolerance;

use diagnosis::agreement::{Cause, Change, Doubt, FarValue, Suspicion, Trial};
use diagnosis::correction_table::Unnamed;
use diagnosis::localisation::Habit;
use diagnosis::localisation::error_shape::Shape;
use diagnosis::localisation::operating_region::{Condition, Region};
use diagnosis::selection::JumpsFound;
use experiment::discriminate::{Distance, Separation};
use experiment::inspect::{Advice, Bound, CommandRange, UnitDoubt};
use identification::compare::open_loop::{Mover, SENSOR_OFFSET};
use identification::compare::weakest::{Obstacle, Unjudged};
use identification::fit::Correlation;
use model_core::machine::Parameter;
use recording::display_unit::{difference, significant, state_unit, unit_for_people};
use recording::{Note, Signal, Unit};
use simulation::signal::noise::extent;

pub use tolerance::{WITHIN, at_limit, tolerated_thing, used_up};

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
            let explained = significant(100.0 * explained.max(0.0), 2);
            let peak = bins.iter().max_by(|a, b| a.mean.abs().total_cmp(&b.mean.abs()));
            let largest = peak.map_or_else(String::new, |peak| {
                let (unit, scale) = state_unit(unit);
                // The state says already what it is a share of.
                let unit = unit.trim_end_matches(" of travel");
                let (from, to) = (significant(scale * peak.from, 2), significant(scale * peak.to, 2));
                let range = if from == to { format!("at {from}") } else { format!("from {from} to {to}") };
                format!(" and is largest {range} {unit}")
            });
            let together = pair.map_or_else(String::new, |(one, other, share)| {
                format!("; {one} and {other} together explain {} %", significant(100.0 * share, 2))
            });
            format!("it depends on the {state} (explains {explained} % of its variance){largest}{together}")
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

/// The jumps of a spool that no sensor measures.
#[must_use]
pub fn jumps(told: JumpsFound) -> String {
    let kept = significant(100.0 * told.kept_alone, 2);
    let whose = if told.is_alone() { "as one does" } else { "more than one does, so a hysteresis stands beside it" };
    format!(
        "the spool is not measured, but the position's residual repeats every {} % of spool travel, as jumps of this length leave it (log-likelihood {} more than without jumps); a stiction alone would keep {kept} % of its band, {whose}",
        significant(100.0 * told.jump_spacing.length, 2),
        significant(told.jump_spacing.evidence, 2)
    )
}

/// A correction table for what no effect accounts for.
#[must_use]
pub fn correction_table(table: &Unnamed) -> String {
    let states: Vec<_> = table.over.iter().map(|axis| axis.state.name()).collect();
    let (low, high) = extent(table.values.iter().map(|estimate| estimate.value));
    let unit = if table.quantity.unit() == "1" { String::new() } else { format!(" {}", table.quantity.unit()) };
    format!(
        "without a name: a table of {} over {}, from {low:.3e} to {high:.3e}{unit}, follows {} of {} held-out recordings better",
        table.quantity.name(),
        states.join(" and "),
        table.confirmation.improved,
        table.confirmation.recordings
    )
}

/// The test that distinguishes an effect from its rival, without their names.
#[must_use]
pub fn advice(separation: &Separation) -> String {
    let apart = |best: &Distance| {
        let times = significant(best.over_noise, 2);
        format!("{}: the two models differ by {times} times the noise in {}", best.test, best.signal)
    };
    match (separation.tests.first(), &separation.sensor) {
        (Some(best), _) if separation.is_separated() => apart(best),
        (_, Some((sensor, best))) if best.tells() => format!("{}, with {sensor} recorded too", apart(best)),
        (Some(best), _) => format!("no standard test distinguishes them at this noise; best: {}", apart(best)),
        (None, _) => "no standard test runs on this drive".to_owned(),
    }
}

/// Two correlated parameters, with their coefficient.
#[must_use]
pub fn correlation(pair: &Correlation) -> String {
    let (one, other) = (pair.one.description().key, pair.other.description().key);
    let (size, sign) = (pair.coefficient.abs(), if pair.coefficient < 0.0 { "−" } else { "" });
    // Near 1, the difference from 1 matters.
    let decimals = if size < 0.9995 { 3 } else { 5 };
    format!("{one} and {other}: {sign}{size:.decimals$}")
}

/// What prevents the links from being judged separately, and what to record.
#[must_use]
pub fn obstacle(obstacle: Obstacle) -> &'static str {
    match obstacle {
        Obstacle::NoSpool => "the valve cannot be told from the links below it: record `spool` for this",
        Obstacle::NoPressures => {
            "flow, chambers and mechanics cannot be told apart: record both chamber pressures (`pressure_a`, `pressure_b`) for this"
        }
        Obstacle::NoMotion => {
            "the links below the valve are not judged by their motion: record `position` or `velocity` for this"
        }
        Obstacle::LoadFromPressures => {
            "the mechanics cannot be judged: the load is taken from the recorded pressures, which takes a measured \
             `load_force` to avoid"
        }
    }
}

/// Why the misfit of a part says nothing about its physics.
#[must_use]
pub fn unjudged(part: &Unjudged) -> String {
    let Unjudged { section, signal, rmse, sway } = part;
    let (missed, moved) = (difference(*signal, *rmse), difference(*signal, sway.by_most));
    let by = match sway.most {
        Mover::Offset(signal) => {
            let sensor = match signal {
                Signal::PressureA | Signal::PressureB => "a pressure sensor".to_owned(),
                other => format!("the sensor of {other}"),
            };
            format!("an offset of {} % of the full scale of {sensor}", significant(100.0 * SENSOR_OFFSET, 1))
        }
        Mover::Parameter(parameter) => format!("{} off by its standard deviation", parameter.description().key),
        Mover::Tolerance(parameter) => format!("half the tolerance of {}", parameter.description().key),
    };
    format!(
        "{section} cannot be judged by {signal}, which it misses by {missed}: in open loop {by} alone moves it by {moved}"
    )
}

/// What is worth a second look in a recording, or another recording.
#[must_use]
pub fn recording_advice(advice: &Advice) -> String {
    match advice {
        Advice::Constant { signal, unit, value } => {
            format!("{signal} is {} {unit} in every row and cannot be judged", significant(unit.from_si(*value), 3))
        }
        Advice::Unit(doubt) => unit_doubt(doubt),
        Advice::Agreement(suspicion) => format!(
            "{}; `host-sim fit` and `diagnose` try what would explain it",
            match suspicion {
                Suspicion::RunsAgainst(signal) =>
                    format!("{signal} runs against what the machine file's model does with this input"),
                Suspicion::PressuresCrossed =>
                    "each pressure is nearer to what the machine file's model gives for the other chamber".to_owned(),
                Suspicion::MovesOtherwise(signal, ratio) if ratio.is_finite() => format!(
                    "{signal} moves {} times as far as the machine file's model does with this input",
                    significant(*ratio, 2)
                ),
                Suspicion::MovesOtherwise(signal, _) =>
                    format!("{signal} moves, but the machine file's model hardly does with this input"),
            }
        ),
        Advice::RangeEnd { signal, reading, share } => {
            format!(
                "{}: what is beyond it is not recorded, and these rows are not judged",
                range_end(*signal, *reading, *share)
            )
        }
        Advice::NeverOpens { by } => {
            format!(
                "with this {by} the valve never leaves the dead zone, so nothing below it moves: use larger commands"
            )
        }
        Advice::OpensOneWay { by, extending } => {
            let way = if *extending { "extend" } else { "retract" };
            format!("by its {by} the valve opens to {way} only; commands both ways show both sides")
        }
        Advice::DoesNotMove => {
            "the rod does not move by more than its sensor's noise: friction and flow do not show".to_owned()
        }
        Advice::MovesOneWay => "the rod moves one way only; move both ways to tell friction from load".to_owned(),
        Advice::LittleTravel => {
            "the rod covers little of its stroke: what depends on the position does not show".to_owned()
        }
        Advice::NeverHolds { least_s } => format!(
            "the rod never holds for {least_s} s; a pause with the valve closed shows leakage, drift and friction at rest"
        ),
    }
}

/// What is taken of pressures that fit the drive only without the pressure of the air in them.
#[must_use]
pub fn taken_as_absolute() -> String {
    format!(
        "pressures  {}; if they are, say so in the machine file: [channels] pressure = \"absolute\"",
        Note::TakenAsAbsolute
    )
}

/// A sensor at an end of its range, without how these rows are treated.
#[must_use]
pub fn range_end(signal: Signal, reading: f64, share: f64) -> String {
    let unit = unit_for_people(signal);
    let (reading, percent) = (significant(unit.from_si(reading), 4), significant(100.0 * share, 2));
    format!("{signal} reads {reading} {unit}, the end of its sensor's range, in {percent} % of the rows")
}

/// What follows from a recording that does not begin at rest, where a part of its state is not measured.
#[must_use]
pub fn unsettled(for_s: f64) -> String {
    format!(
        "does not begin at rest, and what moved the drive before is not recorded: the first {} s are not judged",
        significant(for_s, 2)
    )
}

/// Why a unit can hardly be right for this drive, and what would do.
#[must_use]
pub fn unit_doubt(doubt: &UnitDoubt) -> String {
    match doubt {
        UnitDoubt::Current { command, closed_at_ma } => {
            let CommandRange { header, unit, low, high, opening } = command;
            let (unit, opening) = (unit.symbol(), significant(100.0 * opening, 3));
            let range =
                format!("command goes from {} {unit} to {} {unit}", significant(*low, 3), significant(*high, 3));
            let by_file = format!("by the machine file's gain_per_v it opens the valve to {opening} %");
            let in_channels = |zero: f64, full: f64| {
                format!(
                    "if the file counts in volts, its [channels] can say command = {{ column = \"{header}\", zero = {zero}, full = {full} }}"
                )
            };
            match closed_at_ma {
                Some(middle) => format!(
                    "{range}, as a current of 4 to 20 mA that closes the valve at {middle} mA does, but {by_file} and never closes it: {}",
                    in_channels(*middle, 0.8)
                ),
                None => format!("{range}, and {by_file}: {}", in_channels(0.0, 2.0)),
            }
        }
        UnitDoubt::SpoolTravel { unit, share } => format!(
            "the measured spool goes {} times as far as gain_per_v says of a held command: does the machine file count in {}, as the recording does?",
            significant(*share, 2),
            unit.symbol()
        ),
        UnitDoubt::Beyond { signal, unit, high, bound, fitting } => {
            let shown = |unit: Unit| format!("{} {unit}", significant(*high, 3));
            let passed = match bound {
                Bound::Stroke => "beyond the stroke of the machine file",
                Bound::FarAboveSupply => "1.5 times the supply pressure or more of the machine file",
                Bound::FarBelowSupply => "less than a hundredth of the supply pressure of the machine file",
            };
            let instead = fitting.map_or_else(String::new, |unit| format!(" {} would be possible", shown(unit)));
            format!("{signal} reaches {}, {passed}: is its unit right?{instead}", shown(*unit))
        }
        UnitDoubt::Speed { share, fitting } => {
            let instead = fitting.map_or_else(String::new, |(unit, share)| {
                format!(" With times in {unit}, it would be {}", significant(share, 2))
            });
            format!(
                "the rod goes {} times as fast as the valve, opened as it was, lets it without load: are the units of time and position right?{instead}",
                significant(*share, 2)
            )
        }
    }
}

/// Why recordings and a machine file hardly belong together, and with which change they would.
#[must_use]
pub fn doubt(doubt: &Doubt) -> String {
    let of = if doubt.in_all { String::new() } else { format!("{}: ", doubt.recordings.join(", ")) };
    let [seems, changed] =
        [claim, remedy].map(|words| joined(doubt.changed.changes.iter().map(|change| words(*change))));
    let signals = joined(doubt.signals.iter().map(|signal| signal.name().to_owned()));
    // Worse than the mean is no fit, however much worse.
    let percent = |trial: &Trial| significant(trial.fit_percent.max(0.0), 3);
    let only_with = match doubt.as_recorded.far.first() {
        Some(far) if far.is_impossible => format!(", and only with {}", moved(far)),
        _ => String::new(),
    };
    let others = doubt.others.iter().map(|other| {
        format!("; or {}: {} %", joined(other.changes.iter().map(|change| claim(*change))), percent(other))
    });
    format!(
        "{of}{seems}: {changed}, the fit of {signals} is {} % (as recorded {} %{only_with}){}",
        percent(&doubt.changed),
        percent(&doubt.as_recorded),
        others.collect::<String>()
    )
}

/// What a change says of the recordings.
fn claim(change: Change) -> String {
    match change {
        Change::Reversed(signal) => format!("{signal} seems to run the other way"),
        Change::PortsExchanged => "ports A and B of the valve seem to be exchanged".to_owned(),
        Change::PressuresExchanged => "the pressures of A and B seem to be exchanged".to_owned(),
        Change::Scaled(signal, factor) => {
            let signals = match signal {
                Signal::PressureA | Signal::PressureB => "both pressures seem".to_owned(),
                _ => format!("{signal} seems"),
            };
            let were = if signals.starts_with("both") { "they were" } else { "it was" };
            match share(1.0 / factor) {
                Some(share) => format!("{signals} to be {share} of what {were}"),
                None => format!("{signals} to be {} times what {were}", significant(1.0 / factor, 2)),
            }
        }
    }
}

/// What was done to try it.
fn remedy(change: Change) -> String {
    match change {
        Change::Reversed(_) => "turned round".to_owned(),
        Change::PortsExchanged | Change::PressuresExchanged => "exchanged back".to_owned(),
        Change::Scaled(_, factor) => match share(factor) {
            Some(share) => format!("taken as {share} of that"),
            None => format!("taken {} times as large", significant(factor, 2)),
        },
    }
}

/// The word for a decimal fraction.
fn share(factor: f64) -> Option<&'static str> {
    let words = [(0.1, "a tenth"), (0.01, "a hundredth"), (0.001, "a thousandth")];
    words.into_iter().find(|(share, _)| (factor / share - 1.0).abs() < 1e-9).map(|(_, word)| word)
}

/// `a, b and c`.
fn joined(parts: impl Iterator<Item = String>) -> String {
    let parts: Vec<String> = parts.collect();
    match parts.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
        None => String::new(),
    }
}

/// The values that a refit has moved farthest; of more than a few only how many, for where so many are far no single one is to blame.
#[must_use]
pub fn far_values(far: &[FarValue]) -> Vec<String> {
    const TOLD: usize = 4;
    let more = far.len().saturating_sub(TOLD);
    let more = (more > 0).then(|| format!("{more} more, in the table of refitted parameters"));
    far.iter().take(TOLD).map(far_value).chain(more).collect()
}

/// A value that a refit has moved far, and what else would explain it.
#[must_use]
pub fn far_value(far: &FarValue) -> String {
    let causes: Vec<&str> = far.suggests.iter().map(|cause| cause_of(*cause)).collect();
    let check = if causes.is_empty() { String::new() } else { format!("; check {}", causes.join(", ")) };
    let sigmas = significant(far.sigmas, 2);
    format!("{}, {sigmas} of its standard deviations away{check}", moved(far))
}

/// A value, with the machine file's.
fn moved(far: &FarValue) -> String {
    let description = far.parameter.description();
    let unit = if description.unit == "1" { String::new() } else { format!(" {}", description.unit) };
    let verdict = match far.parameter {
        _ if !far.is_impossible => "",
        Parameter::BulkModulus => ", which no oil has",
        _ => ", far from any drive that the machine file can mean",
    };
    format!("{} at {:.3e}{unit} instead of {:.3e}{verdict}", description.key, far.value, far.nominal)
}

fn cause_of(cause: Cause) -> &'static str {
    match cause {
        Cause::Bore => "bore and rod",
        Cause::Load => "load and moving mass",
        Cause::Flow => "the rated flow",
        Cause::Supply => "the supply pressure",
        Cause::Volume => "the volumes of chambers and hoses",
        Cause::PositionUnit => "the unit of position",
        Cause::CommandUnit => "the unit of the command",
        Cause::PressureUnit => "the unit of the pressures",
        Cause::Times => "the time stamps, and filters behind the sensors",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use diagnosis::localisation::error_shape::Bin;
    use diagnosis::selection::JumpSpacing;

    #[test]
    fn a_doubt_about_a_unit_says_what_would_do() {
        let unit = |symbol| Unit::parse(symbol).unwrap();
        let current = |low, high, closed_at_ma| {
            let header = "command [mA]".to_owned();
            let command = CommandRange { header, unit: unit("mA"), low, high, opening: 2.0 };
            unit_doubt(&UnitDoubt::Current { command, closed_at_ma })
        };
        let live = current(4.0, 20.0, Some(12.0));
        for part in
            ["from 4.00 mA to 20.0 mA", "to 200 %", "command = { column = \"command [mA]\", zero = 12, full = 0.8 }"]
        {
            assert!(live.contains(part), "{part}: {live}");
        }
        assert!(current(-20.0, 20.0, None).contains("zero = 0, full = 2 }"));
        let travel = unit_doubt(&UnitDoubt::SpoolTravel { unit: unit("mA"), share: 0.5 });
        assert!(travel.contains("0.50 times as far") && travel.contains("count in mA"), "{travel}");
        let beyond = |signal, now, high, bound, fitting| {
            unit_doubt(&UnitDoubt::Beyond { signal, unit: unit(now), high, bound, fitting: Some(unit(fitting)) })
        };
        let position = beyond(Signal::Position, "m", 200.0, Bound::Stroke, "mm");
        assert!(position.contains("beyond the stroke of the machine file"), "{position}");
        assert!(position.ends_with(" 200 mm would be possible"), "{position}");
        let low = beyond(Signal::PressureA, "Pa", 36.0, Bound::FarBelowSupply, "bar");
        assert!(low.contains("less than a hundredth of the supply pressure") && low.contains(" bar would be possible"));
        let high = beyond(Signal::PressureA, "bar", 5e2, Bound::FarAboveSupply, "psi");
        assert!(high.contains("1.5 times the supply pressure or more") && high.contains(" psi would be possible"));
        let speed = unit_doubt(&UnitDoubt::Speed { share: 1e-3, fitting: Some((unit("ms"), 1.0)) });
        assert!(
            speed.starts_with("the rod goes 0.0010 times as fast as the valve, opened as it was, lets it"),
            "{speed}"
        );
        assert!(speed.ends_with(" With times in ms, it would be 1.0"), "{speed}");
    }

    #[test]
    fn advice_on_a_recording_says_what_to_do() {
        for (advice, part) in [
            (Advice::NeverOpens { by: Signal::Command }, "with this command the valve never leaves the dead zone"),
            (Advice::DoesNotMove, "does not move"),
            (Advice::OpensOneWay { by: Signal::Command, extending: true }, "opens to extend only"),
            (Advice::MovesOneWay, "one way only"),
            (Advice::LittleTravel, "little of its stroke"),
            (Advice::NeverHolds { least_s: 0.3 }, "never holds for 0.3 s"),
        ] {
            let said = recording_advice(&advice);
            assert!(said.contains(part), "{part}: {said}");
        }
    }

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
    fn the_test_that_distinguishes_two_effects_is_advised_with_the_sensor_that_it_takes() {
        let distance = |test, over_noise| Distance {
            test,
            how: String::new(),
            duration_s: 10.0,
            signal: Signal::PressureA,
            over_noise,
            per_20_s: over_noise,
        };
        let told = |tests: &[Distance], sensor| {
            let (effect, rival) = ("internal-leakage", "external-leakage");
            advice(&Separation { effect, rival, confidence: 0.1, tests: tests.to_vec(), sensor })
        };
        assert_eq!(
            told(&[distance("ramps", 40.0)], None),
            "ramps: the two models differ by 40 times the noise in pressure_a"
        );
        let sensor = Some((Signal::PressureB, distance("hold", 40.0)));
        assert!(told(&[distance("ramps", 0.0)], sensor).ends_with(", with pressure_b recorded too"));
        assert!(
            told(&[distance("ramps", 0.0)], None)
                .starts_with("no standard test distinguishes them at this noise; best: ramps")
        );
        assert_eq!(told(&[], None), "no standard test runs on this drive");
    }

    #[test]
    fn what_the_position_says_is_told_with_what_it_leaves_open() {
        let told =
            |kept_alone| jumps(JumpsFound { jump_spacing: JumpSpacing { length: 0.0075, evidence: 16.1 }, kept_alone });
        assert!(
            told(0.2).contains("every 0.75 % of spool travel")
                && told(0.2).ends_with("keep 20 % of its band, as one does")
        );
        assert!(told(0.55).ends_with("keep 55 % of its band, more than one does, so a hysteresis stands beside it"));
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

    #[test]
    fn a_doubt_about_recordings_says_what_would_remove_it_and_how_much_better_they_fit() {
        let said = |change| (claim(change), remedy(change));
        let position = said(Change::Scaled(Signal::Position, 10.0));
        assert_eq!(position.0, "position seems to be a tenth of what it was");
        assert_eq!(position.1, "taken 10 times as large");
        let pressures = said(Change::Scaled(Signal::PressureA, 1e-3));
        assert_eq!(pressures.0, "both pressures seem to be 1000 times what they were");
        assert_eq!(pressures.1, "taken as a thousandth of that");
        assert_eq!(said(Change::PressuresExchanged).1, "exchanged back");
    }

    #[test]
    fn a_far_value_says_what_else_would_explain_it() {
        let far = FarValue {
            parameter: Parameter::BulkModulus,
            nominal: 1.2e9,
            value: 1.17e10,
            sigmas: 87.5,
            is_impossible: true,
            suggests: &[Cause::PositionUnit, Cause::Bore],
        };
        assert_eq!(
            far_value(&far),
            "cylinder.bulk_modulus_pa at 1.170e10 Pa instead of 1.200e9, which no oil has, 88 of its standard deviations away; \
             check the unit of position, bore and rod"
        );
    }

    #[test]
    fn a_correlation_near_one_shows_how_near() {
        let pair =
            |coefficient| Correlation { one: Parameter::ValveGain, other: Parameter::FlowCoefficient, coefficient };
        assert_eq!(correlation(&pair(-0.99)), "valve.gain_per_v and valve.flow_coefficient: −0.990");
        assert!(correlation(&pair(0.999_87)).ends_with(": 0.99987"));
    }
}
