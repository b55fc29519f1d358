//! Recording → simulation: the core driven by what was recorded.
//!
//! A [`Stimulus`] is a recording on the core's tick grid. [`run`] steps the core over it in any number type and hands out
//! the signals at the recorded rows.

use machine_file::DELAY_LINE;
use model_core::drive::{Drive, DriveInput, DriveState};
use model_core::machine::{Machine, MachineError, Parameter};
use model_core::number::{Field, Number, PerUnit, Real, Scalar};
use model_core::ports::{ChamberState, Flows, Spool};
use recording::Signal;

use crate::initial_state::{Offset, StartOffset, at_start};
use crate::outflow::{Below, Edges};
use crate::sensor_bias::{true_spool, within};
use crate::stimulus::{InputPoint, Stimulus};

/// The model at one recorded row; a signal is computed only when it is requested.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample<'a, N: Scalar> {
    drive: &'a Drive<N>,
    machine: &'a Machine<N::Real>,
    stimulus: &'a Stimulus,
    state: &'a DriveState<N, DELAY_LINE>,
    point: usize,
    /// Position of the row, where it lies before the point.
    since: Option<Since<'a, N::Real>>,
}

/// A row between two points.
#[derive(Clone, Copy, Debug)]
struct Since<'a, R> {
    /// Every signal at the first point.
    before: &'a [(Signal, R)],
    /// Position of the row between the two points, 0..1.
    share: f64,
}

impl<N: Scalar> Sample<'_, N> {
    /// The value of a recorded signal as its sensor reads it, in SI units, if the model computes it.
    #[must_use]
    #[inline]
    pub(crate) fn signal(&self, signal: Signal) -> Option<N::Real> {
        let now = self.at_point(signal)?;
        let Some(Since { before, share }) = self.since else { return Some(now) };
        let (_, before) = before.iter().find(|(known, _)| *known == signal)?;
        Some(*before + (now - *before) * N::Real::constant(share))
    }

    #[inline]
    fn at_point(&self, signal: Signal) -> Option<N::Real> {
        reading(self.drive, self.machine, self.state, signal, || self.spool(), || self.flow_a())
    }

    /// The spool as it is read; a drive that is driven by the spool takes it from the recording.
    fn spool(&self) -> N {
        let recorded = || self.stimulus.metering_at::<N>(self.point);
        let given = if self.stimulus.input_point == InputPoint::Spool { recorded() } else { None };
        given.unwrap_or_else(|| self.drive.sensed(self.state).spool)
    }

    /// Flow into A, computed from the spool that meters the oil.
    fn flow_a(&self) -> N {
        let recorded = self.stimulus.metering_at::<N>(self.point);
        let spool = recorded.map_or_else(|| self.drive.spool(self.state), |reading| true_spool(self.machine, reading));
        let pump = self.stimulus.pump_at(self.point, self.drive.bases());
        self.drive.flows_of(self.state, spool, pump).a
    }
}

/// The value of a recorded signal as its sensor reads it, in SI units, if the model computes it; the caller supplies the
/// spool and the flow into A.
#[inline]
pub(crate) fn reading<N: Number>(
    drive: &Drive<N>,
    machine: &Machine<N::Real>,
    state: &DriveState<N, DELAY_LINE>,
    signal: Signal,
    spool: impl FnOnce() -> N,
    flow_a: impl FnOnce() -> N,
) -> Option<N::Value> {
    let bases = drive.bases();
    let in_si = |reading: N, base: f64| reading.to_real() * N::Value::constant(base);
    let pressure_a = || in_si(drive.sensed(state).pressure_a, bases.pressure_pa);
    let pressure_b = || in_si(drive.sensed(state).pressure_b, bases.pressure_pa);
    let get = |parameter| N::Value::coefficient(machine.get(parameter));
    Some(match signal {
        Signal::Spool => spool().to_real(),
        Signal::SupplyPressure => in_si(state.supply.pressure, bases.pressure_pa),
        Signal::Flow => in_si(flow_a(), bases.flow_m3_per_s),
        Signal::PressureA => pressure_a(),
        Signal::PressureB => pressure_b(),
        Signal::Force => get(Parameter::AreaA) * pressure_a() - get(Parameter::AreaB) * pressure_b(),
        Signal::Velocity => in_si(drive.sensed(state).velocity, bases.velocity_m_per_s),
        Signal::Position => N::strokes(drive.sensed(state).position) * get(Parameter::Stroke),
        _ => return None,
    })
}

/// Signals that the model computes below a drive input, in the model's order. The supply pressure only where the valve draws from it.
#[must_use]
pub fn computed_below(input_point: InputPoint) -> &'static [Signal] {
    const ALL: &[Signal] = &[
        Signal::Spool,
        Signal::SupplyPressure,
        Signal::Flow,
        Signal::PressureA,
        Signal::PressureB,
        Signal::Force,
        Signal::Velocity,
        Signal::Position,
    ];
    match input_point {
        InputPoint::Command => ALL,
        InputPoint::Spool => &ALL[1..],
        InputPoint::Pump => &ALL[2..],
        InputPoint::Flow => &ALL[3..],
        InputPoint::Force => &ALL[6..],
    }
}

/// The signals of a simulation at the recorded rows, in SI units.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Trajectory {
    /// One series for each signal computed below the drive input.
    pub series: Vec<(Signal, Vec<f64>)>,
}

impl Trajectory {
    /// A computed signal.
    #[must_use]
    pub fn signal(&self, signal: Signal) -> Option<&[f64]> {
        self.series.iter().find(|(found, _)| *found == signal).map(|(_, values)| values.as_slice())
    }

    /// No rows of these signals yet, but space for this many.
    pub(crate) fn of(signals: &[Signal], rows: usize) -> Self {
        Self { series: signals.iter().map(|&signal| (signal, Vec::with_capacity(rows))).collect() }
    }

    /// Its number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.series.first().map_or(0, |(_, values)| values.len())
    }

    /// Adds one row.
    pub(crate) fn push(&mut self, value: impl Fn(Signal) -> Option<f64>) {
        for (signal, values) in &mut self.series {
            values.extend(value(*signal));
        }
    }

    /// Its rows from this one to the end.
    pub(crate) fn since(&self, row: usize) -> Self {
        Self { series: self.series.iter().map(|(signal, values)| (*signal, values[row..].to_vec())).collect() }
    }
}

/// Rows of a recording in their order: each lies on a point of the grid, or in the tick before it and is then interpolated between both points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<'a> {
    pub(crate) rows: &'a [(usize, f64)],
    pub(crate) next: usize,
}

impl Rows<'_> {
    /// The next row, if it lies at this point or in the tick before; with its position after the previous point as a share of the tick, 0 where it is
    /// at this point.
    #[inline]
    pub(crate) fn at(&mut self, point: usize) -> Option<(usize, f64)> {
        let &(at, share) = self.rows.get(self.next)?;
        if at + usize::from(share != 0.0) != point {
            return None;
        }
        self.next += 1;
        Some((self.next - 1, share))
    }

    /// Whether the next row lies at this point, or in a tick that this point bounds.
    #[inline]
    pub(crate) fn is_wanted(&self, point: usize) -> bool {
        self.rows.get(self.next).is_some_and(|(at, share)| *at == point || (*share != 0.0 && at + 1 == point))
    }

    /// Whether the next row lies in the tick after this point.
    #[inline]
    pub(crate) fn is_mixed_of(&self, point: usize) -> bool {
        self.rows.get(self.next).is_some_and(|(at, share)| *at == point && *share != 0.0)
    }
}

/// Runs the core over a stimulus and hands each recorded row's sample to `sink`, in order.
pub(crate) fn run<N: Scalar>(
    machine: &Machine<N::Real>,
    stimulus: &Stimulus,
    offset: Offset<N::Real>,
    sink: &mut dyn FnMut(usize, &Sample<'_, N>),
) -> Result<(), MachineError> {
    let machine = &unbraked(machine, stimulus);
    let drive = Drive::<N>::new::<DELAY_LINE>(machine, stimulus.tick)?;
    let mut state = at_start(&drive, machine, &stimulus.start, offset);
    run_on(&drive, machine, stimulus, offset, &mut state, sink);
    Ok(())
}

/// A signal at a row as its sensor reads it, SI; `None` where the model does not compute it.
pub type SignalsOfRow<'a> = dyn Fn(Signal) -> Option<f64> + 'a;

/// Simulates in f64 and hands each recorded row to `sink`, in order, with its signals as their sensors read them, SI:
/// each is computed only when it is requested, and is `None` where the model does not compute it.
pub fn rows_f64(
    machine: &Machine<f64>,
    stimulus: &Stimulus,
    offset: StartOffset,
    sink: &mut dyn FnMut(usize, &SignalsOfRow<'_>),
) -> Result<(), MachineError> {
    run::<f64>(machine, stimulus, offset.lifted(), &mut |row, sample| sink(row, &|signal| sample.signal(signal)))
}

/// The same from a given state; afterwards this holds the state at the end of the stimulus.
pub(crate) fn run_on<N: Scalar>(
    drive: &Drive<N>,
    machine: &Machine<N::Real>,
    stimulus: &Stimulus,
    offset: Offset<N::Real>,
    state: &mut DriveState<N, DELAY_LINE>,
    sink: &mut dyn FnMut(usize, &Sample<'_, N>),
) {
    let bases = *drive.bases();
    let edges = Edges::of(machine, &bases);
    let mut rows = Rows { rows: &stimulus.rows, next: 0 };
    let mut before: Vec<(Signal, N::Real)> = Vec::new();
    for point in 0..=stimulus.ticks {
        if point > 0 {
            let tick = point - 1;
            let drive_input = entered(machine, edges.as_ref(), state, stimulus.drive_input_at(tick, &bases));
            if let Some(flow) = stimulus.others_at(tick, &bases) {
                state.supply.other_flow = N::saturated(flow);
            }
            if let Some(temperature) = stimulus.oil_at(tick, &bases) {
                state.oil_temperature = temperature;
            }
            drive.step(state, drive_input, stimulus.load_at(tick, &bases));
        }
        if let Some(taken_up) = stimulus.taken_up_at(point) {
            taken_up.take(drive, machine, offset, state);
        }
        let now = Sample { drive, machine, stimulus, state, point, since: None };
        while let Some((row, share)) = rows.at(point) {
            sink(row, &Sample { since: (share != 0.0).then_some(Since { before: &before, share }), ..now });
        }
        if rows.is_mixed_of(point) {
            let signals = computed_below(InputPoint::Command).iter();
            before = signals.filter_map(|&signal| Some((signal, now.signal(signal)?))).collect();
        }
    }
}

/// What drives the model, with true values in place of sensor readings.
fn entered<N: Scalar>(
    machine: &Machine<N::Real>,
    edges: Option<&Edges<N::Value>>,
    state: &DriveState<N, DELAY_LINE>,
    drive_input: DriveInput<N>,
) -> DriveInput<N> {
    let true_spool = |Spool { from, to }| Spool { from: true_spool(machine, from), to: true_spool(machine, to) };
    match drive_input {
        DriveInput::Spool(spool) => DriveInput::Spool(true_spool(spool)),
        DriveInput::Followed { command, spool } => DriveInput::Followed { command, spool: true_spool(spool) },
        DriveInput::Flow { from, to } => through_valve(edges, state, (from, to), within),
        other => other,
    }
}

/// The flow drive input, with the flow out of B through the valve's other edge.
pub(crate) fn through_valve<N: Number>(
    edges: Option<&Edges<N::Value>>,
    state: &DriveState<N, DELAY_LINE>,
    (from, to): (Flows<N>, Flows<N>),
    signal: impl Fn(N::Value) -> N,
) -> DriveInput<N> {
    let Some(edges) = edges else { return DriveInput::Flow { from, to } };
    let below = Below {
        pressures: ChamberState { a: state.chambers.a.to_real(), b: state.chambers.b.to_real() },
        velocity: state.motion.velocity.to_real(),
    };
    let (begun, ended) = edges.through((from.a.to_real(), to.a.to_real()), below);
    DriveInput::Flow { from: Flows { b: signal(begun.b), ..from }, to: Flows { b: signal(ended.b), ..to } }
}

/// Forces that a load balancing the recorded pressures already includes: every force on the rod except viscous friction and the constant load.
const BALANCED: [Parameter; 17] = [
    Parameter::CoulombFriction,
    Parameter::StribeckForce,
    Parameter::StribeckExcess,
    Parameter::AsymmetricExtending,
    Parameter::AsymmetricRetracting,
    Parameter::PositionFriction,
    Parameter::PositionFrictionSlope,
    Parameter::PositionFrictionBow,
    Parameter::PositionDragSlope,
    Parameter::PositionDragBow,
    Parameter::PressureFriction,
    Parameter::PreslidingForce,
    Parameter::LoadSpring,
    Parameter::LoadSpringForce,
    Parameter::LoadSpringBow,
    Parameter::StopStiffness,
    Parameter::StopDamping,
];

/// The machine with light damping instead of its friction, where the load balances the recorded pressures.
pub(crate) fn unbraked<R: Real>(machine: &Machine<R>, stimulus: &Stimulus) -> Machine<R> {
    let mut machine = *machine;
    if let Some(damping) = stimulus.damping {
        machine.set(Parameter::ViscousFriction, R::constant(damping));
        for parameter in BALANCED {
            machine.set(parameter, R::ZERO);
        }
        // A table of forces is also included in this load.
        if (machine.get(Parameter::TableQuantity).value() - 1.0).abs() < 0.5 {
            machine.set(Parameter::TableQuantity, R::ZERO);
        }
    }
    machine
}

/// A whole simulation in fixed point, as the controller computes.
///
/// ```
/// use std::path::Path;
///
/// use recording::{ChannelMap, Signal};
/// use simulation::{StartOffset, Stimulus, first_input_point, natural_tick, simulate_fixed};
///
/// let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../examples/press-63-40");
/// let drive = machine_file::read(&example.join("machine.toml"))?;
/// let recording = recording::read(&example.join("holdout-1.csv"), &ChannelMap::default())?;
///
/// let input_point = first_input_point(drive.machine.source, &recording)?; // the command, where it was recorded
/// let tick = natural_tick(&recording);
/// let stimulus = Stimulus::new(&recording, &drive.machine, input_point, drive.load_source, tick)?;
/// let simulated = simulate_fixed(&drive.machine, &stimulus, StartOffset::none())?;
///
/// let position_m = simulated.signal(Signal::Position).expect("the chain computes it");
/// assert_eq!(position_m.len(), recording.rows());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn simulate_fixed(
    machine: &Machine<f64>,
    stimulus: &Stimulus,
    offset: StartOffset,
) -> Result<Trajectory, MachineError> {
    simulate::<PerUnit>(machine, stimulus, offset, &|_| ())
}

/// The same in f64.
pub fn simulate_f64(
    machine: &Machine<f64>,
    stimulus: &Stimulus,
    offset: StartOffset,
) -> Result<Trajectory, MachineError> {
    simulate::<f64>(machine, stimulus, offset, &|_| ())
}

/// Rows between two reports of a simulation: some milliseconds of computing.
const ROWS_TOLD: usize = 4096;

/// A whole simulation; after every few thousand rows it reports to `told` how many more are done.
pub(crate) fn simulate<N: Scalar<Real = f64>>(
    machine: &Machine<f64>,
    stimulus: &Stimulus,
    offset: StartOffset,
    told: &dyn Fn(usize),
) -> Result<Trajectory, MachineError> {
    let mut trajectory = Trajectory::of(computed_below(stimulus.input_point), stimulus.rows());
    run::<N>(machine, stimulus, offset.lifted(), &mut |row, sample| {
        trajectory.push(|signal| sample.signal(signal));
        if (row + 1) % ROWS_TOLD == 0 {
            told(ROWS_TOLD);
        }
    })?;
    told(stimulus.rows() % ROWS_TOLD);
    Ok(trajectory)
}

#[cfg(test)]
mod tests;
