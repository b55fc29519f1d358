//! In which states of the drive an error is made, in words, with thresholds that the data give.

use crate::presentation::significant;

/// The drive along all recordings, a value a row, SI.
#[derive(Clone, Debug, Default)]
pub struct Course {
    /// Time in the recording, s.
    pub time_s: Vec<f64>,
    /// Velocity, m/s.
    pub velocity_m_per_s: Vec<f64>,
    /// Position, m.
    pub position_m: Vec<f64>,
    /// Slider.
    pub slider: Vec<f64>,
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
}

/// A family of regions: all rows of a group whose value is on one side of a threshold.
struct Family {
    /// Value and whether the row belongs to the group at all.
    values: Vec<(f64, bool)>,
    /// Whether the region is below the threshold.
    below: bool,
    words: fn(f64) -> String,
}

/// Thresholds tried for each family: quantiles of its values.
const TRIES: usize = 24;
/// A region tells so much more of the error than its share of time (nats) or is none.
const LEAST_TOLD: f64 = 0.05;
/// A region is short of all states.
const MOST_ROWS: f64 = 0.7;

impl Course {
    fn each(&self, value: impl Fn(usize) -> f64, inside: impl Fn(usize) -> bool) -> Vec<(f64, bool)> {
        (0..self.time_s.len()).map(|row| (value(row), inside(row))).collect()
    }

    fn families(&self) -> Vec<Family> {
        let v = &self.velocity_m_per_s;
        let fastest = v.iter().fold(0.0_f64, |fastest, v| fastest.max(v.abs()));
        let rests = |row: usize| v[row].abs() < 0.01 * fastest;
        let everywhere = |_: usize| true;
        let (a, b) = (&self.pressure_a_pa, &self.pressure_b_pa);
        let mut families = vec![
            Family {
                values: self.each(|row| v[row].abs(), |row| v[row] > 0.0 && !rests(row)),
                below: true,
                words: |t| format!("velocity within {} mm/s of zero, while extending", significant(1e3 * t, 2)),
            },
            Family {
                values: self.each(|row| v[row].abs(), |row| v[row] < 0.0 && !rests(row)),
                below: true,
                words: |t| format!("velocity within {} mm/s of zero, while retracting", significant(1e3 * t, 2)),
            },
            Family {
                values: self.each(|row| v[row].abs(), everywhere),
                below: true,
                words: |t| {
                    if t < 5e-5 {
                        "while the rod rests".to_owned()
                    } else {
                        format!("velocity within {} mm/s of zero", significant(1e3 * t, 2))
                    }
                },
            },
            Family {
                values: self.each(|row| v[row], everywhere),
                below: false,
                words: |t| format!("extending faster than {} mm/s", significant(1e3 * t, 2)),
            },
            Family {
                values: self.each(|row| -v[row], everywhere),
                below: false,
                words: |t| format!("retracting faster than {} mm/s", significant(1e3 * t, 2)),
            },
            Family {
                values: self.each(|row| self.slider[row].abs(), everywhere),
                below: false,
                words: |t| format!("beyond {} % opening", significant(100.0 * t, 2)),
            },
            Family {
                values: self.each(|row| self.slider[row].abs(), |row| !rests(row)),
                below: true,
                words: |t| format!("below {} % opening, while moving", significant(100.0 * t, 2)),
            },
            Family {
                values: self.each(|row| self.command_v[row].abs(), everywhere),
                below: false,
                words: |t| format!("at a command beyond {} V", significant(t, 2)),
            },
            Family {
                values: self.each(|row| self.position_m[row], everywhere),
                below: false,
                words: |t| format!("position beyond {} mm", significant(1e3 * t, 3)),
            },
            Family {
                values: self.each(|row| self.position_m[row], everywhere),
                below: true,
                words: |t| format!("position below {} mm", significant(1e3 * t, 3)),
            },
            Family {
                values: self.each(|row| self.since_reversal_s[row], |row| !rests(row)),
                below: true,
                words: |t| format!("within {} ms after a reversal", significant(1e3 * t, 2)),
            },
            Family {
                values: self.each(|row| self.since_rest_s[row], |row| !rests(row)),
                below: true,
                words: |t| format!("within {} ms after a start", significant(1e3 * t, 2)),
            },
            Family {
                values: self.each(|row| self.time_s[row], everywhere),
                below: false,
                words: |t| format!("after {} s", significant(t, 2)),
            },
        ];
        families.push(Family {
            values: self.each(|row| a[row].min(b[row]), everywhere),
            below: true,
            words: |t| format!("with a chamber below {} bar", significant(1e-5 * t, 2)),
        });
        families.push(Family {
            values: self.each(|row| a[row].max(b[row]), everywhere),
            below: false,
            words: |t| format!("with a chamber above {} bar", significant(1e-5 * t, 2)),
        });
        families
    }

    /// The region that tells most of where the error is made: how its share of the error differs from its share of the time,
    /// as the divergence of the two in nats.
    #[must_use]
    pub fn region(&self, errors: &[f64]) -> String {
        let total: f64 = errors.iter().map(|error| error * error).sum();
        let mut best: Option<(f64, String)> = None;
        for family in self.families() {
            let mut sorted: Vec<f64> =
                family.values.iter().filter(|(_, inside)| *inside).map(|(value, _)| *value).collect();
            // A signal that was never there has no regions.
            if sorted.len() < TRIES || sorted.iter().all(|value| value.to_bits() == sorted[0].to_bits()) {
                continue;
            }
            sorted.sort_by(f64::total_cmp);
            for index in 1..TRIES {
                let threshold = sorted[index * sorted.len() / TRIES];
                let (mut rows, mut held) = (0.0, 0.0);
                for ((value, inside), error) in family.values.iter().zip(errors) {
                    if *inside && (if family.below { *value <= threshold } else { *value >= threshold }) {
                        rows += 1.0;
                        held += error * error;
                    }
                }
                let (share, of_time) = (held / total, rows / errors.len() as f64);
                if !(share > of_time && share > 1.0 / 3.0 && of_time < MOST_ROWS) {
                    continue;
                }
                let out = 1.0 - share;
                let told =
                    share * (share / of_time).ln() + if out > 0.0 { out * (out / (1.0 - of_time)).ln() } else { 0.0 };
                if told > LEAST_TOLD && best.as_ref().is_none_or(|(known, _)| told > *known) {
                    let words = (family.words)(threshold);
                    let (share, of_time) = (100.0 * share, 100.0 * of_time);
                    best = Some((told, format!("{words}: {share:.0} % of the error in {of_time:.0} % of the time")));
                }
            }
        }
        best.map_or_else(|| "everywhere alike".to_owned(), |(_, words)| words)
    }
}

/// Time since a condition last changed (or held), at each row, s.
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
            (time - last).min(1e3)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_threshold_in_words_is_the_one_in_the_data() {
        let rows = 6000;
        let time_s: Vec<f64> = (0..rows).map(|row| f64::from(row) * 1e-3).collect();
        let velocity: Vec<f64> = time_s.iter().map(|t| 0.1 * (2.0 * t).sin()).collect();
        let zeros = vec![0.0; time_s.len()];
        let errors: Vec<f64> = velocity.iter().map(|v| if *v > 0.06 { 9.0 } else { 1.0 }).collect();
        let course = Course {
            velocity_m_per_s: velocity,
            position_m: zeros.clone(),
            slider: zeros.clone(),
            command_v: zeros.clone(),
            pressure_a_pa: zeros.clone(),
            pressure_b_pa: zeros.clone(),
            since_reversal_s: zeros.clone(),
            since_rest_s: zeros.clone(),
            time_s,
        };
        let words = course.region(&errors);
        let found: f64 =
            words.strip_prefix("extending faster than ").unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!((found - 60.0).abs() < 15.0, "{words}");
        assert_eq!(course.region(&vec![1.0; 6000]), "everywhere alike");
    }
}
