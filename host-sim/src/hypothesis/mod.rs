//! Effects that a drive may have and the paper's model leaves out: one file an effect, one line in the [`CATALOGUE`].
//!
//! Every file has the same headings: What it adds · How it shows · What looks alike · Parameters · Source. An effect's equation
//! runs in model-core; here stands what the diagnosis needs to try it.

mod coulomb_friction;
mod hose_compliance;
mod internal_leakage;
mod pump_slip;

use std::fmt;

use model_core::machine::{Machine, Source};
use model_core::parameter::Parameter;

use crate::fit::{Free, Freedom};
use crate::machine_file::LoadSource;
use crate::recording::Signal;
use crate::simulate::EntryPoint;

/// A part of the chain, as a finding names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Subsystem {
    /// Command → slider.
    Valve,
    /// Slider and pressures → flows.
    Flow,
    /// Flows and velocity → pressures.
    Chambers,
    /// Forces → motion.
    Mechanics,
    /// Motion → measured motion.
    Sensing,
}

impl Subsystem {
    /// Whether what happens in this link moves the signal: only the valve moves the slider.
    #[must_use]
    pub fn reaches(self, signal: Signal) -> bool {
        self == Subsystem::Valve || signal != Signal::Spool
    }
}

impl fmt::Display for Subsystem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Subsystem::Valve => "valve",
            Subsystem::Flow => "flow",
            Subsystem::Chambers => "chambers",
            Subsystem::Mechanics => "mechanics",
            Subsystem::Sensing => "sensing",
        })
    }
}

/// An effect whose form takes another's in, so that data may not tell them apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LookAlike {
    /// Its name in the vocabulary.
    pub effect: &'static str,
    /// What tells them apart.
    pub told_apart_by: &'static str,
}

/// One parameter of an effect.
#[derive(Clone, Copy, Debug)]
pub struct Strength {
    /// Its name in reports, with its unit.
    pub name: &'static str,
    /// The machine's parameter.
    pub parameter: Parameter,
    /// A typical value for a drive, in the parameter's unit; fits start here.
    pub typical: fn(&Machine<f64>) -> f64,
}

/// An effect that can be switched on in the chain.
#[derive(Clone, Copy, Debug)]
pub struct Hypothesis {
    /// Its name in the vocabulary.
    pub name: &'static str,
    /// Where it acts.
    pub subsystem: Subsystem,
    /// Its equation, for people.
    pub equation: &'static str,
    /// What it has to fit.
    pub strengths: &'static [Strength],
    /// What may be taken for it.
    pub look_alikes: &'static [LookAlike],
    /// The test that shows it apart from others.
    pub separated_by: &'static str,
    /// Where the physics is described.
    pub source: &'static str,
    /// Whether a drive of this kind, entered there, with its load known like this, can show it at all.
    pub shows_in: fn(Source, EntryPoint, LoadSource) -> bool,
}

/// Every effect that is tried, in the order of the chain.
pub const CATALOGUE: &[&Hypothesis] = &[
    &pump_slip::HYPOTHESIS,
    &internal_leakage::HYPOTHESIS,
    &hose_compliance::HYPOTHESIS,
    &coulomb_friction::HYPOTHESIS,
];

impl Hypothesis {
    /// What a fit moves for this effect.
    #[must_use]
    pub fn free(&self, machine: &Machine<f64>) -> Vec<Free> {
        let free = |strength: &Strength| Free {
            parameter: strength.parameter,
            freedom: Freedom::Strength { typical: (strength.typical)(machine) },
        };
        self.strengths.iter().map(free).collect()
    }

    /// Whether the machine file already has it.
    #[must_use]
    pub fn is_on(&self, machine: &Machine<f64>) -> bool {
        self.strengths.iter().any(|strength| machine.get(strength.parameter) > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_is_in_the_machine_files_vocabulary_and_has_a_typical_strength_in_range() {
        let mut machine = Machine::with_defaults(Source::Valve);
        machine.set(Parameter::AreaA, 3e-3);
        machine.set(Parameter::AreaB, 2e-3);
        machine.set(Parameter::VolumeA, 5e-4);
        machine.set(Parameter::VolumeB, 3e-4);
        for hypothesis in CATALOGUE {
            for strength in hypothesis.strengths {
                let description = strength.parameter.description();
                assert!(description.key.starts_with(&format!("effects.{}.", hypothesis.name)), "{}", description.key);
                let typical = (strength.typical)(&machine);
                assert!(typical > 0.0 && typical < description.max, "{}: {typical}", hypothesis.name);
            }
        }
    }
}
