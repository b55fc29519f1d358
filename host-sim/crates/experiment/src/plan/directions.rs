//! Changes by a parameter or an effect: machines that are compared with the original one.

use diagnosis::catalogue::{EffectParameter, Form, Hypothesis, Kind, Scene};
use diagnosis::selection::screen::{Values, amounts, combined, shapes, with};
use identification::fit::Free;
use model_core::machine::{Machine, Parameter};
use recording::Signal;
use simulation::StartOffset;

use crate::sensor::Sensor;

/// Base parameters are moved by this share of their standard deviation: far enough to be seen, near enough to be linear.
const SHARE: f64 = 0.1;
/// Standard deviation of the logit of the level at rest, where no pressure is recorded.
const LEVEL: f64 = 0.4;
/// Rows at rest from which the initial position is determined.
const ROWS_AT_REST: f64 = 20.0;
/// Number of values tried for effect parameters that no derivative leads to.
const TRIED: usize = 8;

/// A machine that differs from the original one, and the factor of its difference.
#[derive(Clone, Debug)]
pub(crate) struct Direction {
    pub(crate) machine: Machine<f64>,
    pub(crate) offset: StartOffset,
    pub(crate) times: f64,
}

impl Direction {
    /// The machine with these values, with factor 1.
    fn once(machine: &Machine<f64>, values: &[(Parameter, f64)]) -> Self {
        Self { machine: with(machine, values), offset: StartOffset::none(), times: 1.0 }
    }
}

/// One way in which an effect may act: its shapes are given, its amounts are free.
#[derive(Clone, Debug)]
pub(crate) struct Way {
    /// Index of the effect.
    pub(crate) effect: usize,
    /// Directions of its amounts: index of the first, and their number.
    pub(crate) first: usize,
    pub(crate) count: usize,
    /// Whether each amount can only be positive.
    pub(crate) positive: Vec<bool>,
    /// Number of values that a refit has to find.
    pub(crate) effect_parameters: usize,
    /// Whether it acts only as it is, without a variable amount.
    pub(crate) jumps: bool,
}

/// Everything that a drive is compared with.
#[derive(Clone, Debug)]
pub(crate) struct Directions {
    pub(crate) effects: Vec<&'static Hypothesis>,
    /// The base parameters and the initial state first, then the ways of the effects, then each effect at its usual size.
    pub(crate) all: Vec<Direction>,
    /// How many of them belong to base parameters and initial state.
    pub(crate) base_parameters: usize,
    pub(crate) ways: Vec<Way>,
    /// Effect parameters of each effect at its usual size; their directions begin at `usual`.
    pub(crate) effect_parameters: Vec<Values>,
    pub(crate) usual: usize,
}

impl Directions {
    pub(crate) fn of(
        scene: &Scene<'_>,
        base_parameters: &[Free],
        effects: &[&'static Hypothesis],
        sensors: &[Sensor],
    ) -> Self {
        let mut all = parameters(scene.machine, base_parameters);
        all.extend(start(scene.machine, sensors));
        let count = all.len();
        let mut ways = Vec::new();
        for (effect, hypothesis) in effects.iter().enumerate() {
            for form in hypothesis.forms_in(scene) {
                for (values, free) in points(scene, form) {
                    let first = all.len();
                    all.extend(
                        free.iter()
                            .map(|(amounts, _)| Direction::once(scene.machine, &[values.as_slice(), amounts].concat())),
                    );
                    let positive = free.iter().map(|(_, positive)| *positive).collect();
                    let jumps = is_jump(form);
                    ways.push(Way { effect, first, count: free.len(), positive, effect_parameters: form.len(), jumps });
                }
            }
        }
        let effect_parameters: Vec<Values> = effects.iter().map(|hypothesis| usual(scene, hypothesis)).collect();
        let usual = all.len();
        all.extend(effect_parameters.iter().map(|values| Direction::once(scene.machine, values)));
        Self { effects: effects.to_vec(), all, base_parameters: count, ways, effect_parameters, usual }
    }

    /// Smallest number of effect parameters that an effect needs.
    pub(crate) fn fewest(&self, effect: usize) -> usize {
        self.ways.iter().filter(|way| way.effect == effect).map(|way| way.effect_parameters).min().unwrap_or(1)
    }
}

/// The machine with each base parameter moved; a move of 1 is one standard deviation.
fn parameters(machine: &Machine<f64>, base_parameters: &[Free]) -> Vec<Direction> {
    let moved = |free: &Free| {
        // At an end of its range it is moved in the other direction.
        [SHARE, -SHARE].into_iter().find_map(|share| {
            let value = free.value(free.coordinate(machine.get(free.parameter)) + share);
            let there = (value - machine.get(free.parameter)).abs() > 0.0;
            there.then(|| Direction { times: 1.0 / share, ..Direction::once(machine, &[(free.parameter, value)]) })
        })
    };
    base_parameters.iter().filter_map(moved).collect()
}

/// What is uncertain about the initial state: the level of pressure where none is recorded, and the position within its noise.
fn start(machine: &Machine<f64>, sensors: &[Sensor]) -> Vec<Direction> {
    let mut found = Vec::new();
    let is_pressure = |sensor: &&Sensor| matches!(sensor.signal, Signal::PressureA | Signal::PressureB);
    if sensors.iter().filter(is_pressure).count() < 2 {
        let level = machine.get(Parameter::LevelAtRest);
        let moved = level + SHARE * LEVEL * level * (1.0 - level);
        let offset = StartOffset { level: Some(moved), shift_m: 0.0 };
        found.push(Direction { machine: *machine, offset, times: 1.0 / SHARE });
    }
    if let Some(sensor) = sensors.iter().find(|sensor| sensor.signal == Signal::Position) {
        let offset = StartOffset { level: None, shift_m: sensor.noise / ROWS_AT_REST.sqrt() };
        found.push(Direction { machine: *machine, offset, times: 1.0 });
    }
    found
}

fn is_jump(form: Form) -> bool {
    form.iter().all(EffectParameter::is_jump)
}

/// Every combination of a form's shapes, with the amounts that are free there, each at its usual size, and whether they can only be positive.
fn points(scene: &Scene<'_>, form: Form) -> Vec<(Values, Vec<(Values, bool)>)> {
    if is_jump(form) {
        let tries = form.iter().map(|effect_parameter| {
            let (low, high) = effect_parameter.range(scene);
            let share = |index: usize| (index as f64 + 0.5) / TRIED as f64;
            (effect_parameter.parameter, (0..TRIED).map(|index| low * libm::pow(high / low, share(index))).collect())
        });
        return combined(Vec::new(), tries).into_iter().map(|values| (Vec::new(), vec![(values, true)])).collect();
    }
    let free: Vec<(Values, bool)> = amounts(form)
        .map(|effect_parameter| {
            let positive = !matches!(effect_parameter.kind, Kind::Signed(_));
            (vec![(effect_parameter.parameter, effect_parameter.unit(scene))], positive)
        })
        .collect();
    shapes(scene, form).into_iter().map(|shape| (shape, free.clone())).collect()
}

/// The plainest form of an effect at its usual size: the middle of every range.
fn usual(scene: &Scene<'_>, hypothesis: &Hypothesis) -> Values {
    let Some(form) = hypothesis.forms_in(scene).next() else { return Vec::new() };
    let all = shapes(scene, form);
    let middle = all.get(all.len() / 2).cloned().unwrap_or_default();
    let amounts = amounts(form).map(|effect_parameter| (effect_parameter.parameter, effect_parameter.unit(scene)));
    middle.into_iter().chain(amounts).collect()
}
