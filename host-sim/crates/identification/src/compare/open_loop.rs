//! How far the outputs of a section move although its physics is complete.
//!
//! A section is driven by recorded signals and never corrected: a position that is integrated from pressures drifts with the smallest offset of their
//! sensors, and with every base parameter that is not known exactly. A misfit of this size says nothing about missing physics. So each of these
//! errors is put in by itself, the section simulated again, and the movements added as independent errors are.

use machine_file::{LoadSource, MachineFile};
use model_core::machine::{Machine, Parameter, Tick};
use recording::{Recording, Signal};
use simulation::sensor_fault::Mended;
use simulation::signal::noise::extent;
use simulation::{Arithmetic, InputPoint, SimulateError, StartOffset, Stimulus, Trajectory, simulate_f64, tick_for};

use super::weakest::needs_sway;
use super::{CompareError, Comparison, PlannedSection, compare_with_progress, plans};
use crate::fit::Free;
use crate::input_noise::off_by;
use crate::parallel;

/// Offset that a good sensor has, as a share of its full scale: 0.25 to 0.5 % in data sheets of pressure transmitters.
pub const SENSOR_OFFSET: f64 = 3e-3;

/// An error that moves the outputs of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mover {
    /// An offset of [`SENSOR_OFFSET`] of this sensor's full scale.
    Offset(Signal),
    /// One standard deviation of this base parameter.
    Parameter(Parameter),
    /// Half the tolerance of this effect parameter.
    Tolerance(Parameter),
}

/// How far one output of a section moves with all of these errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sway {
    /// RMS with all of them as independent errors, SI.
    pub rms: f64,
    /// The error that moves it most.
    pub most: Mover,
    /// RMS with this one alone, SI.
    pub by_most: f64,
}

/// Every recording compared with a machine file's drive ([`compare_with_progress`]), and how far its sections sway ([`put_sways`]).
///
/// # Errors
/// A recording cannot be compared with this drive.
pub fn compare_each(
    file: &MachineFile,
    free: &[Free],
    recordings: &[Recording],
    (arithmetic, tick): (Arithmetic, Option<Tick>),
    told: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Comparison>, CompareError> {
    let (machine, load) = (&file.machine, file.load_source);
    parallel::try_each(recordings, |recording| {
        let mut found = compare_with_progress(machine, load, recording, arithmetic, tick, told)?;
        put_sways(&mut found, machine, load, recording, tick, free)?;
        Ok(found)
    })
}

/// Puts into a comparison how far the outputs of its sections sway, given how far base parameters and tolerances usually are off; only for those
/// that do not follow their recording anyway.
pub fn put_sways(
    comparison: &mut Comparison,
    machine: &Machine<f64>,
    load: LoadSource,
    recording: &Recording,
    tick: Option<Tick>,
    free: &[Free],
) -> Result<(), CompareError> {
    let tick = tick.unwrap_or_else(|| tick_for(recording, machine));
    let mended = Mended::of(recording);
    for (section, plan) in comparison.sections.iter_mut().zip(plans(machine.source, load, recording)?) {
        if needs_sway(section) {
            section.sways = sways(&plan, machine, &mended, tick, free)?;
        }
    }
    Ok(())
}

/// How far each judged output of a section sways.
fn sways(
    plan: &PlannedSection,
    machine: &Machine<f64>,
    mended: &Mended<'_>,
    tick: Tick,
    free: &[Free],
) -> Result<Vec<Option<Sway>>, CompareError> {
    let simulated = |machine: &Machine<f64>, mended: &Mended<'_>| -> Result<Trajectory, SimulateError> {
        let stimulus = Stimulus::of_mended(mended, machine, plan.input_point, plan.load, tick)?;
        Ok(simulate_f64(machine, &stimulus, StartOffset::none())?)
    };
    let usual = simulated(machine, mended)?;
    let offsets = drivers(plan).into_iter().filter(|signal| mended.recording.has(*signal)).map(Mover::Offset);
    let parameters = free.iter().map(|free| match free.tolerance() {
        Some(_) => Mover::Tolerance(free.parameter),
        None => Mover::Parameter(free.parameter),
    });
    let movers: Vec<Mover> = offsets.chain(parameters).collect();
    let moved = parallel::each(&movers, |mover| {
        let again = match *mover {
            Mover::Offset(signal) => simulated(machine, &offset(mended, machine, signal)),
            Mover::Parameter(parameter) | Mover::Tolerance(parameter) => {
                let own = machine.get(parameter);
                let known = free.iter().find(|free| free.parameter == parameter);
                let [above, below] = known.map_or([own; 2], Free::usually_off);
                let moved = |value: f64| simulated(&machine.with(&[(parameter, value)]), mended);
                // A value above may give no drive.
                moved(above).or_else(|_| moved(below))
            }
        };
        // A value that gives no drive moves nothing.
        again.map_or_else(
            |_| Ok(vec![0.0; plan.judged.len()]),
            |again| off_by(&usual, &plan.judged, 1, |_| Ok(again.clone())),
        )
    });
    let moved = moved.into_iter().collect::<Result<Vec<Vec<f64>>, CompareError>>()?;
    let of_signal = |index: usize| {
        let each = || movers.iter().zip(moved.iter().map(|moved| moved[index]));
        let (most, by_most) = each().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let rms = each().map(|(_, rms)| rms * rms).sum::<f64>().sqrt();
        Some(Sway { rms, most: *most, by_most })
    };
    Ok((0..plan.judged.len()).map(of_signal).collect())
}

/// The sensors that drive a section.
fn drivers(plan: &PlannedSection) -> Vec<Signal> {
    let pressures = [Signal::PressureA, Signal::PressureB];
    let mut found = match plan.input_point {
        InputPoint::Force => [&[Signal::Force][..], &pressures].concat(),
        set if set.is_set() => Vec::new(),
        measured => vec![measured.driving()],
    };
    if plan.load == LoadSource::RecordedPressures {
        found.extend(pressures);
    }
    found
}

/// A recording with an offset of one sensor.
fn offset<'a>(mended: &Mended<'a>, machine: &Machine<f64>, signal: Signal) -> Mended<'a> {
    let mut moved = mended.clone();
    if let Some(values) = mended.recording.signal(signal) {
        let by = SENSOR_OFFSET * full_scale(machine, signal, values);
        let values: Vec<f64> = values.iter().map(|value| value + by).collect();
        moved.recording.to_mut().replace(signal, &values);
    }
    moved
}

/// What a sensor measures at least: the supply pressure, the whole travel of the spool, the largest value otherwise.
fn full_scale(machine: &Machine<f64>, signal: Signal, values: &[f64]) -> f64 {
    let (low, high) = extent(values);
    match signal {
        Signal::PressureA | Signal::PressureB => machine.get(Parameter::SupplyPressure).max(high),
        Signal::Spool => 1.0,
        _ => low.abs().max(high.abs()),
    }
}
