//! Recordings cut to what a search can afford: a search simulates each of them a thousand times, a refit of the whole only a dozen times.
//!
//! Of long recordings the first part is searched; of very many recordings, some that are spread evenly over all. What is found there is refitted on
//! all recordings in full length, which have to accept it ([`super::full_length::lengthened`]).

use identification::experiment::{JudgedSignal, Prepared};
use identification::fit::StartState;
use machine_file::LoadSource;
use model_core::machine::Machine;
use recording::Recording;
use simulation::sensor_fault::{Failures, RangeEnd, Stretch};
use simulation::{SimulateError, Stimulus};

/// Ticks up to which recordings are searched as they are: four minutes at 1 kHz, which two cores search in about as much time.
pub const AFFORDABLE_TICKS: usize = 250_000;

/// Ticks that longer ones are cut to, all together: a minute at 1 kHz has dozens of strokes, and half an hour of the same strokes shows no more of
/// what happens in each.
pub const MOST_TICKS: usize = 60_000;

/// No recording is cut to less than ten seconds at 1 kHz, since its first second is mostly rest.
const LEAST_TICKS: usize = 10_000;

/// Most recordings that are searched; of more, this number is taken.
const MOST_RECORDINGS: usize = AFFORDABLE_TICKS / LEAST_TICKS;

/// The first parts of recordings, each in both of its forms.
#[derive(Clone, Debug)]
pub struct Excerpt {
    /// Indices of the recordings that they are parts of.
    of: Vec<usize>,
    /// As recorded.
    pub recordings: Vec<Recording>,
    /// As prepared, with the noise that the whole recording shows.
    pub cases: Vec<Prepared>,
}

impl Excerpt {
    /// The excerpt of training recordings, given as recorded and as prepared; `None` where a search can afford them as they are.
    pub fn of(
        recordings: &[Recording],
        prepared: &[Prepared],
        machine: &Machine<f64>,
        load: LoadSource,
    ) -> Result<Option<Self>, SimulateError> {
        let ticks: Vec<usize> = prepared.iter().map(|case| case.stimulus.ticks()).collect();
        if ticks.iter().sum::<usize>() <= AFFORDABLE_TICKS {
            return Ok(None);
        }
        let of = spread(ticks.len(), MOST_RECORDINGS);
        let searched: Vec<usize> = of.iter().map(|&index| ticks[index]).collect();
        let most = fair_share(&searched, MOST_TICKS).map_or(usize::MAX, |share| share.max(LEAST_TICKS));
        let first = |&index: &usize| recordings[index].first(rows_within(&prepared[index], most));
        let recordings: Vec<Recording> = of.iter().map(first).collect();
        let cases = recordings
            .iter()
            .zip(&of)
            .map(|(recording, &index)| begun(recording, &prepared[index], machine, load))
            .collect::<Result<_, _>>()?;
        Ok(Some(Self { of, recordings, cases }))
    }

    /// The same with its parts prepared in another way.
    #[must_use]
    pub fn with(&self, cases: Vec<Prepared>) -> Self {
        Self { cases, ..self.clone() }
    }

    /// Initial states of all `recordings`: `starts` for those in the excerpt, for the others the default from machine and recording.
    #[must_use]
    pub fn starts_of_all(&self, starts: &[StartState], recordings: usize) -> Vec<StartState> {
        let mut all = vec![StartState::default(); recordings];
        for (&index, start) in self.of.iter().zip(starts) {
            all[index] = *start;
        }
        all
    }
}

/// At most `most` of `count`, spread evenly; all where there are no more.
fn spread(count: usize, most: usize) -> Vec<usize> {
    let taken = count.min(most);
    (0..taken).map(|index| index * count / taken).collect()
}

/// The most that each may have so that all together have no more than `most`; what short ones do not need is given to the long ones. `None` where
/// every one fits in full.
fn fair_share(sizes: &[usize], most: usize) -> Option<usize> {
    let mut sorted = sizes.to_vec();
    sorted.sort_unstable();
    let mut left = most;
    for (index, &size) in sorted.iter().enumerate() {
        let share = left / (sorted.len() - index);
        if size > share {
            return Some(share);
        }
        left -= size;
    }
    None
}

/// Rows of a recording within this number of ticks, at least two.
fn rows_within(case: &Prepared, ticks: usize) -> usize {
    let first = case.time_s.first().copied().unwrap_or_default();
    let longest_s = ticks as f64 * case.stimulus.tick.seconds();
    case.time_s.partition_point(|time| time - first <= longest_s).max(2)
}

/// A recording's first part, prepared like the whole recording.
fn begun(
    recording: &Recording,
    whole: &Prepared,
    machine: &Machine<f64>,
    load: LoadSource,
) -> Result<Prepared, SimulateError> {
    let rows = recording.rows();
    let stimulus = Stimulus::new(recording, machine, whole.stimulus.input_point, load, whole.stimulus.tick)?;
    Ok(Prepared {
        name: whole.name.clone(),
        time_s: recording.time_s().to_vec(),
        stimulus,
        tick: whole.tick,
        channels: whole.channels.iter().map(|channel| first(channel, rows)).collect(),
        failures: whole.failures.iter().map(|(signal, failures)| (*signal, first_failures(failures, rows))).collect(),
        unsettled: whole.unsettled.min(rows),
        start_sigma_m: whole.start_sigma_m,
        input_noise: whole.input_noise,
        effort: whole.effort.clone(),
    })
}

fn first(channel: &JudgedSignal, rows: usize) -> JudgedSignal {
    JudgedSignal {
        signal: channel.signal,
        recorded: channel.recorded.iter().take(rows).copied().collect(),
        tolerance: channel.tolerance,
        failed: channel.failed.iter().take(rows).copied().collect(),
        stretches: first_stretches(&channel.stretches, rows),
        ends: first_ends(&channel.ends, rows),
        noise: channel.noise,
        input_noise: channel.input_noise,
    }
}

fn first_failures(failures: &Failures, rows: usize) -> Failures {
    Failures {
        spikes: failures.spikes.iter().take(rows).copied().collect(),
        stretches: first_stretches(&failures.stretches, rows),
        ends: first_ends(&failures.ends, rows),
    }
}

fn first_ends(ends: &[RangeEnd], rows: usize) -> Vec<RangeEnd> {
    let first = |end: &RangeEnd| RangeEnd { rows: end.rows.iter().take(rows).copied().collect(), ..*end };
    ends.iter().map(first).collect()
}

fn first_stretches(stretches: &[Stretch], rows: usize) -> Vec<Stretch> {
    let begun = stretches.iter().filter(|stretch| stretch.from < rows);
    begun.map(|stretch| Stretch { to: stretch.to.min(rows), ..*stretch }).collect()
}

#[cfg(test)]
mod tests {
    use model_core::machine::Source;
    use recording::{Column, Signal};

    use super::*;

    fn recording(rows: u32) -> Recording {
        let column = |signal, of: fn(f64) -> f64| Column::si(signal, (0..rows).map(|row| of(f64::from(row))).collect());
        let columns = vec![
            column(Signal::Time, |row| 3.0 + 2e-3 * row),
            column(Signal::Command, |row| (1e-3 * row).sin()),
            column(Signal::Position, |row| 0.15 + 1e-2 * (1e-3 * row).cos()),
        ];
        Recording::new("r.csv", columns).unwrap()
    }

    fn excerpt(rows: &[u32]) -> Option<Excerpt> {
        let machine = Machine::with_defaults(Source::Valve);
        let recordings: Vec<Recording> = rows.iter().map(|rows| recording(*rows)).collect();
        let prepare = |recording| Prepared::new(recording, &machine, LoadSource::Constant, None).unwrap();
        let prepared: Vec<Prepared> = recordings.iter().map(prepare).collect();
        Excerpt::of(&recordings, &prepared, &machine, LoadSource::Constant).unwrap()
    }

    #[test]
    fn what_short_ones_leave_goes_to_the_long_ones() {
        assert_eq!(fair_share(&[10, 20, 30], 60), None);
        assert_eq!(fair_share(&[100, 10, 100], 60), Some(25));
        assert_eq!(fair_share(&[100], 60), Some(60));
    }

    #[test]
    fn of_very_many_recordings_some_are_searched_that_are_spread_over_all() {
        assert_eq!(spread(3, 5), [0, 1, 2]);
        assert_eq!(spread(10, 4), [0, 2, 5, 7]);
        let found = excerpt(&[6000; 100]).unwrap();
        assert_eq!(found.cases.len(), MOST_RECORDINGS);
        let ticks: usize = found.cases.iter().map(|case| case.stimulus.ticks()).sum();
        assert!(ticks <= AFFORDABLE_TICKS, "{ticks}");
    }

    #[test]
    fn short_recordings_are_searched_as_they_are_and_long_ones_from_their_start() {
        assert!(excerpt(&[2000, 122_000]).is_none());
        let found = excerpt(&[5000, 130_000]).unwrap();
        let rows: Vec<usize> = found.cases.iter().map(Prepared::rows).collect();
        // A row takes two ticks.
        assert!(rows[0] == 5000 && rows[1].abs_diff(25_000) < 3, "{rows:?}");
        for (recording, case) in found.recordings.iter().zip(&found.cases) {
            assert_eq!(recording.time_s(), case.time_s);
            assert_eq!(case.stimulus.rows(), case.rows());
            assert!(case.channels.iter().all(|channel| channel.recorded.len() == case.rows()));
        }
        let ticks: usize = found.cases.iter().map(|case| case.stimulus.ticks()).sum();
        assert!(ticks.abs_diff(MOST_TICKS) < 3, "{ticks}");
    }
}
