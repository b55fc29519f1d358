//! Machine files: the parameters of one drive in TOML, SI units, the unit in the key.
//!
//! Keys, ranges and defaults are those of [`Parameter`]. In addition there are `name`, `load.source`, a table in `[linkage]`,
//! `[channels]`, `[watch]`, `[fit.sigma]` and `[fit.tolerance]`. Anything else is an error, and every error names file, line, key
//! and what was expected there.
//!
//! Start at [`read`], which makes a [`MachineFile`] of a file; [`data_sheet`] makes one from data-sheet values. Nothing here simulates: a machine
//! is only checked and stored.
#![forbid(unsafe_code)]
// All output is returned to the caller: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]
// No mathematics of the platform: its last bit differs from one to the next (clippy.toml).
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod band;
mod carried;
mod channels;
pub mod data_sheet;
mod error;
mod force;
pub mod keys;
mod linkage;
mod reader;
mod writer;

use std::collections::{BTreeMap, BTreeSet};

use model_core::machine::{Machine, Parameter};
use recording::ChannelMap;

pub use band::{Band, Spread};
pub use carried::carried;
pub use error::MachineFileError;
pub use reader::{MAX_FILE_BYTES, read, read_text};

/// Where the external force on the rod comes from in a simulation of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LoadSource {
    /// `load.force_n`, constant over time.
    #[default]
    Constant,
    /// The force that balances the recorded chamber pressures: F = −(A·pa − aA·pb), with A =
    /// `cylinder.area_a_m2` and aA = `cylinder.area_b_m2`; positive extends. It holds for slow motion,
    /// where inertia and friction are small compared with the load.
    RecordedPressures,
}

impl LoadSource {
    /// Its name as in the machine file.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            LoadSource::Constant => "constant",
            LoadSource::RecordedPressures => "recorded-pressures",
        }
    }

    fn parse(name: &str) -> Option<Self> {
        [LoadSource::Constant, LoadSource::RecordedPressures].into_iter().find(|source| source.name() == name)
    }
}

/// Ticks in the delay line on the desktop: more than a quarter of a second at any tick.
pub const DELAY_LINE: usize = 512;

/// A drive as its machine file describes it.
///
/// Fields may be changed; [`MachineFile::save`] then writes the file with these changes and leaves
/// the rest of its text as it was.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineFile {
    /// The name of the drive; the file's name where the file gives none.
    pub name: String,
    /// The parameters, SI; those that the file does not give have their defaults.
    pub machine: Machine<f64>,
    /// The parameters that the file gives.
    pub given: BTreeSet<Parameter>,
    /// The effects that are switched on, by the names of their tables.
    pub effects: BTreeSet<&'static str>,
    /// Standard deviations of nominal values from `[fit.sigma]`, each in its parameter's unit.
    pub sigma: BTreeMap<Parameter, f64>,
    /// Whether there is a table `[fit.sigma]`, even an empty one: without it a documented default applies.
    pub has_sigma_table: bool,
    /// Largest magnitudes that are within the drawing, from `[fit.tolerance]`, each in its parameter's unit: a fit may use them, and they are no
    /// findings.
    pub tolerance: BTreeMap<Parameter, f64>,
    /// `[channels]`: which columns of a recording hold which signals. Its columns may be absent. Also the linkage of `[linkage]` as it was read: it
    /// does not follow a change of `machine`.
    pub channels: ChannelMap,
    /// `load.source`.
    pub load_source: LoadSource,
    /// `[watch]`: how far its sensors are from its model while the drive is healthy, where that is known.
    pub band: Option<Band>,
    /// The text that was read; empty for a drive made in the program.
    text: String,
}

impl MachineFile {
    /// A drive made in the program; saving it writes a new file.
    ///
    /// Effects whose parameters are not at their defaults are switched on.
    #[must_use]
    pub fn from_machine(name: &str, machine: Machine<f64>) -> Self {
        let changed = |&parameter: &Parameter| {
            machine.get(parameter).to_bits() != crate::keys::fallback(parameter, &machine).to_bits()
        };
        let given: BTreeSet<Parameter> = Parameter::ALL.iter().copied().filter(changed).collect();
        let effects = given
            .iter()
            .filter_map(|&parameter| crate::keys::address(parameter).table.strip_prefix(crate::keys::EFFECTS));
        Self {
            name: name.to_owned(),
            machine,
            effects: effects.collect(),
            given,
            sigma: BTreeMap::new(),
            has_sigma_table: false,
            tolerance: BTreeMap::new(),
            channels: ChannelMap::default(),
            load_source: LoadSource::default(),
            band: None,
            text: String::new(),
        }
    }

    /// Sets the level at rest from which recordings without pressures are simulated, if a fit has found one.
    pub fn start_at(&mut self, level_at_rest: Option<f64>) {
        if let Some(level) = level_at_rest {
            self.machine.set(Parameter::LevelAtRest, level);
            self.given.insert(Parameter::LevelAtRest);
        }
    }
}

#[cfg(test)]
mod tests;
