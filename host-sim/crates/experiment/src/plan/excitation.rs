//! The excitation that separates effects best: the best choice of standard tests, one after the other.

use identification::parallel;

use model_core::machine::{Machine, MachineError, Parameter, Tick};
use recording::Signal;
use simulation::{StartOffset, rows_f64};

use super::directions::Directions;
use super::isolability::Isolability;
use super::products::{Products, View};
use crate::sensor::Sensor;
use crate::standard_tests::{StandardTest, command_for};

/// Speed at which the rod is brought back between two tests, m/s.
const BACK_M_PER_S: f64 = 0.05;
/// Longest way back, s.
const LONGEST_BACK_S: f64 = 4.0;
/// Rest after it, s.
const REST_S: f64 = 0.3;

/// A standard test followed by the way back to mid-stroke, and what it shows.
#[derive(Clone, Debug)]
pub(crate) struct Leg {
    pub(crate) test: StandardTest,
    pub(crate) products: Products,
}

impl Leg {
    /// A test that can be simulated on the drive.
    pub(crate) fn of(
        test: &StandardTest,
        machine: &Machine<f64>,
        largest_v: f64,
        directions: &Directions,
        sensors: &[Sensor],
        tick: Tick,
    ) -> Result<Option<Self>, MachineError> {
        let test = brought_back(test, machine, largest_v, tick)?;
        let Some(stimulus) = test.stimulus(machine, tick) else { return Ok(None) };
        let changes = View { stimulus: &stimulus, sensors }.changes(machine, &directions.all)?;
        let products = Products::of(&changes, stimulus.rows());
        Ok(Some(Self { test, products }))
    }
}

/// Position of the rod in every row, m.
fn positions(test: &StandardTest, machine: &Machine<f64>, tick: Tick) -> Result<Vec<f64>, MachineError> {
    let mut found = Vec::new();
    if let Some(stimulus) = test.stimulus(machine, tick) {
        rows_f64(machine, &stimulus, StartOffset::none(), &mut |_, signal| {
            found.extend(signal(Signal::Position));
        })?;
    }
    Ok(found)
}

/// A test, then slowly back to mid-stroke, then rest.
fn brought_back(
    test: &StandardTest,
    machine: &Machine<f64>,
    largest_v: f64,
    tick: Tick,
) -> Result<StandardTest, MachineError> {
    let rows = |seconds: f64| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few seconds of rows")]
        let rows = (seconds / test.interval_s).round() as usize;
        rows
    };
    let extended = |command_v: f64, count: usize| {
        let mut longer = test.clone();
        longer.command_v.extend(std::iter::repeat_n(command_v, count));
        if !longer.load_n.is_empty() {
            longer.load_n.resize(longer.command_v.len(), 0.0);
        }
        longer
    };
    let middle = 0.5 * machine.get(Parameter::Stroke);
    let end = positions(test, machine, tick)?.last().map_or(0.0, |end| end - middle);
    let command_v = command_for(machine, largest_v, -BACK_M_PER_S.copysign(end));
    let way = positions(&extended(command_v, rows(LONGEST_BACK_S)), machine, tick)?;
    let back = way.iter().skip(test.command_v.len()).take_while(|position| (*position - middle) * end > 0.0).count();
    let mut test = extended(command_v, back);
    let rest = rows(REST_S);
    test.command_v.extend(std::iter::repeat_n(0.0, rest));
    if !test.load_n.is_empty() {
        test.load_n.resize(test.command_v.len(), 0.0);
    }
    Ok(test)
}

/// Indices of the best choice of legs, no longer than `longest_s` together: the one that shows most with the sensors at hand; among equals the
/// shortest.
pub(crate) fn best(legs: &[Leg], directions: &Directions, at_hand: &[usize], longest_s: f64) -> Vec<usize> {
    let choices: Vec<(Vec<usize>, f64)> = (1_u32..1 << legs.len())
        .map(|choice| (0..legs.len()).filter(|leg| choice & (1 << leg) != 0).collect::<Vec<usize>>())
        .map(|chosen| {
            let duration = chosen.iter().map(|&leg| legs[leg].test.duration_s()).sum();
            (chosen, duration)
        })
        .filter(|(_, duration)| *duration <= longest_s)
        .collect();
    let valued = parallel::each(choices, |(chosen, duration)| {
        let sum = Products::sum(chosen.iter().map(|&leg| &legs[leg].products))?;
        let (products, samples) = sum.over(at_hand);
        Some((Isolability::of(directions, &products, samples).worth(), duration, chosen))
    });
    let better = |a: &((usize, f64), f64, Vec<usize>), b: &((usize, f64), f64, Vec<usize>)| {
        (a.0.0.cmp(&b.0.0)).then(a.0.1.total_cmp(&b.0.1)).then(b.1.total_cmp(&a.1))
    };
    valued
        .into_iter()
        .flatten()
        .reduce(|best, next| if better(&next, &best).is_gt() { next } else { best })
        .map_or(Vec::new(), |best| best.2)
}

/// Tests joined one after the other.
pub(crate) fn joined(tests: &[&StandardTest]) -> Option<StandardTest> {
    let first = tests.first()?;
    let mut all = StandardTest {
        name: "the excitation that separates most",
        how: tests.iter().map(|test| format!("{} ({})", test.name, test.how)).collect::<Vec<_>>().join(", then "),
        interval_s: first.interval_s,
        command_v: Vec::new(),
        load_n: Vec::new(),
    };
    let loaded = tests.iter().any(|test| !test.load_n.is_empty());
    for test in tests {
        // A test ends where the next one begins, at rest in the middle: the first row of the next is dropped.
        let from = usize::from(!all.command_v.is_empty());
        all.command_v.extend(test.command_v.iter().skip(from));
        if loaded {
            all.load_n.extend(test.load_n.iter().skip(from));
            all.load_n.resize(all.command_v.len(), 0.0);
        }
    }
    Some(all)
}
