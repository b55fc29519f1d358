//! A refit with a dry friction that falls with speed, led by runs that are held near the recordings.
//!
//! Such a friction feeds the swing of the mass on its oil: the rod breaks away, sticks and slips. How often it swings hangs on the velocity at which the friction
//! falls, and a free run is in step with the recording only within a few tens of per cent of that velocity: a search that begins elsewhere ends where the rod
//! swings once more or less. By runs that are [held](Prepared::held) near the recordings that velocity is found from afar. They are then held more and more
//! seldom, and free at last.

use identification::experiment::Prepared;
use identification::fit::{Fit, FitError};
use model_core::machine::Parameter;

use super::candidate::{Beginning, Candidate, Chosen, Goes, Question, SETTLED};
use super::decision_rule::FAR_OFF;
use super::forward::Course;
use super::round::{candidates, finished};
use crate::catalogue::{Hypothesis, is_elastic};

/// Share of the sliding friction that the search begins with in excess at rest: in the middle of the usual 0.1 to 1.6 times.
const EXCESS: f64 = 0.5;

/// How many times more seldom than the rows allow runs are held, one refit after the other.
const HELD: [u32; 3] = [1, 3, 10];

impl Candidate {
    /// This candidate model with a friction that falls with speed in the place of the dry friction that was added last, refitted to the end from where held runs
    /// lead. `None` where it follows the recordings, its newest effect is no dry friction, nobody asks for the other, or the recordings do not show pressures and motion.
    pub(super) fn sticking(&self, question: &Question<'_>) -> Result<Option<Self>, FitError> {
        let falling = self.with_falling_friction(question).filter(|_| self.worst_over_noise(question) > FAR_OFF);
        let Some(Falling { effects, mut values }) = falling else { return Ok(None) };
        let refitted = |question: &Question<'_>, fit: &Fit, values: &[(Parameter, f64)], precision: f64| {
            let from = Beginning { fit, values, settled: &[], goes: Goes::ToTheEnd(precision) };
            Self::refitted(question, effects.clone(), self.jumps.clone(), &from)
        };
        let mut led = self.clone();
        for times in HELD {
            let held: Option<Vec<Prepared>> = question.training.iter().map(|case| case.held(times)).collect();
            let Some(held) = held else { return Ok(None) };
            let held: Vec<&Prepared> = held.iter().collect();
            led = refitted(&Question { training: &held, ..*question }, &led.fit, &values, SETTLED)?;
            values.clear();
        }
        refitted(question, &led.fit, &[], self.precision(question)).map(Some)
    }

    /// Its effects with a friction that falls with speed as the last one, and where a search with them begins: at its own values, or where the last one was a
    /// plainer friction, which may have led the base parameters astray, at the nominal ones.
    fn with_falling_friction(&self, question: &Question<'_>) -> Option<Falling> {
        let velocity = |one: &&'static Hypothesis| {
            one.effect_parameters().find(|own| own.parameter == Parameter::StribeckVelocity)
        };
        let effect = *question.hypotheses.iter().find(|one| velocity(one).is_some())?;
        let (newest, others) = self.effects.split_last()?;
        if newest.effect.name == effect.name {
            return Some(Falling { effects: self.effects.clone(), values: Vec::new() });
        }
        let plainer = effect.extends.filter(|plainer| plainer.plain == newest.effect.name)?;
        let form = effect.forms_in(question.scene).find(|form| is_elastic(form) == is_elastic(newest.form))?;
        let sliding_n = self.fit.machine.get(plainer.given);
        let (low, high) = velocity(&effect)?.range(question.scene);
        let own = [
            (Parameter::StribeckForce, sliding_n),
            (Parameter::StribeckExcess, EXCESS * sliding_n),
            (Parameter::StribeckVelocity, (low * high).sqrt()),
        ];
        let mut values = if self.is_pulled(question) { question.nominal() } else { Vec::new() };
        values.retain(|(parameter, _)| own.iter().all(|(known, _)| known != parameter));
        values.extend(own);
        Some(Falling { effects: others.iter().copied().chain([Chosen { effect, form }]).collect(), values })
    }
}

/// Effects of which the last is a friction that falls with speed, and values at which a search with them begins.
struct Falling {
    effects: Vec<Chosen>,
    values: Vec<(Parameter, f64)>,
}

impl Course {
    /// A ranked round; where its likeliest candidate model adds a dry friction of any kind, with one more in which friction falls with speed.
    pub(super) fn sticking(
        &self,
        question: &Question<'_>,
        ranked: Vec<(Candidate, f64)>,
    ) -> Result<Vec<(Candidate, f64)>, FitError> {
        let newest = |candidate: &Candidate| candidate.effects.last().map(|newest| newest.effect.plainest());
        let Some((best, _)) = ranked.first().filter(|(best, _)| best.worst_over_noise(question) > FAR_OFF) else {
            return Ok(ranked);
        };
        let is_alike = |candidate: &&Candidate| {
            newest(candidate) == newest(best) && candidate.with_falling_friction(question).is_some()
        };
        let friction = ranked.iter().map(|(candidate, _)| candidate).find(is_alike);
        let Some(found) = friction.map(|one| one.sticking(question)).transpose()?.flatten() else {
            return Ok(ranked);
        };
        finished(question, &self.base, candidates(ranked).into_iter().chain([found]).collect())
    }
}

#[cfg(test)]
mod tests {
    use machine_file::LoadSource;
    use recording::Signal;
    use test_press::{press, recorded_for};

    use super::*;
    use crate::catalogue::CATALOGUE;
    use crate::selection::search::tests::added;
    use crate::test_scene::scene;

    /// Presses with little damping that swing by their friction. They were chosen because a free refit misses them.
    #[test]
    fn held_runs_lead_to_a_friction_that_a_free_refit_from_the_same_start_misses() {
        const SENSORS: [(Signal, f64); 3] =
            [(Signal::PressureA, 1e4), (Signal::PressureB, 1e4), (Signal::Position, 1e-5)];
        let mut missed = 0;
        let drawn = [(50.0, 2000.0, 0.02), (50.0, 1000.0, 0.004), (300.0, 1000.0, 0.02), (300.0, 2000.0, 0.02)];
        for (mass_kg, friction_n, velocity) in drawn {
            let nominal = press(&[
                (Parameter::ViscousFriction, 2e3),
                (Parameter::MovingMass, mass_kg),
                (Parameter::PreslidingStiffness, 5e7),
            ]);
            let falls = [
                (Parameter::StribeckForce, friction_n),
                (Parameter::StribeckExcess, friction_n),
                (Parameter::StribeckVelocity, velocity),
            ];
            let recording = recorded_for(&nominal.with(&falls), &SENSORS, 3000);
            let case = Prepared::new(&recording, &nominal, LoadSource::Constant, None).unwrap();
            let judged = SENSORS.map(|(signal, _)| signal);
            let (training, scene) = ([&case], scene(&nominal, &judged));
            let question = Question { scene: &scene, base_parameters: &[], hypotheses: CATALOGUE, training: &training };
            let base = Candidate::rough(&question, None).unwrap();
            let plain = added(&question, &base, "coulomb-friction", None);
            let Falling { effects, values } = plain.with_falling_friction(&question).unwrap();
            let from = Beginning { fit: &plain.fit, values: &values, settled: &[], goes: Goes::ToTheEnd(1e-5) };
            let free = Candidate::refitted(&question, effects, Vec::new(), &from).unwrap();
            missed += usize::from(free.worst_over_noise(&question) > 1.5);
            let led = plain.sticking(&question).unwrap().unwrap();
            assert!(led.worst_over_noise(&question) < 1.1, "{mass_kg} kg, {friction_n} N at {velocity} m/s");
            for (parameter, value) in falls {
                let found = led.fit.machine.get(parameter);
                assert!((found / value - 1.0).abs() < 0.01, "{parameter:?} {found} for {value}");
            }
            assert!(led.sticking(&question).unwrap().is_none(), "what follows the recordings is not searched again");
        }
        assert_eq!(missed, 4);
    }
}
