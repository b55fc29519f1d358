//! Whether the position follows what drives the model instead of integrating it, as far as a linear model and a rough refit tell.

use identification::experiment::Prepared;
use identification::fit::{FitError, Free};
use identification::yardstick::yardsticks;
use machine_file::MachineFile;
use recording::{Recording, Signal};

use super::MOST_RECORDINGS;
use super::trial::rough_fit_percent;
use crate::selection::decision_rule::LEAST_EXPLAINED;
use crate::structure::{Shows, follows};

/// A position that follows what drives the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follower {
    /// Mean NRMSE fit of the linear model that follows, %.
    pub follows_percent: f64,
}

/// Whether the position of these recordings follows what drives the model: a linear model says so, and leaves at most half of the square error of the
/// drive's own model, roughly refitted.
pub fn follower(file: &MachineFile, free: &[Free], recordings: &[&Recording]) -> Result<Option<Follower>, FitError> {
    let prepare = |recording: &&Recording| Prepared::new(recording, &file.machine, file.load_source, None).ok();
    let Some(cases) = recordings.iter().map(prepare).collect::<Option<Vec<Prepared>>>() else { return Ok(None) };
    let linear = yardsticks(&cases.iter().collect::<Vec<_>>(), &[]);
    let position = linear.iter().find(|yardstick| yardstick.signal == Signal::Position);
    let Some(Shows::Follows { follows_percent, .. }) = position.and_then(follows) else { return Ok(None) };
    let few = &recordings[..recordings.len().min(MOST_RECORDINGS)];
    let Some(of_drive) = rough_fit_percent(file, free, few, Signal::Position)? else { return Ok(None) };
    let missed = |percent: f64| (1.0 - 0.01 * percent).powi(2);
    let is_better = missed(follows_percent) < LEAST_EXPLAINED * missed(of_drive);
    Ok(is_better.then_some(Follower { follows_percent }))
}
