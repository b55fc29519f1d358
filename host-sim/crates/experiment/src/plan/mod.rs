//! What a recording will be able to show, before it is made: effects that would be seen, and effects that would be confused with each other.
//!
//! Every effect is switched on in the model at its usual size, and the differences are measured in the sensors' noise. What a refit
//! of the base parameters and of the initial state would imitate is subtracted first. An effect is seen if the remaining difference
//! would be accepted: half its sum of squares exceeds the penalty for its effect parameters and what chance gives. It is confused
//! with another effect if that effect, with its best form and effect parameters, leaves too little to prefer the first. Effect
//! parameters are treated as linear around their usual values, and the noise as white: a real recording shows less, never more.

mod directions;
mod excitation;
mod isolability;
mod products;

use directions::Directions;
use excitation::{Leg, best, joined};
use identification::parallel;
use isolability::needed;
use nalgebra::{DMatrix, DVector};
use products::{Changes, Products, View};

use diagnosis::catalogue::{CATALOGUE, Hypothesis, Scene};
use diagnosis::selection::screen::with;
use identification::fit::Free;
use machine_file::LoadSource;
use model_core::machine::{Machine, MachineError, Parameter, Source, Tick};
use recording::Signal;
use simulation::{InputPoint, StartOffset, Stimulus};

use crate::sensor::Sensor;
use crate::standard_tests::{StandardTest, standard_tests};

pub use isolability::Isolability;

/// The input of a plan.
#[derive(Clone, Debug)]
pub struct Planned<'a> {
    /// The drive as it is known.
    pub machine: &'a Machine<f64>,
    /// Base parameters that a refit may move.
    pub base_parameters: &'a [Free],
    /// Sensors at hand.
    pub sensors: &'a [Sensor],
    /// Largest command, V.
    pub largest_v: f64,
    /// Whether the rig can load the rod from outside.
    pub can_load: bool,
    /// Longest excitation, s.
    pub longest_s: f64,
}

/// Why a plan is not possible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// The drive has no valve that could be commanded.
    #[error(
        "a drive that a {} moves; expected one with a valve: the standard tests are commands to it", .source_of_drive.name()
    )]
    NeedsValve {
        /// What moves it.
        source_of_drive: Source,
    },
    /// No sensor is given.
    #[error("no sensor; expected at least one, such as position:0.05mm")]
    NoSensor,
    /// No test is short enough.
    #[error("no standard test is shorter than {longest_s} s; expected a longer time")]
    TooShort {
        /// The longest time that was asked for, s.
        longest_s: f64,
    },
    /// The machine does not become a drive.
    #[error(transparent)]
    Machine(#[from] MachineError),
}

/// One effect in one excitation.
#[derive(Clone, Debug)]
pub struct Prospect {
    /// The effect.
    pub effect: &'static Hypothesis,
    /// Its effect parameters at their usual values, SI, including the shapes.
    pub usual: Vec<(Parameter, f64)>,
    /// The smallest amount that would be accepted, as a share of the usual one; infinite where not even the largest usual amount is.
    pub smallest: f64,
}

impl Prospect {
    /// The first of its amounts, with its usual value.
    #[must_use]
    pub fn amount(&self) -> Option<(Parameter, f64)> {
        self.usual.iter().copied().find(|(parameter, _)| is_amount(self.effect, *parameter))
    }

    /// The smallest value of that amount that would be accepted.
    #[must_use]
    pub fn smallest_value(&self) -> Option<f64> {
        self.amount().map(|(_, value)| self.smallest * value).filter(|value| value.is_finite())
    }
}

/// Whether this parameter says how much of the effect there is; if no derivative leads to its effect parameters, the first one does.
fn is_amount(effect: &Hypothesis, parameter: Parameter) -> bool {
    effect.every_form().any(|form| {
        let place = form
            .iter()
            .position(|effect_parameter| effect_parameter.parameter == parameter && effect_parameter.is_amount());
        place.is_some_and(|place| place == 0 || !form[place].is_jump())
    })
}

/// What one excitation can show.
#[derive(Clone, Debug)]
pub struct Outlook {
    /// Its length, s.
    pub duration_s: f64,
    /// Every effect that can show at all.
    pub effects: Vec<Prospect>,
    /// The same effects compared with each other.
    pub isolability: Isolability,
}

/// A sensor that is not present, and what it would add.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Addition {
    /// The sensor, with usual noise.
    pub sensor: Sensor,
    /// Effects that would be accepted with it.
    pub accepted: usize,
    /// Pairs of these that would still be confused.
    pub confused: usize,
}

/// A plan.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What the given excitation can show; `None` where none was given.
    pub given: Option<Outlook>,
    /// The excitation that separates most.
    pub excitation: StandardTest,
    /// Standard tests that it is made of.
    pub tests: Vec<&'static str>,
    /// What this excitation can show.
    pub best: Outlook,
    /// What each further sensor would add to this, the best first.
    pub additions: Vec<Addition>,
    /// Effects that cannot show in any of this.
    pub not_testable: Vec<&'static Hypothesis>,
}

/// Plans a recording; `given` is an excitation that is judged in addition to the best one. `done` is called after each of [`steps`].
pub fn plan(planned: &Planned<'_>, given: Option<&Stimulus>, done: &(dyn Fn() + Sync)) -> Result<Plan, PlanError> {
    let machine = planned.machine;
    if machine.source != Source::Valve {
        return Err(PlanError::NeedsValve { source_of_drive: machine.source });
    }
    if planned.sensors.is_empty() {
        return Err(PlanError::NoSensor);
    }
    let judged: Vec<Signal> = planned.sensors.iter().map(|sensor| sensor.signal).collect();
    let scene = Scene {
        machine,
        input_point: InputPoint::Command,
        load: LoadSource::Constant,
        judged: &judged,
        travel_m: (0.2 * machine.get(Parameter::Stroke), 0.8 * machine.get(Parameter::Stroke)),
        duration_s: planned.longest_s,
        is_sparse: false,
        // No recording of this drive exists yet: effects that need a pressure near zero are not planned for.
        lowest_pa: f64::INFINITY,
        held: &[],
        asks_since: false,
        changeable: &[],
    };
    let (effects, not_testable): (Vec<&Hypothesis>, Vec<&Hypothesis>) = CATALOGUE
        .iter()
        .copied()
        .filter(|hypothesis| !hypothesis.is_on(machine, planned.base_parameters) && hypothesis.is_reached(&scene))
        .partition(|hypothesis| hypothesis.is_testable(&scene));
    let directions = Directions::of(&scene, planned.base_parameters, &effects, planned.sensors);
    let (sensors, at_hand) = with_further(planned);
    let legs = parallel::try_each(&tests(planned), |test| {
        let leg = Leg::of(test, machine, planned.largest_v, &directions, &sensors, TICK);
        done();
        leg
    })?;
    let legs: Vec<Leg> = legs.into_iter().flatten().collect();
    let chosen = best(&legs, &directions, &at_hand, planned.longest_s);
    done();
    let chosen: Vec<&StandardTest> = chosen.iter().map(|&leg| &legs[leg].test).collect();
    let excitation = joined(&chosen).ok_or(PlanError::TooShort { longest_s: planned.longest_s })?;
    let stimulus = excitation.stimulus(machine, TICK).ok_or(PlanError::TooShort { longest_s: planned.longest_s })?;
    let judge = Judge { scene: &scene, directions: &directions, sensors: &sensors };
    let (best, products) = judge.outlook(&stimulus, &at_hand)?;
    done();
    let additions = judge.additions(&products, &at_hand);
    let given = given.map(|stimulus| judge.outlook(stimulus, &at_hand)).transpose()?.map(|(outlook, _)| outlook);
    done();
    let tests = chosen.iter().map(|test| test.name).collect();
    Ok(Plan { given, excitation, tests, best, additions, not_testable })
}

/// Number of times that [`plan`] reports its progress.
#[must_use]
pub fn steps(planned: &Planned<'_>) -> usize {
    3 + tests(planned).len()
}

/// Excitations are laid out on this tick.
const TICK: Tick = Tick::OneMillisecond;

fn tests(planned: &Planned<'_>) -> Vec<StandardTest> {
    let mut tests = standard_tests(planned.machine, planned.largest_v);
    tests.retain(|test| planned.can_load || test.load_n.is_empty());
    tests
}

/// The sensors at hand and those that could be bought, and the indices of the former.
fn with_further(planned: &Planned<'_>) -> (Vec<Sensor>, Vec<usize>) {
    let at_hand = (0..planned.sensors.len()).collect();
    let further = [Signal::Spool, Signal::PressureA, Signal::PressureB, Signal::Position]
        .into_iter()
        .filter(|signal| planned.sensors.iter().all(|sensor| sensor.signal != *signal))
        .map(|signal| Sensor::usual(signal, planned.machine));
    (planned.sensors.iter().copied().chain(further).collect(), at_hand)
}

/// Judges an excitation.
struct Judge<'a> {
    scene: &'a Scene<'a>,
    directions: &'a Directions,
    /// The sensors at hand come first.
    sensors: &'a [Sensor],
}

impl Judge<'_> {
    fn outlook(&self, stimulus: &Stimulus, at_hand: &[usize]) -> Result<(Outlook, Products), PlanError> {
        let view = View { stimulus, sensors: self.sensors };
        let changes = view.changes(self.scene.machine, &self.directions.all)?;
        let products = Products::of(&changes, stimulus.rows());
        let (over, samples) = products.over(at_hand);
        let isolability = Isolability::of(self.directions, &over, samples);
        let near = View { stimulus, sensors: &self.sensors[..at_hand.len()] };
        let scale = Scale::of(&near, &changes, self.directions.base_parameters);
        let effects = parallel::each(self.directions.effects.iter().enumerate(), |(index, &effect)| Prospect {
            effect,
            usual: self.directions.effect_parameters[index].clone(),
            smallest: self.smallest(index, isolability.seen[index], &scale, samples),
        });
        let duration_s = stimulus.ticks() as f64 * stimulus.tick.seconds();
        Ok((Outlook { duration_s, effects, isolability }, products))
    }

    /// The share of an effect's usual amounts from which it is accepted.
    fn smallest(&self, effect: usize, seen: f64, scale: &Scale<'_>, samples: f64) -> f64 {
        /// Number of times that the share is corrected by its simulated effect.
        const ROUNDS: usize = 4;
        let needed = (2.0 * needed(self.directions.fewest(effect), samples)).sqrt();
        let values = &self.directions.effect_parameters[effect];
        let mut share = needed / seen.max(1e-9);
        for _ in 0..ROUNDS {
            let shared = values.iter().map(|&(parameter, value)| {
                (parameter, if is_amount(self.directions.effects[effect], parameter) { share * value } else { value })
            });
            let machine = with(self.scene.machine, &shared.collect::<Vec<_>>());
            let Some(far) = scale.far(&machine).filter(|far| *far > 0.0) else { return f64::INFINITY };
            if (far / needed - 1.0).abs() < 0.02 {
                break;
            }
            share *= (needed / far).clamp(0.1, 10.0);
        }
        // Above a thousand times the usual amount, no statement is possible.
        if share < 1e3 { share } else { f64::INFINITY }
    }

    /// What each further sensor adds.
    fn additions(&self, products: &Products, at_hand: &[usize]) -> Vec<Addition> {
        let mut found: Vec<Addition> = (at_hand.len()..self.sensors.len())
            .map(|further| {
                let wider: Vec<usize> = at_hand.iter().copied().chain([further]).collect();
                let (over, samples) = products.over(&wider);
                let isolability = Isolability::of(self.directions, &over, samples);
                let (accepted, confused) = (isolability.accepted().count(), isolability.confused().count());
                Addition { sensor: self.sensors[further], accepted, confused }
            })
            .collect();
        let told = |addition: &Addition| addition.accepted * (self.directions.effects.len() - 1) - addition.confused;
        found.sort_by_key(|addition| std::cmp::Reverse(told(addition)));
        found
    }
}

/// Distance of a machine from the original one, after a refit of the base parameters.
struct Scale<'a> {
    view: &'a View<'a>,
    base: &'a [DVector<f64>],
    /// Changes by the base parameters and the initial state, one matrix per sensor.
    base_parameters: Vec<DMatrix<f64>>,
    inverse: DMatrix<f64>,
}

impl<'a> Scale<'a> {
    /// From the changes of the first `count` directions in the view's sensors, which are the first of those in `changes`.
    fn of(view: &'a View<'a>, changes: &'a Changes, count: usize) -> Self {
        let base = &changes.base[..view.sensors.len()];
        let base_parameters: Vec<DMatrix<f64>> =
            (0..base.len()).map(|sensor| changes.columns(0..count, sensor)).collect();
        let mut own = DMatrix::identity(count, count);
        for columns in &base_parameters {
            own += columns.tr_mul(columns);
        }
        let inverse = own.try_inverse().unwrap_or_else(|| DMatrix::zeros(count, count));
        Self { view, base, base_parameters, inverse }
    }

    /// The distance in standard deviations of the noise; `None` where the machine does not become a drive.
    fn far(&self, machine: &Machine<f64>) -> Option<f64> {
        let there = self.view.of(machine, StartOffset::none()).ok()?;
        let mut square = 0.0;
        let mut across = DVector::zeros(self.inverse.nrows());
        for ((there, base), columns) in there.iter().zip(self.base).zip(&self.base_parameters) {
            let change = there - base;
            square += change.norm_squared();
            across += columns.tr_mul(&change);
        }
        Some((square - across.dot(&(&self.inverse * &across))).max(0.0).sqrt())
    }
}
