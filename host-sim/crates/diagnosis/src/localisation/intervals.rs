//! When an error arises: the stretches of the recordings that hold more of it than their share of the time.

use simulation::signal::window::running_sums;

use super::operating_region::TWICE;

/// A stretch of a recording.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Interval {
    /// The recording.
    pub recording: String,
    /// Start, s.
    pub from_s: f64,
    /// End, s.
    pub to_s: f64,
    /// Share of the error of all recordings that arises in it.
    pub share: f64,
}

/// The error of one recording, in standard deviations of the noise.
pub(crate) struct Series<'a> {
    pub(crate) recording: &'a str,
    pub(crate) time_s: &'a [f64],
    pub(crate) errors: Vec<f64>,
}

/// When the error of all recordings arises.
#[derive(Debug, Default)]
pub(crate) struct When {
    /// The intervals with the largest share first, at most five per recording; empty where no time is distinguished.
    pub(crate) intervals: Vec<Interval>,
    /// Share of the error in them.
    pub(crate) share: f64,
    /// Share of the rows in them.
    pub(crate) of_time: f64,
}

/// Largest number of intervals per recording.
const MOST: usize = 5;
/// The error at a row is the mean square around it, over the recording's length divided by this.
const PARTS: usize = 100;
/// Least mean square that counts as an error, in variances of the noise: three standard deviations.
const LEAST_SQUARE: f64 = 9.0;
/// Share of all time that the intervals take at most: with more, no time is distinguished.
const MOST_ROWS: f64 = 0.5;
/// Multiples of the mean over all recordings that the mean square of a stretch has to exceed; the first at which stretches are distinguished is used.
const ABOVE: [f64; 4] = [1.0, 2.0, 4.0, 8.0];

/// First and last row of a stretch, and the squared error in it.
#[derive(Clone, Copy)]
struct Stretch {
    first: usize,
    last: usize,
    square: f64,
}

impl Stretch {
    fn rows(&self) -> f64 {
        (self.last - self.first + 1) as f64
    }
}

/// The stretches in which the error is at least twice the error elsewhere, in root mean square, over all recordings together. A stretch may be
/// a whole recording, where the others hold little of the error.
pub(crate) fn when(all: &[Series<'_>]) -> When {
    let rows: f64 = all.iter().map(|series| series.errors.len() as f64).sum();
    let square: f64 = all.iter().flat_map(|series| &series.errors).map(|error| error * error).sum();
    if square <= 0.0 {
        return When::default();
    }
    for above in ABOVE {
        let threshold = (above * square / rows).max(LEAST_SQUARE);
        let mut found: Vec<Vec<Stretch>> = all.iter().map(|series| stretches(&series.errors, threshold)).collect();
        let shares = |found: &[Vec<Stretch>]| {
            let stretches = || found.iter().flatten();
            let held: f64 = stretches().map(|stretch| stretch.square).sum();
            (held / square, stretches().map(Stretch::rows).sum::<f64>() / rows)
        };
        let (share, of_time) = shares(&found);
        if of_time > 0.0 && of_time <= MOST_ROWS && share * (1.0 - of_time) >= TWICE * (1.0 - share) * of_time {
            // All stretches together decide whether they are distinguished; those with most of the error are reported.
            for found in &mut found {
                found.truncate(MOST);
            }
            let (share, of_time) = shares(&found);
            let mut intervals: Vec<Interval> = all
                .iter()
                .zip(&found)
                .flat_map(|(series, found)| {
                    found.iter().map(|stretch| Interval {
                        recording: series.recording.to_owned(),
                        from_s: series.time_s[stretch.first],
                        to_s: series.time_s[stretch.last],
                        share: stretch.square / square,
                    })
                })
                .collect();
            intervals.sort_by(|a, b| b.share.total_cmp(&a.share));
            return When { intervals, share, of_time };
        }
    }
    When::default()
}

/// The stretches of a recording in which the mean square over a hundredth of its length is above a threshold, those with most of the error first.
fn stretches(errors: &[f64], threshold: f64) -> Vec<Stretch> {
    let half = errors.len() / (2 * PARTS);
    let sums = running_sums(errors.iter().map(|error| error * error));
    let (mut found, mut open): (Vec<Stretch>, Option<usize>) = (Vec::new(), None);
    for row in 0..=errors.len() {
        let is_large = row < errors.len() && {
            let (from, to) = (row.saturating_sub(half), (row + half + 1).min(errors.len()));
            sums[to] - sums[from] > threshold * (to - from) as f64
        };
        match (is_large, open) {
            (true, None) => open = Some(row),
            (false, Some(first)) => {
                found.push(Stretch { first, last: row - 1, square: sums[row] - sums[first] });
                open = None;
            }
            _ => {}
        }
    }
    // A stretch shorter than half of the rows that are averaged only touches the threshold.
    found.retain(|stretch| stretch.last - stretch.first >= half.max(1));
    found.sort_by(|a, b| b.square.total_cmp(&a.square));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(rows: u32) -> Vec<f64> {
        (0..rows).map(|row| f64::from(row) * 1e-3).collect()
    }

    #[test]
    fn what_only_touches_the_level_is_no_stretch() {
        // Means are over 41 rows: one large row raises 41 means; with another 30 rows later, the eleven means that contain both rise twice as far.
        let errors =
            |large: &[usize]| (0..4000).map(|row| if large.contains(&row) { 6.0 } else { 0.0 }).collect::<Vec<f64>>();
        assert_eq!(stretches(&errors(&[1000]), 0.8).len(), 1);
        assert!(stretches(&errors(&[1000, 1030]), 1.0).is_empty());
    }

    #[test]
    fn a_bump_is_when_the_error_is_made_with_its_share() {
        let time_s = times(4000);
        let bump: Vec<f64> = time_s.iter().map(|t| if (1.0..1.4).contains(t) { 12.0 } else { 1.0 }).collect();
        let quiet = vec![1.0; 4000];
        let all = [
            Series { recording: "quiet", time_s: &time_s, errors: quiet },
            Series { recording: "bump", time_s: &time_s, errors: bump },
        ];
        let When { intervals, share, of_time } = when(&all);
        let [interval] = intervals.as_slice() else { panic!("{intervals:?}") };
        assert_eq!(interval.recording, "bump");
        assert!((0.97..1.01).contains(&interval.from_s) && (1.39..1.43).contains(&interval.to_s), "{interval:?}");
        assert!(share > 0.85 && (share - interval.share).abs() < 1e-12 && of_time < 0.06, "{share} {of_time}");
    }

    #[test]
    fn an_error_that_is_there_all_the_time_has_no_time_of_its_own() {
        let time_s = times(4000);
        for errors in [vec![8.0; 4000], time_s.iter().map(|t| 30.0 * (40.0 * t).sin()).collect()] {
            let found = when(&[Series { recording: "one", time_s: &time_s, errors }]);
            assert!(found.intervals.is_empty() && found.share == 0.0, "{found:?}");
        }
    }

    #[test]
    fn a_recording_that_alone_misses_is_when_as_a_whole() {
        let time_s = times(2000);
        let of = |recording, size: f64| Series { recording, time_s: &time_s, errors: vec![size; 2000] };
        let found = when(&[of("still", 1.0), of("fast", 20.0), of("slow", 1.0)]);
        let [interval] = found.intervals.as_slice() else { panic!("{found:?}") };
        assert_eq!((interval.recording.as_str(), interval.from_s), ("fast", 0.0));
        assert!((interval.to_s - 1.999).abs() < 1e-9 && found.share > 0.99);
    }
}
