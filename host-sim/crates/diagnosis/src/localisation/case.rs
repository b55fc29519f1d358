//! A recording as localisation sees it.

use identification::experiment::Prepared;
use identification::fit::StartState;
use recording::Recording;

/// A training recording with what was prepared from it.
#[derive(Clone, Copy, Debug)]
pub struct Case<'a> {
    /// As read.
    pub recording: &'a Recording,
    /// As the fit sees it.
    pub prepared: &'a Prepared,
    /// The state it starts from.
    pub start: StartState,
}
