//! What is known of one drive after one night.

use std::collections::BTreeMap;

use model_core::machine::Parameter;
use recording::Signal;
use watch::Link;

/// How a night ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Judgement {
    /// The drive follows its model as it did while it was healthy.
    InBand,
    /// It left its band, and nothing has changed that its model holds: it was moved or loaded as never before.
    Unchanged,
    /// It left its band, and a diagnosis names what has changed.
    Changed,
    /// It left its band, and no diagnosis was asked for.
    Left,
    /// It left its band, and the diagnosis does not know why.
    Unexplained,
    /// The recording, or all of the night, cannot be used.
    Unusable,
}

impl Judgement {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::InBand, Self::Unchanged, Self::Changed, Self::Left, Self::Unexplained, Self::Unusable];

    /// Its name in a table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::InBand => "in-band",
            Self::Unchanged => "unchanged",
            Self::Changed => "changed",
            Self::Left => "left-band",
            Self::Unexplained => "unexplained",
            Self::Unusable => "unusable",
        }
    }

    /// The one of this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|one| one.name() == name)
    }
}

/// The signals whose misfit stands in a row, in the chain's order.
pub const MISFITS: [Signal; 4] = [Signal::Spool, Signal::PressureA, Signal::PressureB, Signal::Position];

/// How much there is of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strength {
    /// Which amount of which effect.
    pub parameter: Parameter,
    /// Its value, SI.
    pub value: f64,
    /// Its standard deviation, SI.
    pub std: f64,
}

/// One drive and one night; or one recording of it that cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The drive's name: that of its folder.
    pub drive: String,
    /// The night's name: that of its folder.
    pub night: String,
    /// The recording, where the row is of one that cannot be used.
    pub recording: Option<String>,
    /// How it ended.
    pub judgement: Judgement,
    /// The link at which the drive left its band.
    pub link: Option<Link>,
    /// The same in words.
    pub words: String,
    /// How many recordings were judged.
    pub recordings: usize,
    /// How near the limit of its band the drive came; beyond 1 it left it.
    pub of_limit: Option<f64>,
    /// What the refitted model misses of each of [`MISFITS`], in standard deviations of its noise; 1 is a perfect model.
    pub misfits: [Option<f64>; 4],
    /// How much there is of each effect, as far as the recordings tell it. What they do not tell is absent, not 0.
    pub strengths: Vec<Strength>,
    /// Version of the program.
    pub version: String,
    /// Time that it took, s. The only thing that differs from run to run.
    pub seconds: f64,
}

impl Row {
    /// The night that it belongs to.
    #[must_use]
    pub fn key(&self) -> (&str, &str) {
        (&self.drive, &self.night)
    }

    /// Where it stands in a table: by drive and night, that of the drive before those of its recordings.
    pub fn order(&self) -> impl Ord + '_ {
        (self.key(), &self.recording)
    }
}

/// How many nights ended how. A recording that cannot be used is no night.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally(BTreeMap<Judgement, usize>);

impl Tally {
    /// Counts the rows of whole nights.
    pub fn add(&mut self, rows: &[Row]) {
        for row in rows.iter().filter(|row| row.recording.is_none()) {
            *self.0.entry(row.judgement).or_default() += 1;
        }
    }

    /// Each way in which a night ended, with how many did.
    pub fn iter(&self) -> impl Iterator<Item = (Judgement, usize)> {
        self.0.iter().map(|(judgement, count)| (*judgement, *count))
    }

    /// How many nights ended so.
    #[must_use]
    pub fn of(&self, judgement: Judgement) -> usize {
        self.0.get(&judgement).copied().unwrap_or(0)
    }

    /// How many nights there are.
    #[must_use]
    pub fn nights(&self) -> usize {
        self.0.values().sum()
    }
}
