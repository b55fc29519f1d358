//! How far a search came, what its parts cost, and what its limit left out.

use identification::effort::Effort;

use super::candidate::Question;

/// A part of the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Refit of the base parameters.
    Base,
    /// Each side of a recorded spool by itself.
    Sides,
    /// Candidate models with this many effects.
    Effects(usize),
    /// Effects that act over time, on the whole of long recordings.
    Slow,
    /// Jumps of a spool that no sensor measures.
    Jumps,
    /// Causes outside the drive.
    Outside,
    /// Forces below a measured force, in what velocity and position gain.
    Gains,
    /// Correction tables.
    Tables,
}

/// What a search did and left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Searched {
    /// The parts in their order, each with what it cost, s on two cores.
    pub spent_s: Vec<(Stage, f64)>,
    /// What the limit left out, wholly or in part, in its order. Empty where the search came to its own end.
    pub left_out: Vec<Stage>,
    /// The limit, s on two cores, where there was one.
    pub limit_s: Option<f64>,
}

impl Searched {
    /// Whether it came to its own end: only then it may claim anything. Correction tables come after the verdict, which they do not change.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.left_out.iter().all(|stage| *stage == Stage::Tables)
    }

    /// What it cost in all, s on two cores.
    #[must_use]
    pub fn all_s(&self) -> f64 {
        self.spent_s.iter().map(|(_, spent_s)| spent_s).sum()
    }

    /// The part that cost most, with its cost, s on two cores.
    #[must_use]
    pub fn slowest(&self) -> Option<(Stage, f64)> {
        self.spent_s.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// A part has ended: it cost what was spent and not told before.
    pub(crate) fn did(&mut self, stage: Stage, spent_s: f64) {
        match self.spent_s.iter_mut().find(|(known, _)| *known == stage) {
            Some((_, sum)) => *sum += spent_s,
            None => self.spent_s.push((stage, spent_s)),
        }
    }

    /// The limit leaves a part out.
    pub(crate) fn leave(&mut self, stage: Stage) {
        if !self.left_out.contains(&stage) {
            self.left_out.push(stage);
        }
    }

    /// Together with a search before it.
    pub(crate) fn after(self, before: &Self) -> Self {
        let mut both = before.clone();
        self.spent_s.into_iter().for_each(|(stage, spent_s)| both.did(stage, spent_s));
        self.left_out.into_iter().for_each(|stage| both.leave(stage));
        both.limit_s = both.limit_s.or(self.limit_s);
        both
    }
}

/// Measures a part of a search.
pub(crate) struct Clock {
    effort: Effort,
    began_s: f64,
}

impl Clock {
    /// From now on.
    pub(crate) fn of(question: &Question<'_>) -> Self {
        let effort = question.effort();
        Self { began_s: effort.spent_s(), effort }
    }

    /// What was spent since, or since it was asked last, s on two cores.
    pub(crate) fn lap_s(&mut self) -> f64 {
        let now_s = self.effort.spent_s();
        let lap_s = now_s - self.began_s;
        self.began_s = now_s;
        lap_s
    }

    /// The meter.
    pub(crate) fn effort(&self) -> &Effort {
        &self.effort
    }
}
