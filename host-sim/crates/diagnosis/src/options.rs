//! What a diagnosis is asked beyond its recordings.

use model_core::machine::Tick;

/// What a diagnosis is asked beyond its recordings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Step of the model; by the recordings' rows where none is given.
    pub tick: Option<Tick>,
    /// Whether the effects that the machine file holds may have become more or less since it was written: each that has is a finding.
    pub asks_since: bool,
    /// What the search may cost, s on two cores, by the prices of [`identification::effort`]; `None`: as much as it takes. It is counted in simulated
    /// ticks and not by a clock, so that the answer is the same on every machine.
    pub limit_s: Option<f64>,
}

impl Options {
    /// What the search may cost where nothing is said, s on two cores.
    pub const USUAL_LIMIT_S: f64 = 300.0;
}

impl Default for Options {
    fn default() -> Self {
        Self { tick: None, asks_since: false, limit_s: Some(Self::USUAL_LIMIT_S) }
    }
}
