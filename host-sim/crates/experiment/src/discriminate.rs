//! Which short test, or which further sensor, would distinguish an accepted effect from those that may be confused with it.
//!
//! The chosen machine and each rival's refitted one are simulated on the standard excitations. A refit with the new recording would
//! move base parameters and effect parameters within their uncertainty, so what such a move can imitate is subtracted first; the
//! remaining difference, in standard deviations of each sensor's noise, is the distance of the two.

use std::cmp::Ordering;

use identification::parallel;
use nalgebra::{DMatrix, DVector};

use diagnosis::catalogue::Hypothesis;
use diagnosis::{Diagnosis, Finding};
use machine_file::LoadSource;
use model_core::machine::{Machine, MachineError, Parameter, Source, Tick};
use recording::{Recording, Signal};
use simulation::number::simd::LANES;
use simulation::{InputPoint, Run, StartOffset, Stimulus, run_in_lanes};

use crate::sensor;
use crate::standard_tests::{StandardTest, standard_tests};

/// Largest number of rivals that a finding is compared with.
const MOST_RIVALS: usize = 3;
/// Rivals with a lower probability are only tried if the catalogue names them as look-alikes.
const NEGLIGIBLE: f64 = 0.01;
/// Length of time for which tests are compared, s: a short one may be repeated.
const PER_S: f64 = 20.0;
/// A test distinguishes two machines if they differ by this many standard deviations of the noise in some signal.
pub const TELLS: f64 = 1.0;

/// Distance of two machines in one test.
#[derive(Clone, Debug, PartialEq)]
pub struct Distance {
    /// The test.
    pub test: &'static str,
    /// How to run it.
    pub how: String,
    /// Its length, s.
    pub duration_s: f64,
    /// The signal with the largest distance.
    pub signal: Signal,
    /// The distance in standard deviations of this signal's noise, root mean square over the test.
    pub over_noise: f64,
    /// All signals together over 20 s: root of the sum of squares, in standard deviations.
    pub per_20_s: f64,
}

impl Distance {
    /// Whether the test distinguishes the two in some signal.
    #[must_use]
    pub fn tells(&self) -> bool {
        self.over_noise >= TELLS
    }
}

/// An accepted effect compared with another.
#[derive(Clone, Debug, PartialEq)]
pub struct Separation {
    /// The accepted effect.
    pub effect: &'static str,
    /// The other.
    pub rival: &'static str,
    /// Probability of the other among the candidate models tried.
    pub confidence: f64,
    /// Tests with the channels at hand: those that distinguish the two first, and otherwise by the distance, largest first.
    pub tests: Vec<Distance>,
    /// The sensor that would add most, and the best test with it.
    pub sensor: Option<(Signal, Distance)>,
}

impl Separation {
    /// Whether the best test with the channels at hand distinguishes the two.
    #[must_use]
    pub fn is_separated(&self) -> bool {
        self.tests.first().is_some_and(Distance::tells)
    }
}

/// Every accepted effect compared with its rivals.
pub fn separations(
    diagnosis: &Diagnosis,
    load: LoadSource,
    recordings: &[&Recording],
) -> Result<Vec<Separation>, MachineError> {
    let chosen = &diagnosis.machine_after;
    let Some(first) = diagnosis.shown.first() else { return Ok(Vec::new()) };
    let by_command = chosen.source == Source::Valve && first.prepared.stimulus.input_point == InputPoint::Command;
    let pairs = rivals(diagnosis);
    if !by_command || load != LoadSource::Constant || pairs.is_empty() {
        return Ok(Vec::new());
    }
    let commands = recordings.iter().filter_map(|recording| recording.signal(Signal::Command)).flatten();
    let largest_v = commands.fold(0.0_f64, |largest, volts| largest.max(volts.abs()));
    let tests = standard_tests(chosen, largest_v);
    let tick = first.prepared.stimulus.tick;
    let sensors = sensors(diagnosis);
    let moves = diagnosis.selection.chosen.uncertainty();
    let told = |tests| separated_in(tests, chosen, &moves.steps, &pairs, &sensors, tick);
    let rows = parallel::try_each(tests.chunks(LANES), told)?;
    let rows: Vec<Vec<(usize, Separated)>> = rows.into_iter().flatten().collect();
    Ok(pairs
        .iter()
        .enumerate()
        .map(|(index, pair)| {
            let of_pair: Vec<(&StandardTest, &Separated)> = tests
                .iter()
                .zip(&rows)
                .filter_map(|(test, rows)| Some((test, &rows.iter().find(|(rival, _)| *rival == index)?.1)))
                .collect();
            separation(pair, &of_pair, &sensors, &moves.precision)
        })
        .collect())
}

/// One rival of one finding.
struct Pair {
    effect: &'static str,
    rival: &'static str,
    confidence: f64,
    machine: Machine<f64>,
}

/// For each finding, the candidate models that have another effect in its place: the probable ones, then look-alikes.
fn rivals(diagnosis: &Diagnosis) -> Vec<Pair> {
    let chosen = &diagnosis.selection.chosen.effects;
    let Some(round) = chosen.len().checked_sub(1).and_then(|round| diagnosis.selection.rounds.get(round)) else {
        return Vec::new();
    };
    let mut pairs = Vec::new();
    for finding in &diagnosis.findings {
        let others = round.iter().filter(|trial| !trial.has_any(&diagnosis.not_confirmed));
        let instead = others.filter_map(|trial| Some((trial, trial.instead_of(finding.effect, chosen)?)));
        let mut found: Vec<(f64, Pair)> = Vec::new();
        let mut nearest: Option<(f64, Pair)> = None;
        for (trial, rival) in instead {
            let confidence = confidence(finding, rival);
            // If there is neither, the rival that came nearest is used.
            let wanted = confidence >= NEGLIGIBLE || looks_alike(finding.effect, rival);
            let pair = Pair { effect: finding.effect.name, rival: rival.name, confidence, machine: trial.machine };
            if wanted {
                found.push((trial.net, pair));
            } else if nearest.is_none() {
                nearest = Some((trial.net, pair));
            }
        }
        if found.is_empty() {
            found.extend(nearest);
        }
        // Equally improbable rivals are sorted by how well they fitted.
        found.sort_by(|a, b| b.1.confidence.total_cmp(&a.1.confidence).then(b.0.total_cmp(&a.0)));
        pairs.extend(found.into_iter().take(MOST_RIVALS).map(|(_, pair)| pair));
    }
    pairs
}

fn confidence(finding: &Finding, rival: &Hypothesis) -> f64 {
    finding.alternatives.iter().find(|(effect, _)| effect.name == rival.name).map_or(0.0, |(_, confidence)| *confidence)
}

fn looks_alike(effect: &Hypothesis, rival: &Hypothesis) -> bool {
    let names = |one: &Hypothesis, other: &str| one.look_alikes.iter().any(|alike| alike.effect == other);
    names(effect, rival.name) || names(rival, effect.name)
}

/// A sensor, its noise, and whether it is present.
#[derive(Clone, Copy, Debug)]
struct Sensor {
    signal: Signal,
    noise: f64,
    present: bool,
}

fn sensors(diagnosis: &Diagnosis) -> Vec<Sensor> {
    let mut found: Vec<Sensor> = Vec::new();
    for channel in diagnosis.shown.iter().flat_map(|shown| &shown.prepared.channels) {
        match found.iter_mut().find(|sensor| sensor.signal == channel.signal) {
            Some(sensor) => sensor.noise = sensor.noise.max(channel.noise),
            None => found.push(Sensor { signal: channel.signal, noise: channel.noise, present: true }),
        }
    }
    for signal in [Signal::Spool, Signal::PressureA, Signal::PressureB] {
        if found.iter().all(|sensor| sensor.signal != signal) {
            let noise = sensor::Sensor::usual(signal, &diagnosis.machine_after).noise;
            found.push(Sensor { signal, noise, present: false });
        }
    }
    found
}

/// Products of the differences of two machines in each sensor, and of the changes by moves of parameters.
struct Separated {
    rows: usize,
    /// For each sensor: Δ·Δ, Jᵀ·Δ, Jᵀ·J.
    of: Vec<(f64, DVector<f64>, DMatrix<f64>)>,
}

impl Separated {
    /// Remaining difference in each of these sensors, as a sum of squares, after the best move is subtracted. `precision` is
    /// what the recordings say about the moves: a step of one parameter may require a step of another.
    fn left(&self, sensors: &[usize], precision: &DMatrix<f64>) -> Vec<f64> {
        let count = precision.nrows();
        let (mut normal, mut right) = (precision.clone(), DVector::zeros(count));
        for &sensor in sensors {
            normal += &self.of[sensor].2;
            right += &self.of[sensor].1;
        }
        let step = normal.cholesky().map_or_else(|| DVector::zeros(count), |solved| solved.solve(&right));
        let left = |&sensor: &usize| {
            let (square, g, h) = &self.of[sensor];
            (square - 2.0 * step.dot(g) + step.dot(&(h * &step))).max(0.0)
        };
        sensors.iter().map(left).collect()
    }
}

/// Every rival on each of a few tests; empty where a test cannot be run on the drive.
fn separated_in(
    tests: &[StandardTest],
    chosen: &Machine<f64>,
    moves: &[(Parameter, f64)],
    pairs: &[Pair],
    sensors: &[Sensor],
    tick: Tick,
) -> Result<Vec<Vec<(usize, Separated)>>, MachineError> {
    let stimuli: Vec<Option<Stimulus>> = tests.iter().map(|test| test.stimulus(chosen, tick)).collect();
    let run = |stimulus| Run {
        stimulus,
        offset: StartOffset::none(),
        signals: sensors.iter().map(|sensor| sensor.signal).collect(),
    };
    let runs: Vec<Run<'_>> = stimuli.iter().flatten().map(run).collect();
    let base = seen(chosen, &runs, sensors)?;
    let mut columns: Vec<Seen> = Vec::new();
    for (parameter, step) in moves {
        let mut moved = *chosen;
        let description = parameter.description();
        moved.set(*parameter, (chosen.get(*parameter) + step).clamp(description.min, description.max));
        // A move that does not become a drive changes nothing.
        columns.push(less(seen(&moved, &runs, sensors).unwrap_or_else(|_| base.clone()), &base));
    }
    let rivals = pairs.iter().map(|pair| Ok(less(seen(&pair.machine, &runs, sensors)?, &base)));
    let rivals: Vec<Seen> = rivals.collect::<Result<_, MachineError>>()?;
    let told = |run: usize, apart: &Seen| {
        let of = apart[run].iter().enumerate().map(|(sensor, apart)| {
            let by = |one: &Seen| one[run][sensor].dot(apart);
            let g = DVector::from_iterator(columns.len(), columns.iter().map(by));
            let product = |i: usize, j: usize| columns[i][run][sensor].dot(&columns[j][run][sensor]);
            (apart.dot(apart), g, DMatrix::from_fn(columns.len(), columns.len(), product))
        });
        Separated { rows: runs[run].stimulus.rows(), of: of.collect() }
    };
    let mut run = 0..;
    let each = stimuli.iter().map(|stimulus| match stimulus {
        None => Vec::new(),
        Some(_) => {
            run.next().map_or_else(Vec::new, |run| rivals.iter().map(|apart| told(run, apart)).enumerate().collect())
        }
    });
    Ok(each.collect())
}

/// Readings of each sensor over its noise, in each of some runs.
type Seen = Vec<Vec<DVector<f64>>>;

fn seen(machine: &Machine<f64>, runs: &[Run<'_>], sensors: &[Sensor]) -> Result<Seen, MachineError> {
    let mut series: Vec<Vec<Vec<f64>>> =
        runs.iter().map(|run| vec![Vec::with_capacity(run.stimulus.rows()); sensors.len()]).collect();
    run_in_lanes(machine, runs, &mut |run, _, values| {
        for ((value, sensor), series) in values.iter().zip(sensors).zip(&mut series[run]) {
            series.push(value / sensor.noise);
        }
    })?;
    Ok(series.into_iter().map(|series| series.into_iter().map(DVector::from_vec).collect()).collect())
}

/// The difference of two such readings.
fn less(mut there: Seen, base: &Seen) -> Seen {
    for (there, base) in there.iter_mut().flatten().zip(base.iter().flatten()) {
        *there -= base;
    }
    there
}

fn separation(
    pair: &Pair,
    tests: &[(&StandardTest, &Separated)],
    sensors: &[Sensor],
    precision: &DMatrix<f64>,
) -> Separation {
    let present: Vec<usize> = (0..sensors.len()).filter(|index| sensors[*index].present).collect();
    let at_hand = ranked(tests, sensors, &present, precision);
    let with = (0..sensors.len()).filter(|index| !sensors[*index].present).filter_map(|new| {
        let wider: Vec<usize> = present.iter().copied().chain([new]).collect();
        Some((sensors[new].signal, ranked(tests, sensors, &wider, precision).into_iter().next()?))
    });
    let sensor = with.max_by(|a, b| {
        let order = |distance: &Distance| (distance.tells(), distance.per_20_s);
        order(&a.1).partial_cmp(&order(&b.1)).unwrap_or(Ordering::Equal)
    });
    // A sensor is worth its price if it doubles the distance, or if nothing distinguishes the two without it.
    let worth = |(_, distance): &(Signal, Distance)| {
        at_hand
            .first()
            .is_none_or(|best| distance.per_20_s > 2.0 * best.per_20_s || (distance.tells() && !best.tells()))
    };
    Separation {
        effect: pair.effect,
        rival: pair.rival,
        confidence: pair.confidence,
        sensor: sensor.filter(worth),
        tests: at_hand,
    }
}

/// The tests that distinguish come first; within each group, the order is by the distance in the same time.
fn ranked(
    tests: &[(&StandardTest, &Separated)],
    sensors: &[Sensor],
    with: &[usize],
    precision: &DMatrix<f64>,
) -> Vec<Distance> {
    let mut found: Vec<Distance> = tests
        .iter()
        .filter_map(|(test, told)| {
            let left = told.left(with, precision);
            let (square, sensor) = left.iter().zip(with).max_by(|a, b| a.0.total_cmp(b.0))?;
            let duration_s = test.duration_s();
            Some(Distance {
                test: test.name,
                how: test.how.clone(),
                duration_s,
                signal: sensors[*sensor].signal,
                over_noise: (square / told.rows.max(1) as f64).sqrt(),
                per_20_s: (left.iter().sum::<f64>() * PER_S / duration_s).sqrt(),
            })
        })
        .filter(|distance| distance.per_20_s.is_finite())
        .collect();
    found.sort_by(|a, b| b.tells().cmp(&a.tells()).then(b.per_20_s.total_cmp(&a.per_20_s)));
    found
}

#[cfg(test)]
mod tests;
