//! Operating regions of the drive in which an error arises, in words, with thresholds that the data give.

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

/// A family of regions: all rows of a group whose value is on one side of a threshold.
struct Family {
    /// Value and whether the row belongs to the group at all.
    values: Vec<(f64, bool)>,
    /// Whether the region is below the threshold.
    below: bool,
    /// Thresholds at or below this are not used: they do not distinguish a state from zero.
    least: f64,
    /// Factor from SI to the unit in which people read the value.
    scale: f64,
    /// Digits of the threshold in words.
    digits: i32,
    words: fn(&str) -> String,
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
/// The words where no region is distinguished.
pub const ALIKE: &str = "everywhere alike";

impl Family {
    /// Thresholds in SI, with their words: quantiles, rounded to the digits that the words show.
    fn thresholds(&self) -> Vec<(f64, String)> {
        let mut sorted: Vec<f64> = self.values.iter().filter(|(_, inside)| *inside).map(|(value, _)| *value).collect();
        // A signal that never changes has no regions.
        if sorted.len() < TRIES || sorted.iter().all(|value| value.to_bits() == sorted[0].to_bits()) {
            return Vec::new();
        }
        sorted.sort_by(f64::total_cmp);
        let told = |index: usize| {
            let number = significant(self.scale * sorted[index * sorted.len() / TRIES], self.digits);
            Some((number.parse::<f64>().ok()? / self.scale, (self.words)(&number)))
        };
        (1..TRIES).filter_map(told).filter(|(threshold, _)| *threshold > self.least).collect()
    }
}

impl Course {
    fn each(&self, value: impl Fn(usize) -> f64, inside: impl Fn(usize) -> bool) -> Vec<(f64, bool)> {
        (0..self.time_s.len()).map(|row| (value(row), inside(row))).collect()
    }

    fn families(&self) -> Vec<Family> {
        const MM: f64 = 1e3;
        let v = &self.velocity_m_per_s;
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let fastest = largest(v);
        let rests = |row: usize| v[row].abs() < OF_LARGEST * fastest;
        let everywhere = |_: usize| true;
        let happened = |since: &[f64], row: usize| since[row] < NEVER_S && !rests(row);
        let (a, b) = (&self.pressure_a_pa, &self.pressure_b_pa);
        let family = |values, below, least, scale, words| Family { values, below, least, scale, digits: 2, words };
        let (slow, ajar) = (OF_LARGEST * fastest, OF_LARGEST * largest(&self.spool));
        let any = f64::NEG_INFINITY;
        let of_valve = vec![
            family(self.each(|row| self.spool[row].abs(), everywhere), false, ajar, 100.0, |t| {
                format!("beyond {t} % opening")
            }),
            family(self.each(|row| self.spool[row].abs(), everywhere), true, ajar, 100.0, |t| {
                format!("below {t} % opening")
            }),
            family(
                self.each(|row| self.command_v[row].abs(), everywhere),
                false,
                OF_LARGEST * largest(&self.command_v),
                1.0,
                |t| format!("at a command beyond {t} V"),
            ),
            family(self.each(|row| self.time_s[row], everywhere), false, 0.0, 1.0, |t| format!("after {t} s")),
        ];
        if !self.is_below_spool_seen {
            return of_valve;
        }
        let mut all = vec![
            family(self.each(|row| v[row].abs(), |row| v[row] > 0.0 && !rests(row)), true, slow, MM, |t| {
                format!("velocity within {t} mm/s of zero, while extending")
            }),
            family(self.each(|row| v[row].abs(), |row| v[row] < 0.0 && !rests(row)), true, slow, MM, |t| {
                format!("velocity within {t} mm/s of zero, while retracting")
            }),
            family(self.each(|row| v[row].abs(), everywhere), true, slow, MM, |t| {
                format!("velocity within {t} mm/s of zero")
            }),
            // Only whether the rod rests: the words need no threshold.
            family(self.each(|row| f64::from(u8::from(!rests(row))), everywhere), true, any, 1.0, |_| {
                "while the rod rests".to_owned()
            }),
            family(self.each(|row| v[row], everywhere), false, slow, MM, |t| format!("extending faster than {t} mm/s")),
            family(self.each(|row| -v[row], everywhere), false, slow, MM, |t| {
                format!("retracting faster than {t} mm/s")
            }),
            family(self.each(|row| self.spool[row].abs(), |row| !rests(row)), true, ajar, 100.0, |t| {
                format!("below {t} % opening, while moving")
            }),
            Family {
                digits: 3,
                ..family(self.each(|row| self.position_m[row], everywhere), false, any, MM, |t| {
                    format!("position beyond {t} mm")
                })
            },
            Family {
                digits: 3,
                ..family(self.each(|row| self.position_m[row], everywhere), true, any, MM, |t| {
                    format!("position below {t} mm")
                })
            },
            family(
                self.each(|row| self.since_reversal_s[row], |row| happened(&self.since_reversal_s, row)),
                true,
                0.0,
                1e3,
                |t| format!("within {t} ms after a reversal"),
            ),
            family(
                self.each(|row| self.since_rest_s[row], |row| happened(&self.since_rest_s, row)),
                true,
                0.0,
                1e3,
                |t| format!("within {t} ms after a start"),
            ),
            family(self.each(|row| a[row].min(b[row]), everywhere), true, any, 1e-5, |t| {
                format!("with a chamber below {t} bar")
            }),
            family(self.each(|row| a[row].max(b[row]), everywhere), false, any, 1e-5, |t| {
                format!("with a chamber above {t} bar")
            }),
        ];
        all.extend(of_valve);
        all
    }

    /// The region that shows best where the error arises: its share of the error differs most from its share of the time,
    /// measured by the divergence of the two in nats. [`ALIKE`] where in no region the error is twice the error elsewhere, or where
    /// the best of so many regions would differ as much by chance, given the number of independent samples.
    #[must_use]
    pub fn region(&self, errors: &[f64]) -> String {
        let rows_in_all = errors.len() as f64;
        let total: f64 = errors.iter().map(|error| error * error).sum();
        let families: Vec<(Family, Vec<(f64, String)>)> = self
            .families()
            .into_iter()
            .map(|family| {
                let thresholds = family.thresholds();
                (family, thresholds)
            })
            .collect();
        let tries = families.iter().map(|(_, thresholds)| thresholds.len()).sum::<usize>().max(1);
        let least_told = (REGION_TOLD + (tries as f64).ln()) / independent_samples(errors);
        let mut best: Option<(f64, String)> = None;
        for (family, thresholds) in families {
            for (threshold, words) in thresholds {
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
                let told =
                    share * (share / of_time).ln() + if out > 0.0 { out * (out / (1.0 - of_time)).ln() } else { 0.0 };
                if told > least_told && best.as_ref().is_none_or(|(known, _)| told > *known) {
                    let (share, of_time) = (significant(100.0 * share, 2), significant(100.0 * of_time, 2));
                    best = Some((told, format!("{words}: {share} % of the error in {of_time} % of the time")));
                }
            }
        }
        best.map_or_else(|| ALIKE.to_owned(), |(_, words)| words)
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

    /// The number after these words.
    fn told(words: &str, prefix: &str) -> f64 {
        let rest = words.strip_prefix(prefix).unwrap_or_else(|| panic!("{words}"));
        rest.split(' ').next().unwrap().parse().unwrap()
    }

    #[test]
    fn the_threshold_in_words_is_the_one_in_the_data() {
        let course = swinging();
        let errors: Vec<f64> = course.velocity_m_per_s.iter().map(|v| if *v > 0.06 { 9.0 } else { 1.0 }).collect();
        let words = course.region(&errors);
        let found = told(&words, "extending faster than ");
        assert!((found - 60.0).abs() < 15.0, "{words}");
        // The shares in the words belong to the rounded threshold in the words.
        let inside = course.velocity_m_per_s.iter().filter(|v| **v >= 1e-3 * found).count() as f64 / 6000.0;
        assert!(words.ends_with(&format!("in {} % of the time", significant(100.0 * inside, 2))), "{words}");
        assert_eq!(course.region(&vec![1.0; 6000]), ALIKE);
    }

    #[test]
    fn a_region_in_which_the_error_is_hardly_larger_is_not_told() {
        let course = swinging();
        let errors = |times: f64| {
            course.velocity_m_per_s.iter().map(|v| if *v > 0.06 { times } else { 1.0 }).collect::<Vec<_>>()
        };
        assert_eq!(course.region(&errors(1.8)), ALIKE);
        assert_ne!(course.region(&errors(2.5)), ALIKE);
    }

    #[test]
    fn a_region_that_holds_most_of_all_rows_is_not_told() {
        let course = swinging();
        let errors: Vec<f64> = course.velocity_m_per_s.iter().map(|v| if *v > -0.06 { 9.0 } else { 1.0 }).collect();
        let words = course.region(&errors);
        assert!(!words.contains("faster than −") && !words.contains("faster than -"), "{words}");
        let of_time = words.rsplit_once(" in ").map(|(_, rest)| told(rest, ""));
        assert!(of_time.is_none_or(|share| share <= 67.0), "{words}");
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
        assert_eq!(course.region(&errors), ALIKE);
    }

    #[test]
    fn a_motion_that_no_sensor_sees_is_no_place() {
        let mut course = swinging();
        course.is_below_spool_seen = false;
        course.spool = course.velocity_m_per_s.iter().map(|v| 5.0 * v).collect();
        let errors: Vec<f64> = course.spool.iter().map(|x| if x.abs() > 0.4 { 9.0 } else { 1.0 }).collect();
        let words = course.region(&errors);
        assert!(told(&words, "beyond ") > 20.0 && words.contains("% opening"), "{words}");
    }

    #[test]
    fn time_since_an_event_that_never_was_is_no_time() {
        let course = Course { since_reversal_s: since(&swinging().time_s, |_| false), ..swinging() };
        let errors: Vec<f64> = (0..6000).map(|row| if row < 600 { 9.0 } else { 1.0 }).collect();
        assert!(!course.region(&errors).contains("reversal"), "{}", course.region(&errors));
    }
}
