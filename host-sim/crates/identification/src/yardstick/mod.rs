//! A yardstick: a linear model of second order for the same recordings, without any knowledge of the drive.
//!
//! For a signal and what drives the model (a command, a flow, a force; an external load as well, where one is recorded) two models are fitted to the
//! training recordings in free run by output error: one whose output *integrates* its input through a lag, as a rod does under a valve, and one whose
//! output *follows* it, as a set value is followed. Each has a gain for every input, a constant and a delay, and an initial state for each recording.
//!
//! How well they do is measured with all recordings alike: value and rate at the beginning are those that suit the first tenth of a recording best, and the
//! rest is free run.

mod record;
mod search;
mod shape;

use recording::Signal;

use crate::experiment::Prepared;
use record::Record;
use search::{Kind, Solved, Sought, dot};

pub use shape::Shape;

/// Rows that are looked at in all, evenly chosen: a linear model of second order needs no more.
const MOST_ROWS: usize = 800;
/// Share of a recording that its initial state is taken from, and the fewest rows.
const BEGINNING: f64 = 0.1;
const FEWEST_AT_START: usize = 6;
/// A rate at the beginning is taken where it leaves at most this share of the square that the value alone leaves there.
const RATE_EXPLAINS: f64 = 0.5;
/// Fewest rows of a recording, and of all together, that tell anything of a model with seven values.
const FEWEST_ROWS: usize = 12;
const FEWEST_IN_ALL: usize = 30;
/// Two models whose squares are within this do alike: a few per cent, as thinned rows tell no more.
const ALIKE: f64 = 1.03;

/// A linear model of one signal, and how it runs in the recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Linear {
    /// Its shape.
    pub shape: Shape,
    /// Its delay, s.
    pub delay_s: f64,
    /// Gain of each input, in the signal's SI unit (of an integrator: in that over s) for one SI unit of the input.
    pub gains: Vec<f64>,
    /// What is added to the input, times its gain.
    pub constant: f64,
    /// How it runs in each training recording, then in each held-out one; `None` where the recording does not judge the signal.
    pub runs: Vec<Option<LinearRun>>,
}

/// A linear model in one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearRun {
    /// The rows that were looked at.
    pub rows: Vec<usize>,
    /// Recorded minus modelled in these, SI; 0 where the sensor failed.
    pub missed: Vec<f64>,
    /// From the first of these rows to the last, s.
    pub duration_s: f64,
    /// Root of the sum of squares of what was recorded in these rows about its mean, SI: what the fit is a share of.
    pub spread: f64,
    /// NRMSE fit in these rows, %.
    pub fit_percent: f64,
}

/// Both models of one signal.
#[derive(Clone, Debug, PartialEq)]
pub struct Yardstick {
    /// The signal.
    pub signal: Signal,
    /// The model whose output integrates its input; only a position has one.
    pub integrates: Option<Linear>,
    /// The model whose output follows its input.
    pub follows: Linear,
}

impl Yardstick {
    /// The model that follows the training recordings better, where it has to start as it does in held-out ones; of two that do so alike, the one with a
    /// value less, which integrates.
    #[must_use]
    pub fn better(&self, training: usize) -> &Linear {
        match &self.integrates {
            Some(integrates) if integrates.missed(training) <= ALIKE * self.follows.missed(training) => integrates,
            _ => &self.follows,
        }
    }
}

impl Linear {
    /// Whether its output integrates the input.
    #[must_use]
    pub fn integrates(&self) -> bool {
        matches!(self.shape, Shape::Integrates { .. })
    }

    /// Sum of squares of what it misses in the first so many recordings.
    fn missed(&self, training: usize) -> f64 {
        self.runs.iter().take(training).flatten().map(|run| dot(&run.missed, &run.missed)).sum()
    }

    /// Mean NRMSE fit over some recordings, %; `None` where none of them judges the signal.
    #[must_use]
    pub fn mean_fit_percent(&self, recordings: std::ops::Range<usize>) -> Option<f64> {
        let fits: Vec<f64> = self.runs.get(recordings)?.iter().flatten().map(|run| run.fit_percent).collect();
        (!fits.is_empty()).then(|| fits.iter().sum::<f64>() / fits.len() as f64)
    }

    fn of(solved: Solved, records: &[Option<Record>]) -> Self {
        let Solved { shape, delay_s, gains, constant, .. } = solved;
        let mut linear = Self { shape, delay_s, gains, constant, runs: Vec::new() };
        linear.runs = records.iter().map(|record| record.as_ref().map(|record| linear.run(record))).collect();
        linear
    }

    /// The free run of a recording from the initial state that suits its first rows.
    fn run(&self, record: &Record) -> LinearRun {
        let inputs = self.gains.len();
        let columns = record.columns(&self.shape, self.delay_s, inputs);
        let driven: Vec<f64> = (0..record.rows.len())
            .map(|row| {
                let by_inputs: f64 = self.gains.iter().zip(&columns).map(|(gain, column)| gain * column[row]).sum();
                by_inputs + self.constant * columns[inputs][row]
            })
            .collect();
        let (value, rate) = (&columns[inputs + 1], &columns[inputs + 2]);
        let rows = record.rows.len();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of the rows")]
        let first = ((BEGINNING * rows as f64).ceil() as usize).max(FEWEST_AT_START).min(rows);
        let unsettled = record.weight.iter().take_while(|weight| **weight == 0.0).count();
        let first = (unsettled + first).min(rows);
        let start = started([value, rate], &record.weight, &record.recorded, &driven, first);
        let modelled: Vec<f64> =
            (0..rows).map(|row| driven[row] + start[0] * value[row] + start[1] * rate[row]).collect();
        let missed: Vec<f64> =
            (0..rows).map(|row| record.weight[row] * (record.recorded[row] - modelled[row])).collect();
        let kept: f64 = record.weight.iter().sum();
        let mean = dot(&record.weight, &record.recorded) / kept;
        let spread: f64 =
            record.recorded.iter().zip(&record.weight).map(|(value, weight)| weight * (value - mean).powi(2)).sum();
        let spread = spread.sqrt();
        let fit_percent = 100.0 * (1.0 - dot(&missed, &missed).sqrt() / spread);
        LinearRun { rows: record.rows.clone(), missed, duration_s: record.duration_s(), spread, fit_percent }
    }
}

/// Value and rate at the beginning that suit the first rows best, by least squares.
fn started(columns: [&Vec<f64>; 2], weight: &[f64], recorded: &[f64], driven: &[f64], first: usize) -> [f64; 2] {
    let (mut h, mut g) = ([[0.0; 2]; 2], [0.0; 2]);
    for row in 0..first {
        let wanted = recorded[row] - driven[row];
        for one in 0..2 {
            g[one] += weight[row] * columns[one][row] * wanted;
            for other in 0..2 {
                h[one][other] += weight[row] * columns[one][row] * columns[other][row];
            }
        }
    }
    let determinant = h[0][0] * h[1][1] - h[0][1] * h[1][0];
    let at_rest = [if h[0][0] > 0.0 { g[0] / h[0][0] } else { 0.0 }, 0.0];
    // A rate that is gone before the second row shows in none.
    if determinant <= 1e-9 * h[0][0] * h[1][1] {
        return at_rest;
    }
    let moving = [(h[1][1] * g[0] - h[0][1] * g[1]) / determinant, (h[0][0] * g[1] - h[1][0] * g[0]) / determinant];
    // A rate that noise makes of a rod at rest would lead away from it for all that follows.
    let missed = |start: [f64; 2]| -> f64 {
        let row = |row: usize| driven[row] + start[0] * columns[0][row] + start[1] * columns[1][row];
        (0..first).map(|at| weight[at] * (recorded[at] - row(at)).powi(2)).sum()
    };
    if missed(moving) < RATE_EXPLAINS * missed(at_rest) { moving } else { at_rest }
}

/// The yardsticks of recordings: of the position and of the velocity, as far as they are judged; of the other judged signals where neither is.
///
/// Nothing for a signal that no input moves, or of which there are too few rows.
#[must_use]
pub fn yardsticks(training: &[&Prepared], held_out: &[&Prepared]) -> Vec<Yardstick> {
    let Some(first) = training.first() else { return Vec::new() };
    let judged = || first.channels.iter().map(|channel| channel.signal);
    let motion = [Signal::Position, Signal::Angle, Signal::Velocity];
    let moves = |signal: &Signal| motion.contains(signal);
    let signals: Vec<Signal> =
        if judged().any(|signal| moves(&signal)) { judged().filter(moves).collect() } else { judged().collect() };
    signals.into_iter().filter_map(|signal| yardstick(signal, training, held_out)).collect()
}

/// Both models of one signal.
fn yardstick(signal: Signal, training: &[&Prepared], held_out: &[&Prepared]) -> Option<Yardstick> {
    let rows: usize = training.iter().map(|case| case.rows()).sum();
    let every = rows.div_ceil(MOST_ROWS).max(1);
    let of = |case: &&Prepared| {
        // A short recording beside long ones keeps some rows.
        let every = every.min(case.rows() / FEWEST_ROWS).max(1);
        Record::of(case, signal, every)
            .filter(|record| record.judged_rows() >= FEWEST_ROWS && record.varies() && record.duration_s() > 0.0)
    };
    let records: Vec<Option<Record>> = training.iter().chain(held_out).map(of).collect();
    let trained: Vec<Record> = records.iter().take(training.len()).flatten().cloned().collect();
    if trained.iter().map(|record| record.rows.len()).sum::<usize>() < FEWEST_IN_ALL {
        return None;
    }
    let fitted = |kind| Some(Linear::of(Sought::new(&trained, kind)?.best()?, &records));
    let integrates = if matches!(signal, Signal::Position | Signal::Angle) { fitted(Kind::Integrates) } else { None };
    Some(Yardstick { signal, integrates, follows: fitted(Kind::Follows)? })
}
