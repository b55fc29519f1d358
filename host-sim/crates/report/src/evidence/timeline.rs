//! When the error is made: every training recording in a row, with the located intervals.
//!
//! It shows the located signal: the one with the largest misfit in its link, in standard deviations of its noise; for a position,
//! the change of its error, since a position keeps earlier errors. The largest value in each stretch of time is shown.

use diagnosis::localisation::locate::made;
use diagnosis::{Diagnosis, Shown};
use recording::Signal;
use simulation::Trajectory;
use simulation::signal::noise::quantile;

use crate::plot::{Row, Rows, Style, Trace, within_title};

/// Number of stretches in the longest recording.
const STRETCHES: u32 = 400;
/// Share of all stretches that stay below the top of a row: single spikes do not flatten the others.
const BELOW_TOP: f64 = 0.99;

/// The rows of all training recordings, before and, where it differs, after; `None` where nothing was located.
#[must_use]
pub(super) fn timeline(diagnosis: &Diagnosis) -> Option<Rows> {
    let location = diagnosis.located.as_ref()?;
    let training: Vec<&Shown> = diagnosis.shown.iter().filter(|shown| !shown.held_out).collect();
    let ends = |shown: &&Shown| Some((*shown.prepared.time_s.first()?, *shown.prepared.time_s.last()?));
    let (from_s, to_s) = training
        .iter()
        .filter_map(ends)
        .fold((f64::MAX, f64::MIN), |all, (from, to)| (f64::min(all.0, from), f64::max(all.1, to)));
    if from_s >= to_s {
        return None;
    }
    let step_s = (to_s - from_s) / f64::from(STRETCHES);
    let time_s: Vec<f64> = (0..STRETCHES).map(|index| from_s + (f64::from(index) + 0.5) * step_s).collect();
    let of = |shown: &Shown, trajectory: &Trajectory| {
        let errors = errors(shown, trajectory, location.signal)?;
        Some(largest(&shown.prepared.time_s, &errors, from_s, step_s))
    };
    let changes = diagnosis.changes();
    let mut sizes = Vec::new();
    let rows = training
        .iter()
        .filter_map(|shown| {
            let before = of(shown, &shown.before)?;
            sizes.extend(before.iter().copied().filter(|size| size.is_finite()));
            let mut traces = vec![Trace::new(diagnosis.before_is_called(), before, Style::Before)];
            if changes {
                traces.push(Trace::new("after", of(shown, &shown.after)?, Style::After));
            }
            let here = location.intervals.iter().filter(|interval| interval.recording == shown.prepared.name);
            let intervals = here.map(|interval| (interval.from_s, interval.to_s)).collect();
            Some(Row { label: shown.prepared.name.clone(), traces, intervals })
        })
        .collect();
    let most = quantile(sizes, BELOW_TOP).unwrap_or(1.0).max(1.0);
    let title = format!("Largest {} over time", error_in(location.signal));
    Some(Rows { title, unit: "× noise".to_owned(), time_s, most, rows })
}

/// What [`errors`] show for a signal.
pub(crate) fn error_in(signal: Signal) -> String {
    let what = if signal == Signal::Position { "change of the error" } else { "error" };
    format!("{what} in {}", within_title(signal))
}

/// Error over noise at the moment when it is made, for each row.
pub(crate) fn errors(shown: &Shown, trajectory: &Trajectory, signal: Signal) -> Option<Vec<f64>> {
    let channel = shown.prepared.channels.iter().find(|channel| channel.signal == signal)?;
    Some(made(signal, &shown.prepared.time_s, &channel.over_noise(trajectory.signal(signal)?)))
}

/// The largest absolute value in each stretch of time; not finite where there is no row.
fn largest(time_s: &[f64], errors: &[f64], from_s: f64, step_s: f64) -> Vec<f64> {
    let mut sizes = vec![f64::NAN; STRETCHES as usize];
    for (time, error) in time_s.iter().zip(errors) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a stretch")]
        let stretch = ((time - from_s) / step_s) as usize;
        let size = &mut sizes[stretch.min(STRETCHES as usize - 1)];
        *size = size.max(error.abs());
    }
    // If a recording has fewer rows than stretches, its values are held between the rows.
    for index in 1..sizes.len() {
        let here = from_s + (index as f64 + 0.5) * step_s;
        if sizes[index].is_nan() && time_s.last().is_some_and(|last| here <= *last) {
            sizes[index] = sizes[index - 1];
        }
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_stays_and_a_short_recording_ends_where_it_ends() {
        let time_s: Vec<f64> = (0..=2000).map(|row| f64::from(row) * 1e-3).collect();
        let mut errors = vec![0.5; time_s.len()];
        errors[1234] = -8.0;
        let sizes = largest(&time_s, &errors, 0.0, 4.0 / f64::from(STRETCHES));
        assert!((sizes[123] - 8.0).abs() < 1e-12 && (sizes[10] - 0.5).abs() < 1e-12, "{sizes:?}");
        assert!(sizes[202..].iter().all(|size| size.is_nan()));
        let slow: Vec<f64> = (0..=20).map(|row| f64::from(row) * 0.1).collect();
        let sizes = largest(&slow, &[1.0; 21], 0.0, 2.0 / f64::from(STRETCHES));
        assert!(sizes.iter().all(|size| size.is_finite()));
    }
}
