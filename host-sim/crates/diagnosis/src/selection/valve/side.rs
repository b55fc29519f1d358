//! The two sides of a recorded spool, and what belongs to each.

use identification::experiment::Prepared;
use identification::fit::{Free, moves_spool};
use model_core::machine::Parameter;
use recording::Signal;

use crate::catalogue::{Hypothesis, Subsystem};
use crate::selection::candidate::Question;
use crate::selection::decision_rule::{BELOW_SPOOL_SEARCHED_TO, VALVE_SEARCHED_TO};

/// A side of the spool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// The valve, which moves the spool.
    Valve,
    /// Everything that the spool meters the oil for.
    Below,
}

impl Side {
    pub(super) fn of_signal(signal: Signal) -> Self {
        if signal == Signal::Spool { Self::Valve } else { Self::Below }
    }

    fn of_parameter(parameter: Parameter) -> Self {
        if moves_spool(parameter) { Self::Valve } else { Self::Below }
    }

    pub(super) fn of_effect(effect: &Hypothesis) -> Self {
        if effect.subsystem == Subsystem::Valve { Self::Valve } else { Self::Below }
    }

    /// The search of a side ends when its worst signal is within this many times its noise. The spool's motion between two rows is not known: this
    /// adds to the misfit of every signal below the spool.
    pub(super) fn near(self) -> f64 {
        match self {
            Self::Valve => VALVE_SEARCHED_TO,
            Self::Below => BELOW_SPOOL_SEARCHED_TO,
        }
    }

    /// The base parameters of this side.
    pub(super) fn base_parameters(self, question: &Question<'_>) -> Vec<Free> {
        question.base_parameters.iter().copied().filter(|free| Self::of_parameter(free.parameter) == self).collect()
    }

    /// Recordings, judged by the signals of this side alone.
    pub(super) fn judging(self, cases: &[Prepared]) -> Vec<Prepared> {
        cases.iter().map(|case| case.judged_by(|signal| Self::of_signal(signal) == self)).collect()
    }
}
