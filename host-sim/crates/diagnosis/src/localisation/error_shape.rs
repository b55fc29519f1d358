//! What an error looks like: a single event, an oscillation, or a function of the drive's state.

use identification::fit::effective_samples;
use recording::Signal;
use simulation::signal::spectrum::SpectralLine;

/// What an error looks like over time or over the state of the drive.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Most of the error arises in one stretch of one recording.
    Once {
        /// The recording.
        recording: String,
        /// Start, s.
        from_s: f64,
        /// End, s.
        to_s: f64,
        /// Share of the squared error that arises there.
        share: f64,
    },
    /// It oscillates at one frequency.
    Periodic {
        /// Frequency, Hz.
        hz: f64,
        /// Amplitude, SI.
        amplitude: f64,
        /// The signal that shows it.
        signal: Signal,
    },
    /// It follows a state of the drive.
    Over {
        /// The state.
        state: &'static str,
        /// Its unit.
        unit: &'static str,
        /// Share of the error's variance that the means of the bins explain.
        explained: f64,
        /// Bins in order of the state.
        bins: Vec<Bin>,
        /// The pair of states that explains most, with its share, where it clearly explains more than a single state.
        pair: Option<(&'static str, &'static str, f64)>,
    },
    /// None of these.
    Everywhere,
}

/// The error in one range of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Lower end, SI.
    pub from: f64,
    /// Upper end, SI.
    pub to: f64,
    /// Mean error, in standard deviations of the noise.
    pub mean: f64,
    /// Rows.
    pub count: usize,
}

/// A state of the drive with one value for each error.
#[derive(Clone, Debug)]
pub struct State {
    /// Name.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Values.
    pub values: Vec<f64>,
}

/// Bins of one state, each with the same number of rows.
const BINS: usize = 12;
/// Bins along each of two states.
const BINS_OF_PAIR: usize = 6;
/// Share of the error that a single event holds at least.
const ONCE: f64 = 0.8;
/// Share of all time that a single event takes at most.
const BRIEF: f64 = 0.12;
/// Share of the error's power that a spectral line has to hold to count as an oscillation.
const OF_POWER: f64 = 0.25;
/// And its least power over the spectrum around it: in white noise, whose power is exponentially distributed, one bin in 10⁹ reaches this (2⁻³⁰).
const ABOVE: f64 = 30.0;
/// Errors are correlated over at most this many rows; rows further apart are independent.
const MOST_ALIKE: f64 = 50.0;
/// A state that explains less than this share of the error's variance does not count.
const EXPLAINED: f64 = 0.1;

/// The stretch of a recording in which most of the error arises, from the name, the times and the `errors` of each recording.
#[must_use]
pub fn once(recordings: &[(&str, &[f64], &[f64])]) -> Option<Shape> {
    let total: f64 = recordings.iter().flat_map(|(.., errors)| *errors).map(|error| error * error).sum();
    let time = |time_s: &[f64]| time_s.last().zip(time_s.first()).map_or(0.0, |(last, first)| last - first);
    let all: f64 = recordings.iter().map(|(_, time_s, _)| time(time_s)).sum();
    let mut best: Option<(f64, Shape)> = None;
    for (name, time_s, errors) in recordings {
        // The shortest stretch that holds enough, found by moving its two ends forward.
        let (mut from, mut held) = (0, 0.0);
        for to in 0..errors.len() {
            held += errors[to] * errors[to];
            while held - errors[from] * errors[from] > ONCE * total && from < to {
                held -= errors[from] * errors[from];
                from += 1;
            }
            let length = time_s[to] - time_s[from];
            if held > ONCE * total && length < BRIEF * all && best.as_ref().is_none_or(|(known, _)| length < *known) {
                let share = held / total;
                let shape =
                    Shape::Once { recording: (*name).to_owned(), from_s: time_s[from], to_s: time_s[to], share };
                best = Some((length, shape));
            }
        }
    }
    best.map(|(_, shape)| shape)
}

/// Whether a line is stronger than noise makes one.
#[must_use]
pub fn stands_out(line: SpectralLine) -> bool {
    line.above > ABOVE
}

/// The oscillation that a line stands for, if the line holds enough of a series with this mean square.
#[must_use]
pub fn periodic(line: SpectralLine, mean_square: f64, signal: Signal) -> Option<Shape> {
    let is = stands_out(line) && 0.5 * line.amplitude.powi(2) > OF_POWER * mean_square;
    is.then_some(Shape::Periodic { hz: line.hz, amplitude: line.amplitude, signal })
}

/// Number of independent samples in an error.
pub(crate) fn independent_samples(errors: &[f64]) -> f64 {
    effective_samples(errors).max(errors.len() as f64 / MOST_ALIKE)
}

/// The state that explains most of an error by the means of equally filled bins, less what that many means explain by chance.
#[must_use]
pub fn over(errors: &[f64], states: &[State]) -> Shape {
    let rows = errors.len() as f64;
    // Neighbouring rows are correlated, so that the same number of means explains more by chance.
    let independent = independent_samples(errors);
    let mean = errors.iter().sum::<f64>() / rows.max(1.0);
    let spread: f64 = errors.iter().map(|error| (error - mean).powi(2)).sum();
    if spread <= 0.0 || errors.len() < 4 * BINS {
        return Shape::Everywhere;
    }
    let explained = |index: &[usize], count: usize| {
        let mut sums = vec![(0.0, 0.0); count];
        for (bin, error) in index.iter().zip(errors) {
            sums[*bin].0 += error - mean;
            sums[*bin].1 += 1.0;
        }
        let between: f64 = sums.iter().filter(|(_, rows)| *rows > 0.0).map(|(sum, rows)| sum * sum / rows).sum();
        // Adjusted for the number of means; with too few samples nothing counts as explained.
        if independent < 2.0 * count as f64 {
            return 0.0;
        }
        1.0 - (1.0 - between / spread) * (independent - 1.0).max(1.0) / (independent - count as f64).max(1.0)
    };
    let ranks: Vec<Vec<usize>> = states.iter().map(|state| ranked(&state.values, BINS)).collect();
    let coarse: Vec<Vec<usize>> = states.iter().map(|state| ranked(&state.values, BINS_OF_PAIR)).collect();
    let single = (0..states.len()).map(|index| (index, explained(&ranks[index], BINS)));
    let Some((best, share)) = single.max_by(|a, b| a.1.total_cmp(&b.1)) else { return Shape::Everywhere };
    let mut pair: Option<(&'static str, &'static str, f64)> = None;
    for one in 0..states.len() {
        for other in one + 1..states.len() {
            let index: Vec<usize> = coarse[one].iter().zip(&coarse[other]).map(|(a, b)| a * BINS_OF_PAIR + b).collect();
            let both = explained(&index, BINS_OF_PAIR * BINS_OF_PAIR);
            if both > share.max(0.0) + EXPLAINED && pair.is_none_or(|(.., known)| both > known) {
                pair = Some((states[one].name, states[other].name, both));
            }
        }
    }
    if share < EXPLAINED && pair.is_none() {
        return Shape::Everywhere;
    }
    let bins = (0..BINS)
        .filter_map(|bin| {
            let inside: Vec<usize> = (0..errors.len()).filter(|row| ranks[best][*row] == bin).collect();
            let values = || inside.iter().map(|row| states[best].values[*row]);
            let count = inside.len();
            (count > 0).then(|| Bin {
                from: values().fold(f64::MAX, f64::min),
                to: values().fold(f64::MIN, f64::max),
                mean: inside.iter().map(|row| errors[*row]).sum::<f64>() / count as f64,
                count,
            })
        })
        .collect();
    Shape::Over { state: states[best].name, unit: states[best].unit, explained: share, bins, pair }
}

/// The bin of each value; bins are equally filled, and equal values share a bin.
fn ranked(values: &[f64], bins: usize) -> Vec<usize> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    values
        .iter()
        .map(|value| (sorted.partition_point(|other| other < value) * bins / values.len()).min(bins - 1))
        .collect()
}

#[cfg(test)]
mod tests {
    use simulation::signal::spectrum::strongest_line;

    use super::*;

    fn times(rows: u32) -> Vec<f64> {
        (0..rows).map(|row| f64::from(row) * 1e-3).collect()
    }

    #[test]
    fn a_pulse_in_one_recording_happens_once() {
        let time_s = times(4000);
        let quiet = vec![0.5; 4000];
        let pulse: Vec<f64> = time_s.iter().map(|t| if (1.2..1.4).contains(t) { 30.0 } else { 0.5 }).collect();
        let Some(Shape::Once { recording, from_s, to_s, .. }) =
            once(&[("quiet", &time_s, &quiet), ("pushed", &time_s, &pulse)])
        else {
            panic!("found nothing")
        };
        assert_eq!(recording, "pushed");
        assert!((1.19..1.25).contains(&from_s) && (1.35..1.41).contains(&to_s), "{from_s} {to_s}");
        assert_eq!(once(&[("a", &time_s, &pulse), ("b", &time_s, &pulse)]), None);
    }

    #[test]
    fn a_sine_is_periodic_and_a_drift_is_not() {
        let sine: Vec<f64> = times(3000).iter().map(|t| 2e5 * (std::f64::consts::TAU * 85.0 * t).sin()).collect();
        let line = strongest_line(&sine, 1e-3, 10.0).unwrap();
        let shape = periodic(line, 2e10, Signal::PressureA).unwrap();
        assert!(matches!(shape, Shape::Periodic { hz, .. } if (hz - 85.0).abs() < 0.5), "{shape:?}");
        let drift = times(3000);
        let line = strongest_line(&drift, 1e-3, 10.0);
        assert_eq!(line.and_then(|line| periodic(line, 0.75, Signal::PressureA)), None);
    }

    #[test]
    fn an_error_that_is_a_function_of_velocity_is_found_over_velocity() {
        let velocity: Vec<f64> = times(4000).iter().map(|t| 0.2 * (3.0 * t).sin()).collect();
        let errors: Vec<f64> = velocity.iter().map(|v| if v.abs() < 0.02 { 8.0 } else { 0.0 }).collect();
        let states = [
            State { name: "time", unit: "s", values: times(4000) },
            State { name: "velocity", unit: "m/s", values: velocity },
        ];
        let Shape::Over { state, explained, bins, .. } = over(&errors, &states) else { panic!("found nothing") };
        assert_eq!(state, "velocity");
        assert!(explained > 0.3, "{explained}");
        let peak = bins.iter().max_by(|a, b| a.mean.total_cmp(&b.mean)).unwrap();
        assert!(peak.from > -0.06 && peak.to < 0.06, "{peak:?}");
    }
}
