//! Fit of every measured signal, for the whole model and link by link.
//!
//! If a link is driven by its measured input and its measured output still does not fit, physics is missing in that link.

pub mod judged;
pub mod open_loop;
pub mod weakest;

use std::fmt;

use machine_file::LoadSource;
use model_core::machine::{Machine, Parameter, Source, Tick};
use recording::{Recording, Signal};
use simulation::figures_of_merit::{SignalFit, residual};
use simulation::sensor_fault::{Failures, Mended, RangeEnd};
use simulation::signal::noise::median;
use simulation::{
    Arithmetic, InputPoint, SimulateError, StartOffset, Stimulus, Trajectory, computed_below, first_input_point,
    tick_for,
};

pub use crate::error::CompareError;
use crate::experiment::unsettled_rows;
use crate::input_noise::{input_noise, realisations};
use open_loop::Sway;

/// A part of the model between measured signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Section {
    /// From the furthest measured signal upstream to every measured signal.
    EndToEnd,
    /// Command → spool.
    Valve,
    /// Spool → pressures and position: flow, chambers and mechanics together.
    BelowSpool,
    /// Measured flow → pressures and position.
    BelowFlow,
    /// Spool (or pump) and recorded pressures → position: what the flow brings less what the oil gives way.
    FlowAndChambers,
    /// Recorded pressures or force → position and velocity.
    Mechanics,
}

impl Section {
    /// Whether the section holds so few links that a misfit in it identifies the link.
    #[must_use]
    pub fn is_link(self) -> bool {
        matches!(self, Section::Valve | Section::FlowAndChambers | Section::Mechanics)
    }
}

impl fmt::Display for Section {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Section::EndToEnd => "end to end",
            Section::Valve => "valve",
            Section::BelowSpool => "below spool",
            Section::BelowFlow => "below flow",
            Section::FlowAndChambers => "flow + chambers",
            Section::Mechanics => "mechanics",
        })
    }
}

/// One section of the model, simulated from its measured input.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionFit {
    /// Which.
    pub section: Section,
    /// Where it is driven.
    pub input_point: InputPoint,
    /// The fit of each measured signal that it computes.
    pub fits: Vec<SignalFit>,
    /// RMS error of each of these signals that the noise of the recorded signals driving the section causes, in SI units.
    pub input_noise: Vec<f64>,
    /// How far each of these signals moves by small errors of sensors and parameters; empty where that was not asked ([`open_loop::put_sways`]).
    pub sways: Vec<Option<Sway>>,
    /// What it computed.
    pub trajectory: Trajectory,
}

/// All sections of one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The recording's name.
    pub recording: String,
    /// Time at its beginning that is not judged end to end, s, as it does not begin at rest and not all of its state is measured.
    pub unsettled_s: f64,
    /// Where sensors are at an end of their range; these rows are not judged.
    pub ends: Vec<(Signal, RangeEnd)>,
    /// Sections in the chain's order; the first is end to end.
    pub sections: Vec<SectionFit>,
}

/// One planned section: where it is driven, where its load comes from, which signals it is judged by.
struct PlannedSection {
    section: Section,
    input_point: InputPoint,
    load: LoadSource,
    judged: Vec<Signal>,
}

impl PlannedSection {
    /// Whether it is driven by signals that a sensor has recorded; a command and a pump's speed are set, not measured.
    fn is_driven_by_sensors(&self) -> bool {
        !self.input_point.is_set() || self.load == LoadSource::RecordedPressures
    }
}

/// Simulates every section that the recording allows and compares.
///
/// ```
/// use std::path::Path;
///
/// use identification::compare::{Section, compare};
/// use recording::{ChannelMap, Signal};
/// use simulation::Arithmetic;
///
/// let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../examples/press-63-40");
/// let drive = machine_file::read(&example.join("machine.toml"))?;
/// let recording = recording::read(&example.join("holdout-1.csv"), &ChannelMap::default())?;
///
/// let found = compare(&drive.machine, drive.load_source, &recording, Arithmetic::Fixed, None)?;
/// let fit = |section, signal| {
///     let section = found.sections.iter().find(|known| known.section == section)?;
///     section.fits.iter().find(|fit| fit.signal == signal).map(|fit| fit.nrmse_percent)
/// };
/// // The valve follows; what is below it misses something.
/// assert!(fit(Section::Valve, Signal::Spool) > Some(99.0));
/// assert!(fit(Section::EndToEnd, Signal::Position) < Some(95.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn compare(
    machine: &Machine<f64>,
    load: LoadSource,
    recording: &Recording,
    arithmetic: Arithmetic,
    tick: Option<Tick>,
) -> Result<Comparison, CompareError> {
    compare_with_progress(machine, load, recording, arithmetic, tick, &|_| ())
}

/// As [`compare`], and reports how many more rows have been simulated, of [`rows_simulated`] in all.
pub fn compare_with_progress(
    machine: &Machine<f64>,
    load: LoadSource,
    recording: &Recording,
    arithmetic: Arithmetic,
    tick: Option<Tick>,
    told: &dyn Fn(usize),
) -> Result<Comparison, CompareError> {
    let tick = tick.unwrap_or_else(|| tick_for(recording, machine));
    let mended = Mended::of(recording);
    let mut unsettled_s = 0.0_f64;
    let ends: Vec<(Signal, RangeEnd)> = mended
        .failures
        .iter()
        .flat_map(|(signal, found)| found.ends.iter().map(|end| (*signal, end.clone())))
        .collect();
    let sections = plans(machine.source, load, recording)?
        .into_iter()
        .map(|plan| {
            let simulated = |mended: &Mended<'_>| {
                let stimulus = Stimulus::of_mended(mended, machine, plan.input_point, plan.load, tick)?;
                simulated_from(&stimulus, recording, machine, |offset| {
                    arithmetic.simulate_with_progress(machine, &stimulus, offset, told)
                })
            };
            let (trajectory, unsettled) = simulated(&mended)?;
            let time_s = recording.time_s();
            unsettled_s = unsettled_s.max(time_s[unsettled] - time_s[0]);
            let input_noise = if plan.is_driven_by_sensors() {
                input_noise(&mended, &trajectory, &plan.judged, |mended| Ok(simulated(mended)?.0))?
            } else {
                vec![0.0; plan.judged.len()]
            };
            let fits = plan
                .judged
                .iter()
                .filter_map(|&signal| {
                    let (recorded, simulated) = (recording.signal(signal)?, trajectory.signal(signal)?);
                    let is_judged: Vec<bool> = (0..recorded.len())
                        .map(|row| row >= unsettled && !ends.iter().any(|(of, end)| *of == signal && end.rows[row]))
                        .collect();
                    let judged = |series: &[f64]| kept(series, &is_judged);
                    Some(SignalFit::of(signal, &judged(time_s), &judged(recorded), &judged(simulated)))
                })
                .collect();
            Ok(SectionFit {
                section: plan.section,
                input_point: plan.input_point,
                fits,
                input_noise,
                sways: Vec::new(),
                trajectory,
            })
        })
        .collect::<Result<Vec<_>, CompareError>>()?;
    Ok(Comparison { recording: recording.name().to_owned(), unsettled_s, ends, sections })
}

/// Mean NRMSE fit of each signal end to end, %, over all recordings in which it is judged, in the chain's order.
#[must_use]
pub fn mean_fits(comparisons: &[Comparison]) -> Vec<(Signal, f64)> {
    let mut sums: Vec<(Signal, f64, f64)> = Vec::new();
    for fit in comparisons.iter().filter_map(|comparison| comparison.sections.first()).flat_map(|whole| &whole.fits) {
        match sums.iter_mut().find(|(signal, ..)| *signal == fit.signal) {
            Some((_, sum, count)) => (*sum, *count) = (*sum + fit.nrmse_percent, *count + 1.0),
            None => sums.push((fit.signal, fit.nrmse_percent, 1.0)),
        }
    }
    sums.into_iter().map(|(signal, sum, count)| (signal, sum / count)).collect()
}

/// The values of the rows that are judged.
fn kept(series: &[f64], is_judged: &[bool]) -> Vec<f64> {
    series.iter().zip(is_judged).filter(|(_, is_judged)| **is_judged).map(|(value, _)| *value).collect()
}

/// A simulation, and how many of its first rows are not judged. Where a state at the start is not known, the rod may be off for ever by what it
/// travelled meanwhile: it starts from where it is right afterwards.
pub fn simulated_from(
    stimulus: &Stimulus,
    recording: &Recording,
    machine: &Machine<f64>,
    simulate: impl Fn(StartOffset) -> Result<Trajectory, SimulateError>,
) -> Result<(Trajectory, usize), SimulateError> {
    let unsettled = unsettled_rows(recording.time_s(), &stimulus.start);
    let trajectory = simulate(StartOffset::none())?;
    let (Some(recorded), Some(simulated)) = (recording.signal(Signal::Position), trajectory.signal(Signal::Position))
    else {
        return Ok((trajectory, unsettled));
    };
    if unsettled == 0 {
        return Ok((trajectory, unsettled));
    }
    let mut off_m: Vec<f64> = residual(&recorded[unsettled..], &simulated[unsettled..]).collect();
    let shift_m = median(&mut off_m);
    let within = (0.0..=machine.get(Parameter::Stroke)).contains(&(stimulus.start.position_m + shift_m));
    let offset = StartOffset { shift_m, ..StartOffset::none() };
    Ok((if within { simulate(offset)? } else { trajectory }, unsettled))
}

/// How many rows a comparison simulates in all; 0 where it is not possible.
#[must_use]
pub fn rows_simulated(source: Source, load: LoadSource, recording: &Recording) -> usize {
    let times =
        |plan: &PlannedSection| if plan.is_driven_by_sensors() { 1 + realisations(recording.rows()) } else { 1 };
    recording.rows() * plans(source, load, recording).map_or(0, |plans| plans.iter().map(times).sum())
}

/// Measured signals below a drive input that can be judged; not pressures that are an input, and not the supply pressure.
#[must_use]
pub fn judged(recording: &Recording, input_point: InputPoint, load: LoadSource) -> Vec<Signal> {
    let given = |signal: Signal| match signal {
        Signal::SupplyPressure => true,
        Signal::PressureA | Signal::PressureB | Signal::Force => load == LoadSource::RecordedPressures,
        _ => false,
    };
    computed_below(input_point).iter().copied().filter(|&signal| recording.has(signal) && !given(signal)).collect()
}

fn plans(source: Source, load: LoadSource, recording: &Recording) -> Result<Vec<PlannedSection>, CompareError> {
    let first = first_input_point(source, recording)?;
    let all = judged(recording, first, load);
    if all.is_empty() {
        return Err(CompareError::NothingMeasured { recording: recording.name().to_owned() });
    }
    for &signal in &all {
        recording.check_varies(signal)?;
    }
    let has = |signal| recording.has(signal);
    // A pressure at an end of its sensor's range drives nothing.
    let whole = |signal| {
        let values = recording.signal(signal);
        values.is_some_and(|values| Failures::of(signal, recording.time_s(), values).ends.is_empty())
    };
    let pressures = whole(Signal::PressureA) && whole(Signal::PressureB);
    let motion: Vec<Signal> = [Signal::Position, Signal::Velocity].into_iter().filter(|&signal| has(signal)).collect();
    let feed = match source {
        Source::Valve => has(Signal::Spool).then_some(InputPoint::Spool),
        Source::Pump => has(Signal::PumpSpeed).then_some(InputPoint::Pump),
        Source::Force => None,
    };
    let mut plans = vec![PlannedSection { section: Section::EndToEnd, input_point: first, load, judged: all }];
    let mut add = |section, input_point, load, judged: Vec<Signal>| {
        if !judged.is_empty() {
            plans.push(PlannedSection { section, input_point, load, judged });
        }
    };
    if first == InputPoint::Command && has(Signal::Spool) {
        add(Section::Valve, InputPoint::Command, load, vec![Signal::Spool]);
        add(Section::BelowSpool, InputPoint::Spool, load, judged(recording, InputPoint::Spool, load));
    }
    if has(Signal::Flow) && first != InputPoint::Flow {
        add(Section::BelowFlow, InputPoint::Flow, load, judged(recording, InputPoint::Flow, load));
    }
    if let Some(feed) = feed
        && pressures
    {
        add(Section::FlowAndChambers, feed, LoadSource::RecordedPressures, motion.clone());
    }
    if (pressures || has(Signal::Force)) && load == LoadSource::Constant && first != InputPoint::Force {
        add(Section::Mechanics, InputPoint::Force, LoadSource::Constant, motion);
    }
    Ok(plans)
}
