//! Operating regions of the drive in which an error arises, with thresholds that the data give.

use recording::display_unit::significant;

use super::error_shape::independent_samples;
use crate::selection::decision_rule::REGION_TOLD;

/// States of the drive along all recordings, one value per row, SI.
#[derive(Clone, Debug, Default)]
pub struct Course {
    /// Time in the recording, s.
    pub time_s: Vec<f64>,
    /// Velocity, m/s.
    pub velocity_m_per_s: Vec<f64>,
    /// Position, m.
    pub position_m: Vec<f64>,
    /// Spool.
    pub spool: Vec<f64>,
    /// Command, V.
    pub command_v: Vec<f64>,
    /// Pressure in A, Pa.
    pub pressure_a_pa: Vec<f64>,
    /// Pressure in B, Pa.
    pub pressure_b_pa: Vec<f64>,
    /// Time since the velocity last changed its sign, s.
    pub since_reversal_s: Vec<f64>,
    /// Time since the rod last rested, s.
    pub since_rest_s: Vec<f64>,
    /// Whether anything below the spool is measured; else pressures and motion are only simulated.
    pub is_below_spool_seen: bool,
}

/// The operating region that shows best where an error arises: there it is at least twice as large as elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// What the drive does there.
    pub condition: Condition,
    /// The threshold of the condition, SI; 0 where it has none.
    pub threshold: f64,
    /// Share of the squared error that arises there.
    pub share: f64,
    /// Share of the rows that lie there.
    pub of_time: f64,
}

/// What a drive does in an operating region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// The opening is larger than the threshold.
    OpeningBeyond,
    /// The opening is smaller.
    OpeningBelow,
    /// The opening is smaller, and the rod moves.
    OpeningBelowWhileMoving,
    /// The command's magnitude is larger, V.
    CommandBeyond,
    /// Later in the recording, s.
    After,
    /// It extends more slowly, m/s.
    SlowWhileExtending,
    /// It retracts more slowly, m/s.
    SlowWhileRetracting,
    /// It moves more slowly either way, or rests, m/s.
    Slow,
    /// The rod rests; no threshold.
    AtRest,
    /// It extends faster, m/s.
    ExtendingFast,
    /// It retracts faster, m/s.
    RetractingFast,
    /// The position is larger, m.
    PositionBeyond,
    /// The position is smaller, m.
    PositionBelow,
    /// Sooner after a reversal, s.
    AfterReversal,
    /// Sooner after the rod has rested, s.
    AfterStart,
    /// The lower of the pressures is lower, Pa.
    PressureBelow,
    /// The higher of the pressures is higher, Pa.
    PressureAbove,
}

impl Condition {
    /// Factor from SI to the unit in which people read its threshold, and the digits that they read.
    #[must_use]
    pub const fn display(self) -> (f64, i32) {
        match self {
            Condition::OpeningBeyond | Condition::OpeningBelow | Condition::OpeningBelowWhileMoving => (100.0, 2),
            Condition::CommandBeyond | Condition::After | Condition::AtRest => (1.0, 2),
            Condition::SlowWhileExtending
            | Condition::SlowWhileRetracting
            | Condition::Slow
            | Condition::ExtendingFast
            | Condition::RetractingFast
            | Condition::AfterReversal
            | Condition::AfterStart => (1e3, 2),
            Condition::PositionBeyond | Condition::PositionBelow => (1e3, 3),
            Condition::PressureBelow | Condition::PressureAbove => (1e-5, 2),
        }
    }
}

/// A family of regions: all rows of a group whose value is on one side of a threshold.
struct Family {
    condition: Condition,
    /// Value and whether the row belongs to the group at all.
    values: Vec<(f64, bool)>,
    /// Whether the region is below the threshold.
    below: bool,
    /// Thresholds at or below this are not used: they do not distinguish a state from zero.
    least: f64,
}

/// Thresholds tried for each family: quantiles of its values.
const TRIES: usize = 24;
/// A region or a time is distinguished if the error in it is at least twice the error elsewhere: four times in mean square.
pub(crate) const TWICE: f64 = 4.0;
/// A region holds at most two thirds of all rows: a larger one is simply the whole drive.
const MOST_ROWS: f64 = 2.0 / 3.0;
/// And at least a third of the error: with less it stays open where most of the error arises.
const LEAST_SHARE: f64 = 1.0 / 3.0;
/// A value below this share of the largest one counts as zero.
const OF_LARGEST: f64 = 0.01;

impl Family {
    /// Thresholds in SI: quantiles, rounded to the digits that people read.
    fn thresholds(&self) -> Vec<f64> {
        let mut sorted: Vec<f64> = self.values.iter().filter(|(_, inside)| *inside).map(|(value, _)| *value).collect();
        // A signal that never changes has no regions.
        if sorted.len() < TRIES || sorted.iter().all(|value| value.to_bits() == sorted[0].to_bits()) {
            return Vec::new();
        }
        sorted.sort_by(f64::total_cmp);
        let (scale, digits) = self.condition.display();
        let rounded = |index: usize| {
            let number = significant(scale * sorted[index * sorted.len() / TRIES], digits).parse::<f64>();
            number.ok().map(|number| number / scale)
        };
        (1..TRIES).filter_map(rounded).filter(|threshold| *threshold > self.least).collect()
    }
}

impl Course {
    fn each(&self, value: impl Fn(usize) -> f64, inside: impl Fn(usize) -> bool) -> Vec<(f64, bool)> {
        (0..self.time_s.len()).map(|row| (value(row), inside(row))).collect()
    }

    fn families(&self) -> Vec<Family> {
        use Condition::{
            After, AfterReversal, AfterStart, AtRest, CommandBeyond, ExtendingFast, OpeningBelow,
            OpeningBelowWhileMoving, OpeningBeyond, PositionBelow, PositionBeyond, PressureAbove, PressureBelow,
            RetractingFast, Slow, SlowWhileExtending, SlowWhileRetracting,
        };
        let v = &self.velocity_m_per_s;
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let fastest = largest(v);
        let rests = |row: usize| v[row].abs() < OF_LARGEST * fastest;
        let everywhere = |_: usize| true;
        let happened = |since: &[f64], row: usize| since[row] < NEVER_S && !rests(row);
        let (a, b) = (&self.pressure_a_pa, &self.pressure_b_pa);
        let beyond = |condition, least, values| Family { condition, values, below: false, least };
        let below = |condition, least, values| Family { condition, values, below: true, least };
        let (slow, ajar) = (OF_LARGEST * fastest, OF_LARGEST * largest(&self.spool));
        let any = f64::NEG_INFINITY;
        let opening = || self.each(|row| self.spool[row].abs(), everywhere);
        let of_valve = vec![
            beyond(OpeningBeyond, ajar, opening()),
            below(OpeningBelow, ajar, opening()),
            beyond(
                CommandBeyond,
                OF_LARGEST * largest(&self.command_v),
                self.each(|row| self.command_v[row].abs(), everywhere),
            ),
            beyond(After, 0.0, self.each(|row| self.time_s[row], everywhere)),
        ];
        if !self.is_below_spool_seen {
            return of_valve;
        }
        let mut all = vec![
            below(SlowWhileExtending, slow, self.each(|row| v[row].abs(), |row| v[row] > 0.0 && !rests(row))),
            below(SlowWhileRetracting, slow, self.each(|row| v[row].abs(), |row| v[row] < 0.0 && !rests(row))),
            below(Slow, slow, self.each(|row| v[row].abs(), everywhere)),
            below(AtRest, any, self.each(|row| f64::from(u8::from(!rests(row))), everywhere)),
            beyond(ExtendingFast, slow, self.each(|row| v[row], everywhere)),
            beyond(RetractingFast, slow, self.each(|row| -v[row], everywhere)),
            below(OpeningBelowWhileMoving, ajar, self.each(|row| self.spool[row].abs(), |row| !rests(row))),
            beyond(PositionBeyond, any, self.each(|row| self.position_m[row], everywhere)),
            below(PositionBelow, any, self.each(|row| self.position_m[row], everywhere)),
            below(
                AfterReversal,
                0.0,
                self.each(|row| self.since_reversal_s[row], |row| happened(&self.since_reversal_s, row)),
            ),
            below(AfterStart, 0.0, self.each(|row| self.since_rest_s[row], |row| happened(&self.since_rest_s, row))),
            below(PressureBelow, any, self.each(|row| a[row].min(b[row]), everywhere)),
            beyond(PressureAbove, any, self.each(|row| a[row].max(b[row]), everywhere)),
        ];
        all.extend(of_valve);
        all
    }

    /// The region that shows best where the error arises: its share of the error differs most from its share of the time,
    /// measured by the divergence of the two in nats. `None` where in no region the error is twice the error elsewhere, or where
    /// the best of so many regions would differ as much by chance, given the number of independent samples.
    #[must_use]
    pub fn region(&self, errors: &[f64]) -> Option<Region> {
        let rows_in_all = errors.len() as f64;
        let total: f64 = errors.iter().map(|error| error * error).sum();
        let families: Vec<(Family, Vec<f64>)> = self
            .families()
            .into_iter()
            .map(|family| {
                let thresholds = family.thresholds();
                (family, thresholds)
            })
            .collect();
        let tries = families.iter().map(|(_, thresholds)| thresholds.len()).sum::<usize>().max(1);
        let least_told = (REGION_TOLD + libm::log(tries as f64)) / independent_samples(errors);
        let mut best: Option<(f64, Region)> = None;
        for (family, thresholds) in families {
            for threshold in thresholds {
                let (mut rows, mut held) = (0.0, 0.0);
                for ((value, inside), error) in family.values.iter().zip(errors) {
                    if *inside && (if family.below { *value <= threshold } else { *value >= threshold }) {
                        rows += 1.0;
                        held += error * error;
                    }
                }
                let (share, of_time) = (held / total, rows / rows_in_all);
                let distinguishes = share * (1.0 - of_time) >= TWICE * (1.0 - share) * of_time;
                if !(distinguishes && share > LEAST_SHARE && of_time > 0.0 && of_time <= MOST_ROWS) {
                    continue;
                }
                let out = 1.0 - share;
                let told = share * libm::log(share / of_time)
                    + if out > 0.0 { out * libm::log(out / (1.0 - of_time)) } else { 0.0 };
                if told > least_told && best.as_ref().is_none_or(|(known, _)| told > *known) {
                    best = Some((told, Region { condition: family.condition, threshold, share, of_time }));
                }
            }
        }
        best.map(|(_, region)| region)
    }
}

/// Time since an event that never happened, s.
const NEVER_S: f64 = 1e3;

/// Time since an event (a change, or a condition that holds) last happened, at each row, s.
#[must_use]
pub fn since(time_s: &[f64], event: impl Fn(usize) -> bool) -> Vec<f64> {
    let mut last = f64::NEG_INFINITY;
    time_s
        .iter()
        .enumerate()
        .map(|(row, time)| {
            if event(row) {
                last = *time;
            }
            (time - last).min(NEVER_S)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rod that swings for six seconds, and nothing else.
    fn swinging() -> Course {
        let time_s: Vec<f64> = (0..6000).map(|row| f64::from(row) * 1e-3).collect();
        let zeros = vec![0.0; time_s.len()];
        Course {
            velocity_m_per_s: time_s.iter().map(|t| 0.1 * (2.0 * t).sin()).collect(),
            position_m: zeros.clone(),
            spool: zeros.clone(),
            command_v: zeros.clone(),
            pressure_a_pa: zeros.clone(),
            pressure_b_pa: zeros.clone(),
            since_reversal_s: zeros.clone(),
            since_rest_s: zeros,
            is_below_spool_seen: true,
            time_s,
        }
    }

    #[test]
    fn the_threshold_is_the_one_in_the_data_to_the_digits_that_people_read() {
        let course = swinging();
        let errors: Vec<f64> = course.velocity_m_per_s.iter().map(|v| if *v > 0.06 { 9.0 } else { 1.0 }).collect();
        let found = course.region(&errors).unwrap();
        assert_eq!(found.condition, Condition::ExtendingFast);
        assert!((found.threshold - 0.06).abs() < 0.015, "{found:?}");
        let digits = 1e3 * found.threshold;
        assert!((digits - digits.round()).abs() < 1e-9, "{found:?}");
        // The shares belong to the rounded threshold.
        let inside = course.velocity_m_per_s.iter().filter(|v| **v >= found.threshold).count() as f64 / 6000.0;
        assert!((found.of_time - inside).abs() < 1e-12, "{found:?}");
        assert_eq!(course.region(&vec![1.0; 6000]), None);
    }

    #[test]
    fn a_region_in_which_the_error_is_hardly_larger_is_not_told() {
        let course = swinging();
        let errors = |times: f64| {
            course.velocity_m_per_s.iter().map(|v| if *v > 0.06 { times } else { 1.0 }).collect::<Vec<_>>()
        };
        assert_eq!(course.region(&errors(1.8)), None);
        assert!(course.region(&errors(2.5)).is_some());
    }

    #[test]
    fn a_region_that_holds_most_of_all_rows_is_not_told() {
        let course = swinging();
        let errors: Vec<f64> = course.velocity_m_per_s.iter().map(|v| if *v > -0.06 { 9.0 } else { 1.0 }).collect();
        let found = course.region(&errors);
        assert!(found.is_none_or(|region| region.of_time <= MOST_ROWS), "{found:?}");
    }

    #[test]
    fn next_to_nothing_is_no_threshold() {
        // A spool that is off its centre by a thousandth of its travel for nearly half of the time; the error is large at the same times.
        let mut course = swinging();
        let is_off = |row: usize| row % 100 < 45;
        course.spool = (0..6000)
            .map(|row| {
                if row == 3000 {
                    0.5
                } else if is_off(row) {
                    1e-3
                } else {
                    0.0
                }
            })
            .collect();
        let errors: Vec<f64> = (0..6000).map(|row| if is_off(row) { 9.0 } else { 1.0 }).collect();
        assert_eq!(course.region(&errors), None);
    }

    #[test]
    fn a_motion_that_no_sensor_sees_is_no_place() {
        let mut course = swinging();
        course.is_below_spool_seen = false;
        course.spool = course.velocity_m_per_s.iter().map(|v| 5.0 * v).collect();
        let errors: Vec<f64> = course.spool.iter().map(|x| if x.abs() > 0.4 { 9.0 } else { 1.0 }).collect();
        let found = course.region(&errors).unwrap();
        assert!(found.condition == Condition::OpeningBeyond && found.threshold > 0.2, "{found:?}");
    }

    #[test]
    fn time_since_an_event_that_never_was_is_no_time() {
        let course = Course { since_reversal_s: since(&swinging().time_s, |_| false), ..swinging() };
        let errors: Vec<f64> = (0..6000).map(|row| if row < 600 { 9.0 } else { 1.0 }).collect();
        let found = course.region(&errors);
        assert!(found.is_some_and(|region| region.condition != Condition::AfterReversal), "{found:?}");
    }
}
