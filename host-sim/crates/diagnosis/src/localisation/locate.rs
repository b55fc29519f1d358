//! Where a misfit is: in which link, which signal, when, and in which states of the drive.
//!
//! The refitted model is run twice over every recording: driven by the recording's own input, and driven by the measured spool,
//! where there is one. A link that is driven by its measured input and still misses its measured output lacks physics.

use identification::experiment::{JudgedSignal, Prepared};
use identification::fit::{Misfit, StartState, misfits};
use identification::visible::shows_frequency;
use machine_file::LoadSource;
use model_core::machine::{Machine, MachineError};
use recording::{Recording, Signal};
use simulation::signal::spectrum::strongest_line;
use simulation::signal::window::{rows_in, running_sums};
use simulation::{Trajectory, simulate_f64};

use super::case::Case;
use super::error_shape::{Shape, State, once, over, periodic, stands_out};
use super::intervals::{Interval, Series, When, when};
use super::missing_link::{MissingLink, missing_link};
use super::operating_region::{Course, Region, since};
use super::spool_behaviour::{Habit, habits};
use crate::catalogue::Subsystem;
use crate::selection::decision_rule::MISSED_FROM;

/// Misfit of one signal, in standard deviations of its noise (root mean square over all recordings).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Miss {
    /// The signal.
    pub signal: Signal,
    /// RMSE over noise; 1 is a perfect model.
    pub over_noise: f64,
}

impl Miss {
    /// Whether the misfit is more than noise.
    #[must_use]
    pub fn is_above_noise(&self) -> bool {
        self.over_noise > MISSED_FROM
    }
}

/// The place of a misfit.
#[derive(Clone, Debug, PartialEq)]
pub struct Location {
    /// The link.
    pub subsystem: Subsystem,
    /// The signal with the largest misfit.
    pub signal: Signal,
    /// Share of that signal's squared error that lies in the intervals.
    pub share: f64,
    /// Share of all recorded time that the intervals take.
    pub of_time: f64,
    /// When the error arises: the intervals with the largest share first, at most five per recording; empty where no time is distinguished.
    pub intervals: Vec<Interval>,
    /// The operating region that shows best where it arises; `None` where it is alike everywhere.
    pub region: Option<Region>,
    /// What the error looks like.
    pub shape: Shape,
    /// What a recorded spool does that the model's spool does not, where the located link is the valve.
    pub spool: Vec<Habit>,
    /// Misfit of every judged signal, by the whole model.
    pub misses: Vec<Miss>,
}

/// What the localisation works on.
#[derive(Clone, Copy, Debug)]
pub struct Sought<'a> {
    /// The machine, already refitted.
    pub machine: &'a Machine<f64>,
    /// Where its load comes from.
    pub load: LoadSource,
    /// The recordings that it does not follow.
    pub cases: &'a [Case<'a>],
    /// Subsystems of the effects that are accepted, the one that explains most first.
    pub named: &'a [Subsystem],
    /// Log-likelihood that the best hypothesis of each subsystem would gain.
    pub predicted_gains: &'a [(Subsystem, f64)],
}

/// Locates what a refitted machine misses.
///
/// The subsystem is the first that is named; if none is named, the one that the balances of the links point to. Where no pressures were
/// recorded, the predicted gains of the hypotheses count beside the balances.
pub fn locate(sought: &Sought<'_>) -> Result<Location, MachineError> {
    let Sought { machine, load, cases, named, predicted_gains } = *sought;
    let misses = misses(machine, cases.iter().map(|case| (case.prepared, case.start)))?;
    let link = missing_link(machine, load, cases, predicted_gains)?;
    let event = once(
        &link
            .of_rod
            .iter()
            .map(|left| (left.recording.as_str(), left.time_s.as_slice(), left.above_noise.as_slice()))
            .collect::<Vec<_>>(),
    );
    let trajectories = cases
        .iter()
        .map(|case| simulate_f64(machine, &case.prepared.stimulus, case.start.offset(machine, case.prepared)))
        .collect::<Result<Vec<_>, _>>()?;
    let oscillating = cases.iter().zip(&trajectories).find_map(|(case, trajectory)| oscillation(case, trajectory));
    let commanded =
        matches!(&oscillating, Some(Shape::Periodic { hz, .. }) if cases.iter().any(|case| is_driven(case, *hz)));
    let subsystem = match (named.first(), &event, &oscillating) {
        (Some(named), ..) => *named,
        // An error that happens once and never again comes from a push from outside.
        (None, Some(_), _) if !link.has_pressures => Subsystem::Mechanics,
        (None, _, Some(Shape::Periodic { signal, .. })) => oscillates(*signal, &link, commanded),
        _ => link.subsystem,
    };
    // An effect that held-out recordings confirmed does not happen only once.
    let event = event.filter(|_| subsystem == Subsystem::Mechanics && named.is_empty());
    let signal = worst(&misses, subsystem);
    let spool = if subsystem == Subsystem::Valve { habits(cases, &trajectories) } else { Vec::new() };
    let mut series = Vec::new();
    let mut course = Course::default();
    for (case, trajectory) in cases.iter().zip(trajectories) {
        let Some(channel) = case.prepared.channels.iter().find(|channel| channel.signal == signal) else { continue };
        let Some(simulated) = trajectory.signal(signal) else { continue };
        let time_s = &case.prepared.time_s;
        let errors = made(signal, time_s, &channel.over_noise(simulated));
        series.push(Series { recording: &case.prepared.name, time_s, errors });
        extend(&mut course, case.recording, case.prepared, &trajectory);
    }
    let When { intervals, share, of_time } = when(&series);
    let all: Vec<f64> = series.iter().flat_map(|series| &series.errors).copied().collect();
    let shape = event.or(oscillating).unwrap_or_else(|| over(&all, &states(&course)));
    Ok(Location { subsystem, signal, share, of_time, intervals, region: course.region(&all), shape, spool, misses })
}

/// The link that an oscillation in this signal comes from: the supply's ripple reaches the chambers; a structure that rings
/// moves the encoder, but not the pressures. A valve's lags have no resonance: the valve only passes on what is commanded.
fn oscillates(signal: Signal, link: &MissingLink, commanded: bool) -> Subsystem {
    match signal {
        Signal::PressureA | Signal::PressureB | Signal::SupplyPressure => Subsystem::Flow,
        Signal::Position if link.subsystem != Subsystem::Valve || !commanded => Subsystem::Sensing,
        _ => link.subsystem,
    }
}

/// Whether the command or the spool of a recording oscillates at this frequency itself: it has a line within a tenth of it.
fn is_driven(case: &Case<'_>, hz: f64) -> bool {
    let prepared = case.prepared;
    let interval_s = prepared.duration_s() / (prepared.time_s.len().max(2) - 1) as f64;
    [Signal::Command, Signal::Spool].into_iter().filter_map(|signal| case.recording.signal(signal)).any(|values| {
        let line = strongest_line(values, interval_s, 0.9 * hz);
        line.is_some_and(|line| line.hz < 1.1 * hz && stands_out(line))
    })
}

/// Lowest frequency of an oscillation that is not the motion itself, Hz.
const SLOWEST_HZ: f64 = 8.0;

/// The strongest spectral line in the residual of any signal, or in the recorded supply pressure.
fn oscillation(case: &Case<'_>, trajectory: &Trajectory) -> Option<Shape> {
    let prepared = case.prepared;
    let interval_s = prepared.duration_s() / (prepared.time_s.len().max(2) - 1) as f64;
    let missed = prepared.channels.iter().filter_map(|channel| {
        let simulated = trajectory.signal(channel.signal)?;
        let errors: Vec<f64> = channel.over_noise(simulated).iter().map(|error| error * channel.noise).collect();
        Some((channel.signal, errors))
    });
    let supply = case.recording.signal(Signal::SupplyPressure).map(|values| (Signal::SupplyPressure, values.to_vec()));
    let found = missed.chain(supply).filter_map(|(signal, values)| {
        let line = strongest_line(&values, interval_s, SLOWEST_HZ)
            .filter(|line| shows_frequency(line.hz, interval_s, prepared.duration_s()))?;
        // Only what is faster than the motion counts: the line is compared with the power of the series less its moving mean.
        let fast = high_passed(&values, rows_in(&prepared.time_s, 0.5 / SLOWEST_HZ));
        let mean_square = fast.iter().map(|value| value * value).sum::<f64>() / fast.len().max(1) as f64;
        Some((line.above, periodic(line, mean_square, signal)?))
    });
    found.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, shape)| shape)
}

/// A series less its moving mean over `rows`.
fn high_passed(values: &[f64], rows: usize) -> Vec<f64> {
    let sums = running_sums(values.iter().copied());
    let half = rows / 2;
    (half..values.len().saturating_sub(half))
        .map(|row| values[row] - (sums[row + half + 1] - sums[row - half]) / (2 * half + 1) as f64)
        .collect()
}

/// Adds the states of the drive along one more recording: measured if recorded, else simulated.
pub fn extend(course: &mut Course, recording: &Recording, prepared: &Prepared, trajectory: &Trajectory) {
    let time_s = &prepared.time_s;
    let of = |signal: Signal| {
        let measured = prepared.channels.iter().find(|channel| channel.signal == signal).map(JudgedSignal::bridged);
        let simulated = || trajectory.signal(signal).map(<[f64]>::to_vec);
        measured.or_else(simulated).unwrap_or_else(|| vec![0.0; time_s.len()])
    };
    let velocity = trajectory.signal(Signal::Velocity).map_or_else(|| vec![0.0; time_s.len()], <[f64]>::to_vec);
    let spool = recording.signal(Signal::Spool).map_or_else(|| of(Signal::Spool), <[f64]>::to_vec);
    let fastest = velocity.iter().fold(0.0_f64, |fastest, v| fastest.max(v.abs()));
    let turned = |row: usize| row > 0 && velocity[row] * velocity[row - 1] < 0.0;
    course.since_reversal_s.extend(since(time_s, turned));
    course.since_rest_s.extend(since(time_s, |row| velocity[row].abs() < 0.01 * fastest));
    course.time_s.extend(time_s.iter().map(|time| time - time_s[0]));
    course.position_m.extend(of(Signal::Position));
    course.spool.extend(spool);
    let command = recording.signal(Signal::Command);
    course.command_v.extend(command.map_or_else(|| vec![0.0; time_s.len()], <[f64]>::to_vec));
    course.pressure_a_pa.extend(of(Signal::PressureA));
    course.pressure_b_pa.extend(of(Signal::PressureB));
    let below_spool = prepared.channels.iter().any(|channel| channel.signal != Signal::Spool);
    course.is_below_spool_seen |= below_spool;
    course.velocity_m_per_s.extend(velocity);
}

/// The states that an error may be a function of.
pub fn states(course: &Course) -> Vec<State> {
    let state = |name, unit, values: &[f64]| State { name, unit, values: values.to_vec() };
    vec![
        state("spool", "1", &course.spool),
        state("velocity", "m/s", &course.velocity_m_per_s),
        state("position", "m", &course.position_m),
        state("pressure in A", "Pa", &course.pressure_a_pa),
        state("pressure in B", "Pa", &course.pressure_b_pa),
        state("command", "V", &course.command_v),
        state("time", "s", &course.time_s),
    ]
}

/// RMSE over noise of every judged signal.
pub fn misses<'a>(
    machine: &Machine<f64>,
    cases: impl IntoIterator<Item = (&'a Prepared, StartState)>,
) -> Result<Vec<Miss>, MachineError> {
    let misfits = misfits(machine, cases)?;
    let miss = |misfit: &Misfit| Miss { signal: misfit.signal, over_noise: misfit.mean_square().sqrt() };
    Ok(misfits.iter().map(miss).collect())
}

/// The signal with the largest misfit among the outputs of the link: the spool for the valve, all other signals for the other links.
fn worst(misses: &[Miss], subsystem: Subsystem) -> Signal {
    let of_link = |miss: &&Miss| (miss.signal == Signal::Spool) == (subsystem == Subsystem::Valve);
    let worst = misses.iter().filter(of_link).max_by(|a, b| a.over_noise.total_cmp(&b.over_noise));
    worst
        .or(misses.iter().max_by(|a, b| a.over_noise.total_cmp(&b.over_noise)))
        .map_or(Signal::Position, |miss| miss.signal)
}

/// Where an error is *made*: the error of a position still contains all earlier ones, so its change over 50 ms counts.
pub fn made(signal: Signal, time_s: &[f64], errors: &[f64]) -> Vec<f64> {
    if signal != Signal::Position || errors.len() < 3 {
        return errors.to_vec();
    }
    let interval = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive count")]
    let half = ((0.025 / interval).round() as usize).clamp(1, errors.len() / 2);
    (0..errors.len())
        .map(|row| {
            let (from, to) = (row.saturating_sub(half), (row + half).min(errors.len() - 1));
            errors[to] - errors[from]
        })
        .collect()
}
