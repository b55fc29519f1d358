//! Which link a misfit is in, determined from the balances of the links alone.

use nalgebra::DVector;

use identification::experiment::Prepared;
use identification::fit::{Fit, Free, Freedom, From, OF_VALVE, StartState, fit};
use machine_file::LoadSource;
use model_core::machine::{Machine, MachineError, Parameter};
use recording::{Recording, Signal};
use simulation::signal::window::{WINDOW_S, Window};
use simulation::{InputPoint, simulate_f64};

use super::balances::{Balance, Coefficients, Observed, residuals, spool_residuals};
use super::case::Case;
use super::lack_patterns::{patterns, wrong_parameters};
use super::link_evidence::{Account, Evidence, Lack, Pattern, weigh};
use crate::catalogue::Subsystem;

/// Residual of one recording's balances of one link.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LeftOver {
    /// The recording.
    pub recording: String,
    /// Middle of each window, s.
    pub time_s: Vec<f64>,
    /// Residual above the noise in each window, in standard deviations of the noise.
    pub above_noise: Vec<f64>,
}

/// The link whose output the model misses, with its residuals.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MissingLink {
    /// The link.
    pub subsystem: Subsystem,
    /// Residuals of the rod's momentum, or of its motion where no pressures are recorded; empty without a position.
    pub of_rod: Vec<LeftOver>,
    /// Whether both pressures are recorded.
    pub has_pressures: bool,
}

/// The link whose output the model misses, as far as the recordings show it.
///
/// `predicted_gains` are the log-likelihoods that the best hypothesis of each subsystem would gain; where no pressures are recorded they
/// count as much as the balances.
pub(super) fn missing_link(
    machine: &Machine<f64>,
    load: LoadSource,
    cases: &[Case<'_>],
    predicted_gains: &[(Subsystem, f64)],
) -> Result<MissingLink, MachineError> {
    let (accounts, evidence) = evidence(machine, load, entered_at_spool(machine, load, cases))?;
    let subsystem = judged(machine, cases, &accounts, &evidence, predicted_gains)?;
    let of_rod = accounts
        .iter()
        .map(|account| {
            let rows = account.residuals.iter().enumerate();
            let of_rod = rows.filter(|(_, residual)| matches!(residual.balance, Balance::Force | Balance::Motion));
            let (time_s, above_noise) = of_rod
                .map(|(index, residual)| {
                    let window = &account.windows[index / account.per_window()];
                    let square = (residual.value / residual.sigma).powi(2);
                    (account.observed.time_s[window.middle()], (square - 1.0).max(0.0).sqrt())
                })
                .unzip();
            LeftOver { recording: account.observed.name.clone(), time_s, above_noise }
        })
        .collect();
    Ok(MissingLink { subsystem, of_rod, has_pressures: accounts.iter().any(|account| account.observed.has_pressures) })
}

/// The recordings; those that the command drives although their spool is measured are driven by the measured spool instead.
fn entered_at_spool<'a>(machine: &Machine<f64>, load: LoadSource, cases: &[Case<'a>]) -> Vec<Below<'a>> {
    cases
        .iter()
        .map(|case| {
            let tick = Some(case.prepared.stimulus.tick);
            let enters = case.prepared.stimulus.input_point == InputPoint::Command && case.recording.has(Signal::Spool);
            let prepared =
                enters.then(|| Prepared::entered_at(InputPoint::Spool, case.recording, machine, load, tick).ok());
            Below {
                recording: case.recording,
                start: case.start,
                prepared: prepared.flatten().unwrap_or_else(|| case.prepared.clone()),
            }
        })
        .collect()
}

/// A recording driven by its measured spool, or by its original input where no spool is recorded.
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

/// Residuals of the balances of the links, and the evidence that they give for each link.
fn evidence(
    machine: &Machine<f64>,
    load: LoadSource,
    mut below: Vec<Below<'_>>,
) -> Result<(Vec<Account>, Evidence), MachineError> {
    // Pressures give balances of their own; without them the motion is simulated by a model that was refitted without the spool's signal,
    // so that what the valve lacks does not pull it.
    let has_pressures =
        below.iter().any(|case| case.prepared.channels.iter().any(|channel| channel.signal == Signal::PressureA));
    let alone = if has_pressures {
        None
    } else {
        let cases: Vec<Prepared> =
            below.iter().map(|case| case.prepared.judged_by(|signal| signal != Signal::Spool)).collect();
        refitted(machine, &cases, BELOW_SPOOL)
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
            .map(|index| {
                DVector::from_iterator(
                    each.iter().map(|of| of[index].len()).sum(),
                    each.iter().flat_map(|of| of[index].iter().copied()),
                )
            })
            .collect()
    };
    let wrong = stacked(&|account| wrong_parameters(&account.observed, &by, supply_pa));
    let lacks = |account: &Account| patterns(&account.observed, &by, stroke_m);
    let left_by = stacked(&|account| lacks(account).into_iter().map(|(_, lack)| lack).collect());
    let of: Vec<Subsystem> =
        accounts.first().map_or_else(Vec::new, |account| lacks(account).iter().map(|(of, _)| *of).collect());
    let patterns: Vec<Pattern> =
        of.into_iter().zip(left_by).map(|(subsystem, left)| Pattern { subsystem, left }).collect();
    let all = || accounts.iter().flat_map(|account| &account.residuals);
    let left = DVector::from_iterator(all().count(), all().map(|residual| residual.value / residual.sigma));
    let balances: Vec<Balance> = all().map(|residual| residual.balance).collect();
    let evidence = weigh(&left, &balances, &wrong, &patterns);
    Ok((accounts, evidence))
}

/// The link that the evidence points to.
fn judged(
    machine: &Machine<f64>,
    cases: &[Case<'_>],
    accounts: &[Account],
    evidence: &Evidence,
    predicted_gains: &[(Subsystem, f64)],
) -> Result<Subsystem, MachineError> {
    let spool = valve(machine, cases)?;
    let worst = |evidence: &Evidence| evidence.over_noise.iter().map(|(_, value)| *value).fold(0.0, f64::max);
    if worst(&spool) > GATE && worst(&spool) > worst(evidence) {
        return Ok(Subsystem::Valve);
    }
    let share = |values: &[(Subsystem, f64)], subsystem: Subsystem| {
        let largest = values.iter().map(|(_, value)| *value).fold(0.0, f64::max);
        values.iter().find(|(of, _)| *of == subsystem).map_or(0.0, |(_, value)| value / largest.max(1.0))
    };
    let measured = accounts.iter().any(|account| account.observed.has_pressures);
    let total =
        |subsystem| share(&evidence.links, subsystem) + if measured { 0.0 } else { share(predicted_gains, subsystem) };
    let best = evidence.links.iter().map(|(of, _)| *of).max_by(|a, b| total(*a).total_cmp(&total(*b)));
    Ok(best.unwrap_or(Subsystem::Flow))
}

/// A link counts as missed when its residual, without what wrong parameters explain, exceeds 1.5 times the noise.
const GATE: f64 = 1.5;

/// Parameters of the links below the spool that are never known well.
const BELOW_SPOOL: &[Parameter] =
    &[Parameter::FlowCoefficient, Parameter::DeadZone, Parameter::BulkModulus, Parameter::ViscousFriction];

/// Refits a link's own parameters to its own output, so that what other links lack does not pull them.
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

/// Evidence from the valve's residual: measured less simulated spool, driven by the command.
fn valve(machine: &Machine<f64>, cases: &[Case<'_>]) -> Result<Evidence, MachineError> {
    let alone: Vec<Prepared> =
        cases.iter().map(|case| case.prepared.judged_by(|signal| signal == Signal::Spool)).collect();
    let alone = refitted(machine, &alone, OF_VALVE);
    let machine = alone.as_ref().map_or(machine, |fit| &fit.machine);
    let mut left = Vec::new();
    let mut wrong: [Vec<f64>; 4] = Default::default();
    for case in cases {
        let Some(channel) = case.prepared.channels.iter().find(|channel| channel.signal == Signal::Spool) else {
            continue;
        };
        let trajectory = simulate_f64(machine, &case.prepared.stimulus, case.start.offset(machine, case.prepared))?;
        let Some(spool) = trajectory.signal(Signal::Spool) else { continue };
        let windows = Window::over(&case.prepared.time_s, WINDOW_S);
        for (window, residual) in windows.iter().zip(spool_residuals(&channel.over_noise(spool), &windows)) {
            let per = 1.0 / (channel.noise * residual.sigma);
            left.push(residual.value / residual.sigma);
            // Gain, offset, lags and delay.
            wrong[0].push(0.05 * per * window.sum(spool));
            wrong[1].push(0.01 * per * window.sum(&vec![1.0; spool.len()]));
            wrong[2].push(0.003 * per * window.change(spool));
            wrong[3].push(1e-5 * per * window.curvature(spool));
        }
    }
    let balances = vec![Balance::Spool; left.len()];
    let wrong: Vec<DVector<f64>> = wrong.into_iter().map(DVector::from_vec).collect();
    Ok(weigh(&DVector::from_vec(left), &balances, &wrong, &[]))
}

#[cfg(test)]
mod tests {
    use model_core::machine::Tick;
    use recording::Column;
    use simulation::{StartOffset, Stimulus};

    use super::*;
    use crate::localisation::error_shape::Shape;
    use crate::localisation::locate::{Sought, locate};

    fn press() -> Machine<f64> {
        test_press::press(&[(Parameter::DeadZone, 0.05), (Parameter::ViscousFriction, 4e4)])
    }

    const TRUE: &[Signal] = &[Signal::Spool, Signal::PressureA, Signal::PressureB, Signal::Position];

    /// What sensors with a little noise record of the press under a hidden force, with something added to a signal.
    fn recorded(force_n: impl Fn(f64) -> f64, added: impl Fn(Signal, f64) -> f64) -> Recording {
        let time_s: Vec<f64> = (0..3000).map(|row| f64::from(row) * 1e-3).collect();
        let command: Vec<f64> = time_s.iter().map(|t| 3.0 * (4.0 * t).sin() + 2.0 * (9.0 * t).sin()).collect();
        let load: Vec<f64> = time_s.iter().map(|t| force_n(*t)).collect();
        let column = |signal: Signal, values: &[f64]| Column::si(signal, values.to_vec());
        let driven = Recording::new(
            "driven",
            vec![
                column(Signal::Time, &time_s),
                column(Signal::Command, &command),
                column(Signal::LoadForce, &load),
                column(Signal::Position, &vec![0.15; time_s.len()]),
            ],
        )
        .unwrap();
        let tick = Tick::OneMillisecond;
        let stimulus = Stimulus::new(&driven, &press(), InputPoint::Command, LoadSource::Constant, tick).unwrap();
        let trajectory = simulate_f64(&press(), &stimulus, StartOffset::none()).unwrap();
        let mut seed = 5_u32;
        let mut columns = vec![column(Signal::Time, &time_s), column(Signal::Command, &command)];
        for &signal in TRUE {
            let noise = match signal {
                Signal::Spool => 5e-4,
                Signal::Position => 2e-5,
                _ => 1e4,
            };
            let values: Vec<f64> = trajectory
                .signal(signal)
                .unwrap()
                .iter()
                .zip(&time_s)
                .map(|(value, time)| {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    value + added(signal, *time) + noise * 3.46 * (f64::from(seed >> 8) / f64::from(1 << 24) - 0.5)
                })
                .collect();
            columns.push(column(signal, &values));
        }
        Recording::new("made", columns).unwrap()
    }

    fn sought<'a>(
        machine: &'a Machine<f64>,
        cases: &'a [Case<'a>],
        predicted_gains: &'a [(Subsystem, f64)],
    ) -> Sought<'a> {
        Sought { machine, load: LoadSource::Constant, cases, named: &[], predicted_gains }
    }

    fn located(recording: &Recording) -> crate::localisation::locate::Location {
        let prepared = Prepared::new(recording, &press(), LoadSource::Constant, None).unwrap();
        let case = Case { recording, prepared: &prepared, start: StartState::default() };
        locate(&sought(&press(), &[case], &[])).unwrap()
    }

    #[test]
    fn balances_of_a_drive_without_lacks_are_at_their_noise() {
        let recording = recorded(|_| 0.0, |_, _| 0.0);
        let prepared = Prepared::new(&recording, &press(), LoadSource::Constant, None).unwrap();
        let case = Case { recording: &recording, prepared: &prepared, start: StartState::default() };
        let below = entered_at_spool(&press(), LoadSource::Constant, &[case]);
        let (_, evidence) = evidence(&press(), LoadSource::Constant, below).unwrap();
        for (balance, over_noise) in evidence.over_noise {
            assert!((0.7..1.3).contains(&over_noise), "{balance:?} {over_noise}");
        }
    }

    #[test]
    fn a_push_happens_once_and_sits_in_the_mechanics() {
        let found = located(&recorded(|t| if (1.2..1.3).contains(&t) { 3000.0 } else { 0.0 }, |_, _| 0.0));
        assert_eq!(found.subsystem, Subsystem::Mechanics);
        let Shape::Once { from_s, to_s, .. } = found.shape else { panic!("{:?}", found.shape) };
        assert!((1.15..1.3).contains(&from_s) && (1.2..1.36).contains(&to_s), "{from_s} {to_s}");
    }

    #[test]
    fn a_ripple_of_both_pressures_is_periodic_and_comes_from_the_flow() {
        let ripple = |signal, t: f64| match signal {
            Signal::PressureA | Signal::PressureB => 1e5 * (std::f64::consts::TAU * 60.0 * t).sin(),
            _ => 0.0,
        };
        let found = located(&recorded(|_| 0.0, ripple));
        assert_eq!(found.subsystem, Subsystem::Flow);
        let Shape::Periodic { hz, amplitude, .. } = found.shape else { panic!("{:?}", found.shape) };
        assert!((hz - 60.0).abs() < 0.5 && (amplitude / 1e5 - 1.0).abs() < 0.1, "{hz} {amplitude}");
    }

    #[test]
    fn a_ringing_position_comes_from_the_valve_only_where_it_is_commanded() {
        let ring = |t: f64| (std::f64::consts::TAU * 12.0 * t).sin();
        let rung = recorded(|_| 0.0, |signal, t| if signal == Signal::Position { 4e-4 * ring(t) } else { 0.0 });
        let time_s = rung.time_s().to_vec();
        let subsystem = |command: Vec<f64>| {
            let columns = vec![
                Column::si(Signal::Time, time_s.clone()),
                Column::si(Signal::Command, command),
                Column::si(Signal::Position, rung.signal(Signal::Position).unwrap().to_vec()),
            ];
            let recording = Recording::new("position alone", columns).unwrap();
            let prepared = Prepared::new(&recording, &press(), LoadSource::Constant, None).unwrap();
            let case = Case { recording: &recording, prepared: &prepared, start: StartState::default() };
            // The hypotheses of the valve have the largest predicted gain.
            let predicted_gains = [(Subsystem::Valve, 1000.0), (Subsystem::Flow, 1.0)];
            locate(&sought(&press(), &[case], &predicted_gains)).unwrap().subsystem
        };
        let command = rung.signal(Signal::Command).unwrap();
        assert_eq!(subsystem(command.to_vec()), Subsystem::Sensing);
        assert_eq!(
            subsystem(command.iter().zip(&time_s).map(|(u, t)| u + 1e-3 * ring(*t)).collect()),
            Subsystem::Valve
        );
    }

    #[test]
    fn a_late_position_is_found_in_the_sensing() {
        let dry = recorded(|_| 0.0, |_, _| 0.0);
        let position = dry.signal(Signal::Position).unwrap();
        let late: Vec<f64> = (0..position.len()).map(|row| position[row.saturating_sub(10)]).collect();
        let columns = [Signal::Time, Signal::Command, Signal::Spool, Signal::PressureA, Signal::PressureB]
            .into_iter()
            .map(|signal| {
                let values = if signal == Signal::Time { dry.time_s() } else { dry.signal(signal).unwrap() };
                Column::si(signal, values.to_vec())
            })
            .chain([Column::si(Signal::Position, late)])
            .collect();
        assert_eq!(located(&Recording::new("late", columns).unwrap()).subsystem, Subsystem::Sensing);
    }
}
