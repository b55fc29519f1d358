//! The clock of a recording: its time stamps, and the delay of a channel relative to the model.
//!
//! A recording has one clock and nothing to compare it with. A clock that runs fast looks like a drive that is faster in everything, and
//! changes the valve's fitted gain and time constants; a shift that all channels share changes the fitted transport delay. Neither can be
//! distinguished from the drive, so neither is accepted. What can be found is a channel whose residual has the shape of its own derivative.

use recording::Signal;
use simulation::signal::noise::median;
use simulation::signal::slope::slopes;

use crate::fit::effective_samples;

/// An interval of more than this many times the usual one has lost rows.
const LOST: f64 = 1.5;
/// An interval that differs from the usual one by more than this share is uneven: times are written with a few digits.
const UNEVEN: f64 = 0.02;
/// Share of the residual's square that a shift has to explain; if it explains less, something else that also grows with motion is the cause.
const EXPLAINED: f64 = 0.5;
/// Least size of a shift, in standard deviations.
const CERTAIN: f64 = 5.0;

/// What the time stamps show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stamps {
    /// Median interval between rows, s.
    pub interval_s: f64,
    /// Rows that are missing at that interval.
    pub lost: usize,
    /// Intervals, without those of lost rows, that are uneven.
    pub uneven: usize,
}

impl Stamps {
    /// From at least two rising times.
    #[must_use]
    pub fn of(time_s: &[f64]) -> Self {
        let mut intervals: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let interval_s = median(&mut intervals);
        let (mut lost, mut uneven) = (0.0, 0);
        for interval in intervals {
            if interval > LOST * interval_s {
                lost += (interval / interval_s).round() - 1.0;
            } else if (interval / interval_s - 1.0).abs() > UNEVEN {
                uneven += 1;
            }
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        Self { interval_s, lost: lost as usize, uneven }
    }
}

/// Delay of a channel relative to the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shift {
    /// The channel.
    pub signal: Signal,
    /// Delay of the recorded signal after the simulated one, s; negative is earlier.
    pub late_s: f64,
    /// Its standard deviation, s, which accounts for the correlation of the remaining residual in time.
    pub std_s: f64,
}

impl Shift {
    /// The shift that explains most of the residual, if it explains at least half of it and is certain.
    ///
    /// `missed` is recorded minus simulated; rows where the sensor `failed` are not counted.
    #[must_use]
    pub fn of(signal: Signal, time_s: &[f64], missed: &[f64], simulated: &[f64], failed: &[bool]) -> Option<Self> {
        let judged = |series: &[f64]| -> Vec<f64> {
            series.iter().zip(failed).map(|(value, failed)| if *failed { 0.0 } else { *value }).collect()
        };
        let (slopes, missed) = (judged(&slopes(time_s, simulated, 1)), &judged(missed));
        let square: f64 = slopes.iter().map(|slope| slope * slope).sum();
        if square <= 0.0 {
            return None;
        }
        let late_s = -missed.iter().zip(&slopes).map(|(missed, slope)| missed * slope).sum::<f64>() / square;
        let left: Vec<f64> = missed.iter().zip(&slopes).map(|(missed, slope)| missed + late_s * slope).collect();
        let sum = |series: &[f64]| series.iter().map(|value| value * value).sum::<f64>();
        let std_s = (sum(&left) / effective_samples(&left) / square).sqrt();
        let shown = sum(&left) < (1.0 - EXPLAINED) * sum(missed) && late_s.abs() > CERTAIN * std_s;
        shown.then_some(Self { signal, late_s, std_s })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lost_rows_and_uneven_ones_are_counted() {
        let mut time_s: Vec<f64> = (0..100).map(|row| f64::from(row) * 2e-3).collect();
        assert_eq!(Stamps::of(&time_s), Stamps { interval_s: Stamps::of(&time_s).interval_s, lost: 0, uneven: 0 });
        time_s.drain(50..53);
        time_s[20] += 5e-4;
        let stamps = Stamps::of(&time_s);
        assert!((stamps.interval_s - 2e-3).abs() < 1e-9);
        assert_eq!((stamps.lost, stamps.uneven), (3, 2));
    }

    #[test]
    fn a_late_channel_is_found_and_a_wrong_gain_is_no_shift() {
        let time_s: Vec<f64> = (0..4000).map(|row| f64::from(row) * 1e-3).collect();
        let at = |time: f64| (3.0 * time).sin() + 0.4 * (11.0 * time).cos();
        let mut seed = 3_u32;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            2e-3 * (f64::from(seed >> 8) / f64::from(1 << 24) - 0.5)
        };
        let simulated: Vec<f64> = time_s.iter().map(|time| at(*time)).collect();
        let works = vec![false; time_s.len()];
        let late: Vec<f64> = time_s.iter().map(|time| at(time - 4e-3) - at(*time) + noise()).collect();
        let shift = Shift::of(Signal::Position, &time_s, &late, &simulated, &works).unwrap();
        assert!((shift.late_s - 4e-3).abs() < 1e-4, "{shift:?}");
        let even: Vec<f64> = time_s.iter().map(|_| noise()).collect();
        assert_eq!(Shift::of(Signal::Position, &time_s, &even, &simulated, &works), None);
        let larger: Vec<f64> = simulated.iter().map(|value| 0.02 * value + noise()).collect();
        assert_eq!(Shift::of(Signal::Position, &time_s, &larger, &simulated, &works), None);
    }
}
