//! Where a mismatch sits: which link, which signal, when, and in which states of the drive.
//!
//! The refitted model is run twice over every recording: entered where the chain begins, and entered at the measured slider,
//! where there is one. A link that is driven by its measured input and still misses its measured output lacks physics.

use model_core::machine::{Machine, MachineError};
use model_core::parameter::Parameter;
use nalgebra::DVector;

use crate::evidence::{Account, Evidence, Lack, Pattern, weigh};
use crate::fit::{Fit, Free, Freedom, From, StartState, fit, standardised};
use crate::hypothesis::Subsystem;
use crate::links::{Balance, Coefficients, Observed, WINDOW_S, Window, residuals, slider_residuals};
use crate::machine_file::LoadSource;
use crate::patterns::{patterns, wrong_parameters};
use crate::prepare::Prepared;
use crate::recording::{Recording, Signal};
use crate::simulate::{EntryPoint, Trajectory, simulate};

/// A stretch of a recording.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Interval {
    /// The recording.
    pub recording: String,
    /// Start, s.
    pub from_s: f64,
    /// End, s.
    pub to_s: f64,
}

/// How far one signal misses, in standard deviations of its noise (root mean square over all recordings).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Miss {
    /// The signal.
    pub signal: Signal,
    /// RMSE over noise; 1 is a perfect model.
    pub over_noise: f64,
}

/// The place of a mismatch.
#[derive(Clone, Debug, PartialEq)]
pub struct Location {
    /// The link.
    pub subsystem: Subsystem,
    /// The signal that misses most.
    pub signal: Signal,
    /// Share of that signal's squared error that lies in the intervals.
    pub share: f64,
    /// Where the error is made, the largest first; five a recording at most.
    pub intervals: Vec<Interval>,
    /// In which states of the drive, in words.
    pub region: String,
    /// Every judged signal, end to end.
    pub misses: Vec<Miss>,
}

/// A training recording with what was prepared from it.
#[derive(Clone, Copy, Debug)]
pub struct Case<'a> {
    /// As read.
    pub recording: &'a Recording,
    /// As the fit sees it.
    pub prepared: &'a Prepared,
    /// The state it starts from.
    pub start: StartState,
}

/// Locates what `machine`, already refitted, misses.
///
/// The subsystem is the first of `named`, those of the effects claimed, the one that explains most first; without any, the one
/// that the balances of the links speak for. `promises` are the log-likelihoods that the best hypothesis of each subsystem would
/// gain; they decide with the balances where no pressures were recorded.
pub fn locate(
    machine: &Machine<f64>,
    load: LoadSource,
    cases: &[Case<'_>],
    named: &[Subsystem],
    promises: &[(Subsystem, f64)],
) -> Result<Location, MachineError> {
    let misses = misses(machine, cases)?;
    let below = entered_at_slider(machine, load, cases);
    let (accounts, evidence) = evidence(machine, load, below)?;
    let subsystem = match named.first() {
        Some(named) => *named,
        None => judged(machine, cases, &accounts, &evidence, promises)?,
    };
    let signal = worst(&misses, subsystem);
    let mut intervals = Vec::new();
    let (mut inside, mut total) = (0.0, 0.0);
    let mut states = States::default();
    for case in cases {
        let trajectory = simulate::<f64>(machine, &case.prepared.stimulus, case.start.offset(case.prepared))?;
        let Some(channel) = case.prepared.channels.iter().find(|channel| channel.signal == signal) else { continue };
        let Some(simulated) = trajectory.signal(signal) else { continue };
        let errors: Vec<f64> = channel
            .recorded
            .iter()
            .zip(simulated)
            .zip(&channel.failed)
            .map(|((recorded, simulated), failed)| if *failed { 0.0 } else { (recorded - simulated) / channel.noise })
            .collect();
        let made = made(signal, &case.prepared.time_s, &errors);
        let (stretches, held) = stretches(&made);
        inside += held;
        total += made.iter().map(|error| error * error).sum::<f64>();
        let time_s = &case.prepared.time_s;
        intervals.extend(stretches.into_iter().map(|(from, to)| Interval {
            recording: case.prepared.name.clone(),
            from_s: time_s[from],
            to_s: time_s[to],
        }));
        states.add(machine, &trajectory, &made);
    }
    let share = if total > 0.0 { inside / total } else { 0.0 };
    Ok(Location { subsystem, signal, share, intervals, region: states.region(), misses })
}

/// RMSE over noise of every judged signal.
pub fn misses(machine: &Machine<f64>, cases: &[Case<'_>]) -> Result<Vec<Miss>, MachineError> {
    let mut sums: Vec<(Signal, f64, f64)> = Vec::new();
    for case in cases {
        let series = standardised(machine, case.prepared, case.start)?;
        for (channel, series) in case.prepared.channels.iter().zip(&series) {
            let square: f64 = series.iter().map(|value| value * value).sum();
            match sums.iter_mut().find(|(signal, ..)| *signal == channel.signal) {
                Some((_, sum, rows)) => {
                    *sum += square;
                    *rows += series.len() as f64;
                }
                None => sums.push((channel.signal, square, series.len() as f64)),
            }
        }
    }
    Ok(sums.into_iter().map(|(signal, sum, rows)| Miss { signal, over_noise: (sum / rows).sqrt() }).collect())
}

/// The recordings entered at the measured slider, where it was left out above.
fn entered_at_slider<'a>(machine: &Machine<f64>, load: LoadSource, cases: &[Case<'a>]) -> Vec<Below<'a>> {
    cases
        .iter()
        .map(|case| {
            let tick = Some(case.prepared.stimulus.tick);
            let enters = case.prepared.stimulus.entry == EntryPoint::Command && case.recording.has(Signal::Spool);
            let prepared = enters.then(|| Prepared::entered_at(EntryPoint::Slider, case.recording, machine, load, tick).ok());
            Below { recording: case.recording, start: case.start, prepared: prepared.flatten().unwrap_or_else(|| case.prepared.clone()) }
        })
        .collect()
}

/// A recording entered as far down the chain as its slider allows.
struct Below<'a> {
    recording: &'a Recording,
    prepared: Prepared,
    start: StartState,
}

impl Below<'_> {
    fn case(&self) -> Case<'_> {
        Case { recording: self.recording, prepared: &self.prepared, start: self.start }
    }
}

/// What the balances of the links leave over, and which link that speaks for.
fn evidence(
    machine: &Machine<f64>,
    load: LoadSource,
    mut below: Vec<Below<'_>>,
) -> Result<(Vec<Account>, Evidence), MachineError> {
    // Pressures make balances of their own; without them the motion is simulated, by a model that the valve's lacks did not bend.
    let has_pressures = below.iter().any(|case| case.prepared.channels.iter().any(|channel| channel.signal == Signal::PressureA));
    let alone = if has_pressures {
        None
    } else {
        let cases: Vec<Prepared> = below.iter().map(|case| case.prepared.judged_by(|signal| signal != Signal::Spool)).collect();
        refitted(machine, &cases, BELOW_SLIDER)
    };
    let machine = alone.as_ref().map_or(machine, |fit| {
        for (case, start) in below.iter_mut().zip(&fit.starts) {
            case.start = *start;
        }
        &fit.machine
    });
    let by = Coefficients::of(machine);
    let (supply_pa, stroke_m) = (machine.get(Parameter::SupplyPressure), machine.get(Parameter::Stroke));
    let mut accounts = Vec::new();
    for case in &below {
        if let Some(observed) = Observed::of(machine, &case.case())? {
            let windows = Window::over(&observed.time_s, WINDOW_S);
            let residuals = residuals(&observed, &by, &windows, load != LoadSource::RecordedPressures);
            accounts.push(Account { observed, windows, residuals });
        }
    }
    let stacked = |lacks: &dyn Fn(&Account) -> Vec<Lack>| -> Vec<DVector<f64>> {
        let each: Vec<Vec<Vec<f64>>> = accounts
            .iter()
            .map(|account| lacks(account).iter().map(|lack| account.left_by(lack, &by)).collect())
            .collect();
        let count = each.iter().map(Vec::len).min().unwrap_or(0);
        (0..count)
            .map(|index| DVector::from_iterator(
                each.iter().map(|of| of[index].len()).sum(),
                each.iter().flat_map(|of| of[index].iter().copied()),
            ))
            .collect()
    };
    let wrong = stacked(&|account| wrong_parameters(&account.observed, &by, supply_pa));
    let lacks = |account: &Account| patterns(&account.observed, &by, stroke_m);
    let left_by = stacked(&|account| lacks(account).into_iter().map(|(_, lack)| lack).collect());
    let of: Vec<Subsystem> = accounts.first().map_or_else(Vec::new, |account| lacks(account).iter().map(|(of, _)| *of).collect());
    let patterns: Vec<Pattern> =
        of.into_iter().zip(left_by).map(|(subsystem, left)| Pattern { subsystem, left }).collect();
    let all = || accounts.iter().flat_map(|account| &account.residuals);
    let left = DVector::from_iterator(all().count(), all().map(|residual| residual.value / residual.sigma));
    let balances: Vec<Balance> = all().map(|residual| residual.balance).collect();
    let evidence = weigh(&left, &balances, &wrong, &patterns);
    Ok((accounts, evidence))
}

/// The link that the evidence speaks for.
fn judged(
    machine: &Machine<f64>,
    cases: &[Case<'_>],
    accounts: &[Account],
    evidence: &Evidence,
    promises: &[(Subsystem, f64)],
) -> Result<Subsystem, MachineError> {
    let slider = valve(machine, cases)?;
    let worst = |evidence: &Evidence| evidence.over_noise.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    if worst(&slider) > GATE && worst(&slider) > worst(evidence) {
        return Ok(Subsystem::Valve);
    }
    let share = |values: &[(Subsystem, f64)], subsystem: Subsystem| {
        let largest = values.iter().map(|(_, value)| *value).fold(0.0, f64::max);
        values.iter().find(|(of, _)| *of == subsystem).map_or(0.0, |(_, value)| value / largest.max(1.0))
    };
    let measured = accounts.iter().any(|account| account.observed.has_pressures);
    let total = |subsystem| {
        share(&evidence.links, subsystem) + if measured { 0.0 } else { share(promises, subsystem) }
    };
    let best = evidence.links.iter().map(|(of, _)| *of).max_by(|a, b| total(*a).total_cmp(&total(*b)));
    Ok(best.unwrap_or(Subsystem::Flow))
}

/// A link is missed when what is left over, wrong parameters taken out, is further off than half the noise again.
const GATE: f64 = 1.5;

/// Parameters of the valve alone.
const OF_VALVE: &[Parameter] = &[
    Parameter::ValveGain,
    Parameter::ValveOffset,
    Parameter::RateLimit,
    Parameter::TimeConstant1,
    Parameter::TimeConstant2,
    Parameter::TransportDelay,
];
/// Parameters of the links below it that are never known well.
const BELOW_SLIDER: &[Parameter] =
    &[Parameter::FlowCoefficient, Parameter::DeadZone, Parameter::BulkModulus, Parameter::ViscousFriction];

/// A link's own parameters refitted to its own output, so that what other links lack does not bend it.
fn refitted(machine: &Machine<f64>, cases: &[Prepared], parameters: &[Parameter]) -> Option<Fit> {
    let free: Vec<Free> = parameters
        .iter()
        .filter_map(|&parameter| {
            let nominal = machine.get(parameter);
            let sigma = if parameter == Parameter::ValveOffset { 0.01 } else { 0.1 * nominal.abs() };
            (nominal.is_finite() && sigma > 0.0)
                .then_some(Free { parameter, freedom: Freedom::Around { nominal, sigma } })
        })
        .collect();
    let references: Vec<&Prepared> = cases.iter().filter(|case| !case.channels.is_empty()).collect();
    if references.len() < cases.len() {
        return None;
    }
    fit(machine, &free, &references, &From::default(), 1e-5).ok()
}

/// What the valve leaves over between the command and the measured slider.
fn valve(machine: &Machine<f64>, cases: &[Case<'_>]) -> Result<Evidence, MachineError> {
    let alone: Vec<Prepared> = cases.iter().map(|case| case.prepared.judged_by(|signal| signal == Signal::Spool)).collect();
    let alone = refitted(machine, &alone, OF_VALVE);
    let machine = alone.as_ref().map_or(machine, |fit| &fit.machine);
    let mut left = Vec::new();
    let mut wrong: [Vec<f64>; 4] = Default::default();
    for case in cases {
        let Some(channel) = case.prepared.channels.iter().position(|channel| channel.signal == Signal::Spool) else { continue };
        let missed = standardised(machine, case.prepared, case.start)?.swap_remove(channel);
        let trajectory = simulate::<f64>(machine, &case.prepared.stimulus, case.start.offset(case.prepared))?;
        let Some(slider) = trajectory.signal(Signal::Spool) else { continue };
        let windows = Window::over(&case.prepared.time_s, WINDOW_S);
        let noise = case.prepared.channels[channel].noise;
        for (window, residual) in windows.iter().zip(slider_residuals(&missed, &windows)) {
            let per = 1.0 / (noise * residual.sigma);
            left.push(residual.value / residual.sigma);
            // Gain, offset, lags and delay.
            wrong[0].push(0.05 * per * window.sum(slider));
            wrong[1].push(0.01 * per * window.sum(&vec![1.0; slider.len()]));
            wrong[2].push(0.003 * per * window.change(slider));
            wrong[3].push(1e-5 * per * window.curvature(slider));
        }
    }
    let balances = vec![Balance::Slider; left.len()];
    let wrong: Vec<DVector<f64>> = wrong.into_iter().map(DVector::from_vec).collect();
    Ok(weigh(&DVector::from_vec(left), &balances, &wrong, &[]))
}

/// The signal that misses most of those that the link puts out: the slider for the valve, all others for the rest.
fn worst(misses: &[Miss], subsystem: Subsystem) -> Signal {
    let of_link = |miss: &&Miss| (miss.signal == Signal::Spool) == (subsystem == Subsystem::Valve);
    let worst = misses.iter().filter(of_link).max_by(|a, b| a.over_noise.total_cmp(&b.over_noise));
    worst.or(misses.iter().max_by(|a, b| a.over_noise.total_cmp(&b.over_noise))).map_or(Signal::Position, |miss| miss.signal)
}

/// Where an error is *made*: a position keeps what was lost before, so its change over 50 ms counts.
fn made(signal: Signal, time_s: &[f64], errors: &[f64]) -> Vec<f64> {
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

/// The stretches with the largest errors, as first and last row, and the squared error they hold.
fn stretches(errors: &[f64]) -> (Vec<(usize, usize)>, f64) {
    let mean = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
    let threshold = mean.max(9.0);
    let join = errors.len() / 100 + 1;
    let mut found: Vec<(usize, usize, f64)> = Vec::new();
    for (row, error) in errors.iter().enumerate() {
        let square = error * error;
        if square <= threshold {
            continue;
        }
        match found.last_mut() {
            Some((_, last, sum)) if row - *last <= join => {
                *last = row;
                *sum += square;
            }
            _ => found.push((row, row, square)),
        }
    }
    found.retain(|(first, last, _)| last > first);
    found.sort_by(|a, b| b.2.total_cmp(&a.2));
    found.truncate(5);
    (found.iter().map(|(first, last, _)| (*first, *last)).collect(), found.iter().map(|(.., sum)| sum).sum())
}

/// Errors and time spent per region of the state space.
#[derive(Debug, Default)]
struct States {
    rows: f64,
    error: f64,
    regions: Vec<(&'static str, f64, f64)>,
}

impl States {
    fn add(&mut self, machine: &Machine<f64>, trajectory: &Trajectory, errors: &[f64]) {
        let series = |signal| trajectory.signal(signal).unwrap_or(&[]);
        let at = |values: &[f64], row: usize| values.get(row).copied().unwrap_or(0.0);
        let (velocity, spool) = (series(Signal::Velocity), series(Signal::Spool));
        let (a, b) = (series(Signal::PressureA), series(Signal::PressureB));
        let peak = velocity.iter().fold(0.0_f64, |peak, value| peak.max(value.abs())).max(f64::MIN_POSITIVE);
        let supply = machine.get(Parameter::SupplyPressure);
        for (row, error) in errors.iter().enumerate() {
            let (v, x) = (at(velocity, row) / peak, at(spool, row).abs());
            let high = at(a, row).max(at(b, row)) / supply;
            let low = at(a, row).min(at(b, row));
            let still = v.abs() < 0.02;
            let inside = [
                ("while the rod rests", still),
                ("near zero velocity while extending", v > 0.0 && v < 0.15 && !still),
                ("near zero velocity while retracting", v < 0.0 && v > -0.15 && !still),
                ("while extending", v > 0.02),
                ("while retracting", v < -0.02),
                ("at high speed", v.abs() > 0.6),
                ("beyond 60 % of slider travel", x > 0.6),
                ("below 30 % of slider travel, moving", x < 0.3 && !spool.is_empty() && !still),
                ("with a chamber below 40 bar", !a.is_empty() && low < 4e6),
                ("with a chamber above 60 % of supply", high > 0.6),
            ];
            if self.regions.is_empty() {
                self.regions = inside.iter().map(|(name, _)| (*name, 0.0, 0.0)).collect();
            }
            let square = error * error;
            self.rows += 1.0;
            self.error += square;
            for (region, (_, holds)) in self.regions.iter_mut().zip(inside) {
                if holds {
                    region.1 += 1.0;
                    region.2 += square;
                }
            }
        }
    }

    /// The region that holds a third of the error at least and most of it for the time spent there.
    fn region(&self) -> String {
        let dense = |rows: f64, error: f64| (error / self.error) / (rows / self.rows).max(1e-9);
        let best = self
            .regions
            .iter()
            .filter(|(_, rows, error)| *rows > 0.0 && *error > self.error / 3.0)
            .max_by(|a, b| dense(a.1, a.2).total_cmp(&dense(b.1, b.2)));
        match best {
            Some((name, rows, error)) if dense(*rows, *error) > 1.3 => {
                format!(
                    "{name}: {:.0} % of the error in {:.0} % of the time",
                    100.0 * error / self.error,
                    100.0 * rows / self.rows
                )
            }
            _ => "spread over all states".to_owned(),
        }
    }
}
