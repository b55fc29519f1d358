//! Where the fit of a candidate model has ended: whether its effect parameters are possible and not negligible, and how far the base parameters are
//! pulled from their nominal values.

use identification::fit::Free;
use model_core::machine::Parameter;

use super::{Candidate, Chosen, Question, effect_parameters};
use crate::agreement::{FAR_FROM, USED_UP};
use crate::catalogue::{EffectParameter, Form, Hypothesis, Kind, Scene, covered_by, tolerance};
use crate::selection::decision_rule::{
    AMOUNT_NEGLIGIBLE, FIRM_FROM, HARDLY_JUMPS_FROM, MAKES_UP_WITHIN, PLACE_WITHIN, PRESSED, PRESSED_SIGNED,
    PULLED_TOO_FAR_QUANTILE, SHAPES_A_PLAY_BELOW, SIGNED_NEGLIGIBLE, TRADES_FROM,
};

impl Candidate {
    /// Coordinate of an effect parameter: the fitted one, or else that of its value.
    fn coordinate(&self, scene: &Scene<'_>, effect_parameter: &EffectParameter) -> f64 {
        let mut known = self.fit.free.iter().zip(&self.fit.coordinates);
        let fitted = known.find(|(free, _)| free.parameter == effect_parameter.parameter).map(|(_, at)| *at);
        fitted.unwrap_or_else(|| {
            effect_parameter.free(scene).coordinate(self.fit.machine.get(effect_parameter.parameter))
        })
    }

    /// Amounts that have become negligible in effects that as a whole have not, with the middle of their ranges.
    pub(crate) fn vanished(&self, scene: &Scene<'_>) -> Vec<(Parameter, f64)> {
        let is_amount =
            |effect_parameter: &&EffectParameter| matches!(effect_parameter.kind, Kind::Amount(_) | Kind::Firm(_));
        let gone = |effect_parameter: &&EffectParameter| self.coordinate(scene, effect_parameter) < AMOUNT_NEGLIGIBLE;
        let partly = |form: Form| !form.iter().filter(is_amount).all(|effect_parameter| gone(&effect_parameter));
        self.effects
            .iter()
            .filter(|chosen| partly(chosen.form))
            .flat_map(|chosen| chosen.form.iter().filter(is_amount).filter(gone))
            .map(|effect_parameter| (effect_parameter.parameter, effect_parameter.free(scene).value(0.0)))
            .collect()
    }

    /// Effect parameters at an end of their admissible range, and amounts above their possible range, with the middle of their ranges.
    pub(crate) fn stranded(&self, scene: &Scene<'_>) -> Vec<(Parameter, f64)> {
        let at_bound = |effect_parameter: &EffectParameter| {
            let mut known = self.fit.free.iter().zip(&self.fit.coordinates);
            known.any(|(free, at)| free.parameter == effect_parameter.parameter && free.at_bound(*at))
        };
        // An amount that has vanished is at a bound too, so amounts count only above their possible range.
        let is_stranded = |effect_parameter: &EffectParameter| match effect_parameter.kind {
            Kind::Signed(_) => at_bound(effect_parameter),
            Kind::Amount(_) | Kind::Firm(_) => self.coordinate(scene, effect_parameter) > PRESSED,
            _ => false,
        };
        effect_parameters(&self.effects)
            .into_iter()
            .filter(is_stranded)
            .map(|effect_parameter| (effect_parameter.parameter, effect_parameter.free(scene).value(0.0)))
            .collect()
    }

    /// Whether the fit succeeded and every effect lies where such an effect can: no amount pressed against the end of its usual
    /// range widened threefold, and of each effect at least one amount that is not negligible.
    #[must_use]
    pub(crate) fn is_possible(&self, scene: &Scene<'_>) -> bool {
        self.fit.loss.is_finite()
            && self.effects.iter().all(|chosen| {
                let at = |effect_parameter: &EffectParameter| {
                    (effect_parameter.kind, self.coordinate(scene, effect_parameter))
                };
                let possible = chosen.form.iter().map(at).all(|(kind, coordinate)| match kind {
                    Kind::Amount(_) | Kind::Firm(_) | Kind::Jump(_) => coordinate < PRESSED,
                    // Any value of a shape is possible; where it ends at a bound, the recordings do not determine it.
                    Kind::Shape(..) | Kind::Floor(..) | Kind::Setting(..) => true,
                    Kind::Signed(_) => coordinate.abs() < PRESSED_SIGNED,
                    Kind::Place(..) => coordinate.abs() < PLACE_WITHIN,
                });
                // Of an effect that was there before, what it has changed by.
                let change = |effect_parameter: &EffectParameter| {
                    let before = scene.before(effect_parameter);
                    let changed = self.fit.machine.get(effect_parameter.parameter) - before;
                    let coordinate = match effect_parameter.kind {
                        _ if before == 0.0 => self.coordinate(scene, effect_parameter),
                        Kind::Signed(_) => effect_parameter.free(scene).coordinate(changed),
                        _ => effect_parameter.free(scene).coordinate(changed.abs()),
                    };
                    (effect_parameter.kind, coordinate)
                };
                let notable = chosen.form.iter().map(change).any(|(kind, coordinate)| match kind {
                    Kind::Amount(_) | Kind::Firm(_) | Kind::Jump(_) => coordinate > AMOUNT_NEGLIGIBLE,
                    Kind::Signed(_) => coordinate.abs() > SIGNED_NEGLIGIBLE,
                    // A floor acts wherever it lies.
                    Kind::Floor(..) | Kind::Setting(..) => true,
                    Kind::Shape(..) | Kind::Place(..) => false,
                });
                possible && notable
            })
    }

    /// Whether it may be accepted: it is possible, and amounts that are never small on a real drive are large enough. A stop as soft as a spring is
    /// no stop, a stiction that only shapes a play is no stiction, a drift of an installed drive that is over sooner than any drift is another
    /// transient, and what stays within its tolerance is no finding. They are ranked all the same, since nothing less likely may be accepted in their
    /// place.
    #[must_use]
    pub fn is_plausible(&self, question: &Question<'_>) -> bool {
        let scene = question.scene;
        let firm = |effect_parameter: &EffectParameter| match effect_parameter.kind {
            Kind::Firm(_) => self.coordinate(scene, effect_parameter) > FIRM_FROM,
            _ => true,
        };
        let quick = |own: &EffectParameter| question.has_tolerances() && self.is_quick(scene, own);
        self.is_possible(scene)
            && !self.shapes_a_play()
            && self.effects.iter().all(|chosen| self.is_beyond_tolerance(question, chosen))
            && self.effects.iter().flat_map(|chosen| chosen.form).all(|own| firm(own) && !quick(own))
    }

    /// Whether a time of a slow effect is shorter than any such effect takes.
    fn is_quick(&self, scene: &Scene<'_>, time: &EffectParameter) -> bool {
        time.slow_from(scene).is_some_and(|least| self.fit.machine.get(time.parameter) <= least)
    }

    /// Whether an amount of an effect is larger than its tolerance, or has none; of one that was there before, whether it has changed by more than
    /// what was known of it.
    fn is_beyond_tolerance(&self, question: &Question<'_>, chosen: &Chosen) -> bool {
        let is_beyond = |own: &EffectParameter| {
            let value = self.fit.machine.get(own.parameter);
            let is_changed = question.scene.is_changed(own, value);
            is_changed.unwrap_or_else(|| value.abs() > tolerance(question.base_parameters, own.parameter))
        };
        let mut amounts = chosen.form.iter().filter(|effect_parameter| effect_parameter.is_amount()).peekable();
        amounts.peek().is_none() || amounts.any(is_beyond)
    }

    /// Whether of an effect that may have changed there is less by one amount and more by another: then it acts otherwise than then, as the same drive does
    /// that is driven otherwise, and no more or less of it is told.
    pub(crate) fn trades(&self, question: &Question<'_>, form: Form) -> bool {
        let scene = question.scene;
        let amounts = form.iter().filter(|own| matches!(own.kind, Kind::Amount(_) | Kind::Firm(_)));
        let gained: Vec<f64> = amounts
            .map(|own| (self.fit.machine.get(own.parameter) - scene.machine.get(own.parameter)) / own.unit(scene))
            .collect();
        let more: f64 = gained.iter().filter(|gained| **gained > 0.0).sum();
        let less: f64 = gained.iter().filter(|gained| **gained < 0.0).map(|gained| -gained).sum();
        scene.holds(form) && more.min(less) > TRADES_FROM * more.max(less)
    }

    /// Whether it has used up the tolerance of an amount of a plain effect, or what is left of it, or within how much an amount that may have changed is
    /// known: only recordings that press for more, or for less, come so far.
    pub(crate) fn presses(&self, question: &Question<'_>, effect: &Hypothesis, form: Form) -> bool {
        let used_up = |own: &EffectParameter| {
            let cover = covered_by(own.parameter);
            let free = question.base_parameters.iter().find(|free| free.parameter == cover);
            let used = free.and_then(|free| free.share_used(self.fit.machine.get(cover)));
            own.is_amount() && used.is_some_and(|share| share > USED_UP)
        };
        effect.extends.is_none() && (self.uses_up(question, form) || form.iter().any(used_up))
    }

    /// Whether an amount of this form is far from what was known of it since then.
    pub(crate) fn uses_up(&self, question: &Question<'_>, form: Form) -> bool {
        let is_far = |own: &EffectParameter| {
            let free = question.base_parameters.iter().find(|free| free.parameter == own.parameter);
            let is_far = |free: &Free| free.deviations(self.fit.machine.get(own.parameter)).abs() > FAR_FROM;
            question.scene.before(own) != 0.0 && free.is_some_and(is_far)
        };
        form.iter().any(is_far)
    }

    /// Whether it follows the recordings as far as it does by what a candidate model lets change: it is not far off, and of each effect that the
    /// candidate model has beyond its own an amount is used up.
    pub(crate) fn makes_up_for_change(&self, question: &Question<'_>, with: &Self) -> bool {
        let mut changed = with.effects.iter().filter(|chosen| !self.has(chosen.effect)).peekable();
        changed.peek().is_some()
            && self.worst_over_noise(question) < MAKES_UP_WITHIN
            && changed.all(|chosen| self.uses_up(question, chosen.form))
    }

    /// Whether its stiction only shapes the play beside it. A stiction that keeps most of its band hardly jumps and acts like a play of twice the
    /// band: where that is small compared with the play beside it, it only corrects the loop of that play, whose own form is not exact either.
    fn shapes_a_play(&self) -> bool {
        let value = |parameter| self.fit.machine.get(parameter);
        self.hardly_jumps() && value(Parameter::StictionBand) < SHAPES_A_PLAY_BELOW * value(Parameter::HysteresisWidth)
    }

    /// Whether it has a stiction that hardly jumps. Some real ones are so; but fits in free run end there whatever the spool does, since a jump that
    /// is a row late costs more than no jump: effect parameters found there say little about the spool.
    #[must_use]
    pub fn hardly_jumps(&self) -> bool {
        let is_of = |chosen: &Chosen| chosen.has(Parameter::StictionBand);
        self.effects.iter().any(is_of) && self.fit.machine.get(Parameter::StictionKept) > HARDLY_JUMPS_FROM
    }

    /// What the base parameters cost by being away from their nominal values: half the sum of squares of their distances, each
    /// in its standard deviation.
    #[must_use]
    pub fn pulled(&self, question: &Question<'_>) -> f64 {
        let is_base = |free: &Free| question.base_parameters.contains(free);
        let fitted = self.fit.free.iter().zip(&self.fit.coordinates);
        let own = fitted.filter(|(free, _)| is_base(free)).map(|(_, coordinate)| coordinate);
        0.5 * own.map(|coordinate| coordinate * coordinate).sum::<f64>()
    }

    /// Whether the base parameters are further away than their standard deviations allow in 999 of 1000 drives: by the quantile of χ² after Wilson
    /// and Hilferty 1931.
    #[must_use]
    pub fn is_pulled(&self, question: &Question<'_>) -> bool {
        let count = question.base_parameters.len() as f64;
        let share = 2.0 / (9.0 * count);
        count > 0.0
            && 2.0 * self.pulled(question) > count * (1.0 - share + PULLED_TOO_FAR_QUANTILE * share.sqrt()).powi(3)
    }
}
