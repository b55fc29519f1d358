//! The evidence that a report shows beside the diagnosis itself, all as data: where the error was removed, the residuals, the preprocessing, and
//! which test would settle a finding. Pictures are computed only for a page.

mod effect_picture;
pub(crate) mod preprocessing;
mod state_map;
mod timeline;
pub(crate) mod waterfall;
pub(crate) mod whiteness;

use effect_picture::{Picture, pictures};
use preprocessing::{Preprocessing, preprocessing};
use state_map::state_maps;
use timeline::timeline;
use waterfall::Waterfall;
use whiteness::{Whiteness, whiteness};

use diagnosis::{Diagnosis, Finding};
use experiment::discriminate::{Separation, separations};
use machine_file::MachineFile;
use model_core::machine::{MachineError, Source};
use recording::Recording;

use crate::plot::{Cells, Rows};

/// Everything that is shown beside a diagnosis.
#[derive(Clone, Debug, PartialEq)]
pub struct Exhibits {
    /// What each stage of the diagnosis leaves of the error.
    pub waterfall: Waterfall,
    /// Whether the residual is white, for each signal.
    pub whiteness: Vec<Whiteness>,
    /// The same for the model before.
    pub whiteness_before: Vec<Whiteness>,
    /// Each accepted effect against its rivals.
    pub separations: Vec<Separation>,
    /// What the preprocessing found in each recording.
    pub preprocessing: Vec<Preprocessing>,
    /// The effects' own pictures; empty unless asked for.
    pub pictures: Vec<Picture>,
    /// When the error is made, all training recordings together; `None` unless asked for and located.
    pub timeline: Option<Rows>,
    /// The operating regions in which it is made, before and, with something accepted, after; empty unless asked for and located.
    pub maps: Vec<Cells>,
}

impl Exhibits {
    /// Computes the evidence; `with_pictures` for a page.
    pub fn of(
        file: &MachineFile,
        training: &[Recording],
        held_out: &[Recording],
        diagnosis: &Diagnosis,
        with_pictures: bool,
    ) -> Result<Self, MachineError> {
        let recordings: Vec<&Recording> = training.iter().chain(held_out).collect();
        Ok(Self {
            waterfall: Waterfall::of(&file.machine, diagnosis)?,
            whiteness: whiteness(&diagnosis.shown, &recordings, true),
            whiteness_before: whiteness(&diagnosis.shown, &recordings, false),
            separations: separations(diagnosis, file.load_source, &recordings)?,
            preprocessing: diagnosis
                .shown
                .iter()
                .zip(&recordings)
                .map(|(shown, recording)| preprocessing(recording, shown))
                .collect(),
            pictures: if with_pictures { pictures(diagnosis, &recordings)? } else { Vec::new() },
            timeline: if with_pictures { timeline(diagnosis) } else { None },
            maps: if with_pictures { state_maps(diagnosis, &recordings) } else { Vec::new() },
        })
    }

    /// The rivals of one finding, the most probable first.
    pub fn rivals<'a>(&'a self, finding: &Finding) -> impl Iterator<Item = &'a Separation> + use<'a> {
        let effect = finding.effect.name;
        self.separations.iter().filter(move |separation| separation.effect == effect)
    }

    /// The test that separates a finding from its look-alikes: from its most probable rival, or the catalogue's test where no rival
    /// was simulated.
    #[must_use]
    pub fn separated_by(&self, finding: &Finding, source: Source) -> String {
        let by_catalogue = || crate::wording::separated_by(finding.effect, source).into_owned();
        self.rivals(finding).next().map_or_else(by_catalogue, crate::wording::advice)
    }
}
