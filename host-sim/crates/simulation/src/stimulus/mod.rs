//! A recording on the core's grid: where and by which signals it drives the model, and from which initial state.

mod added_force;
pub(crate) mod coarse;
pub(crate) mod held;
mod load_balance;
mod running_sum;

use std::sync::Arc;

use held::Held;
use load_balance::{balance, light_damping, pressure_force};

use machine_file::{LoadSource, carried};
use model_core::drive::{DriveInput, Load};
use model_core::flow::PumpDrive;
use model_core::machine::{Bases, Machine, Parameter, Source, Tick};
use model_core::number::{Number, Scalar};
use model_core::ports::{Flows, Spool};
use recording::{Recording, Signal};

use crate::error::SimulateError;
use crate::grid::{Grid, Origin, is_sparse};
use crate::recorded_start::{Start, start};
use crate::sensor_fault::Mended;
use crate::taken_up::TakenUp;
use crate::whitening::Whitening;

pub use crate::input_point::InputPoint;
pub use running_sum::RunningSum;

/// What drives the model, one value per grid point (`ticks + 1` of them) or per tick (`ticks`), in SI units.
#[derive(Clone, Debug, PartialEq)]
enum Input {
    /// Held over each tick, V.
    Command(Vec<f64>),
    /// At grid points, 1.
    Spool(Vec<f64>),
    /// Mean speed (rev/s) and direction over each tick.
    Pump(Vec<f64>, Vec<i8>),
    /// At grid points, m³/s, and Ab/Aa.
    Flow(Vec<f64>, f64),
    /// At grid points, N.
    Force(Vec<f64>),
}

/// A recording on the core's grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Stimulus {
    /// Where it drives the model.
    pub input_point: InputPoint,
    /// The core's tick.
    pub tick: Tick,
    /// State at the first row.
    pub start: Start,
    pub(crate) ticks: usize,
    input: Input,
    /// At grid points, 1: the recorded spool, where the command drives the model. It could meter the oil in place of the
    /// simulated spool. Copies of a stimulus share it.
    spool: Option<Arc<[f64]>>,
    /// Whether it meters the oil while the valve is simulated as well.
    follows: bool,
    /// External force at grid points, N.
    load_n: Option<Vec<f64>>,
    /// Flow that other consumers take from the same supply at grid points, m³/s.
    other_flow: Option<Vec<f64>>,
    /// Temperature of the oil at grid points, °C. It is an input, including its sensor's noise: so slow a signal needs no smoothing.
    oil_c: Option<Vec<f64>>,
    /// Viscous friction, N s/m, that replaces all friction of the machine where the load balances the recorded pressures:
    /// these already contain the machine's friction.
    pub(crate) damping: Option<f64>,
    /// For each recorded row: the grid point at or before it, and its position towards the next point, 0..1.
    pub(crate) rows: Vec<(usize, f64)>,
    /// Where what signals gain is judged in place of what they are.
    pub(crate) whitening: Option<Whitening>,
    /// Where runs of it are held near the recording.
    held: Option<Held>,
}

/// The drive input furthest upstream that a recording allows for a machine's source. Where nothing else drives it, both chamber pressures are the force.
pub fn first_input_point(source: Source, recording: &Recording) -> Result<InputPoint, SimulateError> {
    let has = |signal| recording.has(signal);
    let has_force = has(Signal::Force) || (has(Signal::PressureA) && has(Signal::PressureB));
    let candidates: &[(InputPoint, bool)] = match source {
        Source::Valve => &[
            (InputPoint::Command, has(Signal::Command)),
            (InputPoint::Spool, has(Signal::Spool)),
            (InputPoint::Flow, has(Signal::Flow)),
            (InputPoint::Force, has_force),
        ],
        Source::Pump => &[
            (InputPoint::Pump, has(Signal::PumpSpeed)),
            (InputPoint::Flow, has(Signal::Flow)),
            (InputPoint::Force, has_force),
        ],
        Source::Force => &[(InputPoint::Force, has_force)],
    };
    let expected = match source {
        Source::Valve => "command, spool, flow, force or both chamber pressures",
        Source::Pump => "pump_speed, flow, force or both chamber pressures",
        Source::Force => "force or both chamber pressures, for the machine file has neither [valve] nor [pump]",
    };
    let found = candidates.iter().find(|(_, there)| *there).map(|(input_point, _)| *input_point);
    found.ok_or_else(|| SimulateError::NoInput { recording: recording.name().to_owned(), expected })
}

/// Whether both chamber pressures are the force that drives the model, since nothing else that could drive it is recorded.
#[must_use]
pub fn is_driven_by_pressures(source: Source, recording: &Recording) -> bool {
    first_input_point(source, recording) == Ok(InputPoint::Force) && !recording.has(Signal::Force)
}

/// The tick that suits a recording: 1 ms, or 0.5 ms where it is sampled faster than 1 kHz.
#[must_use]
pub fn natural_tick(recording: &Recording) -> Tick {
    if recording.sample_interval_s() < 0.75e-3 { Tick::HalfMillisecond } else { Tick::OneMillisecond }
}

/// The tick that suits a recording of this machine: as [`natural_tick`], 2 ms where the rows are sparse, and a shorter one where the step does not
/// compute the machine at that.
#[must_use]
pub fn tick_for(recording: &Recording, machine: &Machine<f64>) -> Tick {
    let natural = natural_tick(recording);
    let sparse = is_sparse(recording.time_s()).then_some(Tick::TwoMilliseconds);
    let mut ticks = sparse.into_iter().chain([natural, Tick::HalfMillisecond]);
    ticks.find(|tick| is_carried(machine, *tick)).unwrap_or(natural)
}

/// Whether the step computes the machine at this tick.
#[must_use]
pub fn is_carried(machine: &Machine<f64>, tick: Tick) -> bool {
    carried(machine, tick).is_ok()
}

impl Stimulus {
    /// Puts a recording on the grid of `tick`; where a sensor that drives the model failed, by a straight line.
    pub fn new(
        recording: &Recording,
        machine: &Machine<f64>,
        input_point: InputPoint,
        load: LoadSource,
        tick: Tick,
    ) -> Result<Self, SimulateError> {
        Self::of_mended(&Mended::of(recording), machine, input_point, load, tick)
    }

    /// Puts a mended recording on the grid of `tick`.
    pub fn of_mended(
        mended: &Mended<'_>,
        machine: &Machine<f64>,
        input_point: InputPoint,
        load: LoadSource,
        tick: Tick,
    ) -> Result<Self, SimulateError> {
        Self::from_origin(mended, machine, input_point, load, tick, Origin::of(&mended.recording))
    }

    /// Puts a part of a mended recording on the grid of the whole.
    pub(crate) fn from_origin(
        mended: &Mended<'_>,
        machine: &Machine<f64>,
        input_point: InputPoint,
        load: LoadSource,
        tick: Tick,
        origin: Origin,
    ) -> Result<Self, SimulateError> {
        let recording = &*mended.recording;
        let grid = Grid::new(recording, tick, origin)?;
        let need = |signal, reason| {
            recording.signal(signal).ok_or_else(|| SimulateError::Missing {
                recording: recording.name().to_owned(),
                signal,
                reason,
            })
        };
        let input = match input_point {
            InputPoint::Command => Input::Command(grid.held(need(Signal::Command, "the command drives the model")?)),
            InputPoint::Spool => Input::Spool(grid.points(need(Signal::Spool, "the spool drives the model")?)),
            InputPoint::Flow => Input::Flow(
                grid.points(need(Signal::Flow, "the flow drives the model")?),
                machine.get(Parameter::AreaB) / machine.get(Parameter::AreaA),
            ),
            InputPoint::Pump => {
                let speed = grid.points(need(Signal::PumpSpeed, "the pump drives the model")?);
                let mean: Vec<f64> = speed.windows(2).map(|pair| f64::midpoint(pair[0], pair[1])).collect();
                let direction = match recording.signal(Signal::ValveDirection) {
                    Some(direction) => grid.held(direction).iter().map(|&value| sign(value)).collect(),
                    None => mean.iter().map(|&value| sign(value)).collect(),
                };
                Input::Pump(mean, direction)
            }
            InputPoint::Force => Input::Force(match recording.signal(Signal::Force) {
                Some(force) => grid.points(force),
                None => grid.points(&pressure_force(recording, machine)?),
            }),
        };
        let spool = recording.signal(Signal::Spool).filter(|_| input_point == InputPoint::Command);
        let spool = spool.map(|spool| grid.points(spool).into());
        let balanced = load == LoadSource::RecordedPressures && input_point != InputPoint::Force;
        let damping = balanced.then(|| light_damping(machine, tick));
        let load_n = if let Some(damping) = damping {
            let balance = balance(recording, machine, damping)?;
            Some(grid.points(&balance))
        } else {
            recording.signal(Signal::LoadForce).map(|force| grid.points(force))
        };
        let start = start(mended, machine, input_point);
        let other_flow = other_flow(recording).map(|flow| grid.points(&flow));
        let load_at_start_n = load_n.as_ref().and_then(|load_n| load_n.first()).copied();
        Ok(Self {
            input_point,
            tick,
            start: Start {
                load_n: load_at_start_n.unwrap_or(start.load_n),
                other_flow_m3_per_s: other_flow.as_ref().and_then(|flow| flow.first()).copied().unwrap_or_default(),
                ..start
            },
            ticks: grid.ticks,
            input,
            spool,
            follows: false,
            load_n,
            other_flow,
            oil_c: recording.signal(Signal::OilTemperature).map(|temperature| grid.points(temperature)),
            damping,
            rows: grid.rows,
            whitening: None,
            held: None,
        })
    }

    /// What a run takes from the recording at this point of the grid.
    pub(crate) fn taken_up_at(&self, point: usize) -> Option<&TakenUp> {
        let at_start = || self.start.taken_up.as_ref().filter(|taken_up| taken_up.point(self.tick) == point);
        self.held.as_ref().and_then(|held| held.at(point, self.tick)).or_else(at_start)
    }

    /// Mean recorded temperature of the oil, °C; `None` where it was not recorded.
    #[must_use]
    pub fn mean_oil_c(&self) -> Option<f64> {
        let recorded = self.oil_c.as_ref().filter(|recorded| !recorded.is_empty())?;
        Some(recorded.iter().sum::<f64>() / recorded.len() as f64)
    }

    /// Ends it at the last grid point at or before the last of this many rows; rows between this point and the next are then left out.
    pub(crate) fn end_at(&mut self, rows: usize) {
        let Some(&(last, _)) = self.rows[..rows.min(self.rows.len())].last() else { return };
        self.ticks = last;
        let kept = self.rows.partition_point(|(point, share)| point + usize::from(*share > 0.0) <= last);
        self.rows.truncate(kept.min(rows));
    }

    /// The same with the recorded spool metering the oil, while the command still moves the valve: a misfit of the valve then
    /// changes nothing below it. `None` where the command does not drive the model, or the spool was not recorded.
    #[must_use]
    pub fn following(&self) -> Option<Self> {
        self.spool.is_some().then(|| Self { follows: true, ..self.clone() })
    }

    /// The same with an added sensor error of the signal that drives what is below it (the recorded spool where the command moves the valve as
    /// well; otherwise the spool, flow or force that drives the model). The error is drawn for every row and is linear in between.
    #[must_use]
    pub fn disturbed(&self, error: impl FnMut() -> f64) -> Self {
        let mut disturbed = self.clone();
        match &mut disturbed.input {
            Input::Spool(series) | Input::Flow(series, _) | Input::Force(series) => disturb(series, &self.rows, error),
            Input::Command(_) | Input::Pump(..) => {
                disturbed.spool = self.spool.as_ref().map(|spool| {
                    let mut spool = spool.to_vec();
                    disturb(&mut spool, &self.rows, error);
                    spool.into()
                });
            }
        }
        disturbed
    }

    /// The same, of which runs yield what signals gain in place of what they are.
    #[must_use]
    pub fn whitened(&self, whitening: Whitening) -> Self {
        Self { whitening: Some(whitening), ..self.clone() }
    }

    /// Whether runs of it yield what signals gain.
    #[must_use]
    pub fn is_whitened(&self) -> bool {
        self.whitening.is_some()
    }

    /// The same with every row read half a row's interval earlier: midway between two recorded rows.
    #[must_use]
    pub fn midway(&self) -> Self {
        let place = |&(point, share): &(usize, f64)| point as f64 + share;
        let mut rows = Vec::with_capacity(self.rows.len());
        let mut before = self.rows.first().map_or(0.0, place);
        for row in &self.rows {
            let at = f64::midpoint(before, place(row));
            before = place(row);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "between two points of the grid"
            )]
            let point = at as usize;
            rows.push((point, at - point as f64));
        }
        Self { rows, ..self.clone() }
    }

    /// Whether both drive the model at the same input point and at the same tick, so that they can be run in SIMD lanes. Pump
    /// drives cannot: the direction of the pump's valve may differ between them.
    pub(crate) fn goes_with(&self, other: &Self) -> bool {
        let ratio = |one: &Self| if let Input::Flow(_, ratio) = &one.input { Some(*ratio) } else { None };
        let kind = |one: &Self| (one.input_point, one.tick, one.follows, one.damping, ratio(one));
        self.input_point != InputPoint::Pump && kind(self) == kind(other)
    }

    /// The recorded spool, where it meters the oil while the command moves the valve.
    fn followed(&self) -> Option<&[f64]> {
        if self.follows { self.spool.as_deref() } else { None }
    }

    /// Whether its load is what balances the recorded pressures, so that no other force acts.
    #[must_use]
    pub fn is_balanced(&self) -> bool {
        self.damping.is_some()
    }

    /// Number of rows of the recording.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows.len()
    }

    /// Number of ticks of a run.
    #[must_use]
    pub fn ticks(&self) -> usize {
        self.ticks
    }

    /// Where and with what the model is driven in a tick. `read` gives the value of a series at a grid point over a base.
    pub(crate) fn drive_input_by<N: Number>(
        &self,
        tick: usize,
        bases: &Bases,
        read: impl Fn(fn(&Self) -> &[f64], usize, f64) -> N,
    ) -> DriveInput<N> {
        let at = |base: f64| read(Self::driving, tick, base);
        let next = |base: f64| read(Self::driving, tick + 1, base);
        match &self.input {
            Input::Command(_) if self.follows => {
                let spool = Spool { from: read(Self::spool, tick, 1.0), to: read(Self::spool, tick + 1, 1.0) };
                DriveInput::Followed { command: at(bases.command_v), spool }
            }
            Input::Command(_) => DriveInput::Command(at(bases.command_v)),
            Input::Spool(_) => DriveInput::Spool(Spool { from: at(1.0), to: next(1.0) }),
            Input::Pump(_, direction) => DriveInput::Pump(PumpDrive {
                speed: at(bases.pump_speed_rev_per_s),
                direction: direction.get(tick).copied().unwrap_or(0),
            }),
            Input::Flow(_, ratio) => {
                let base = bases.flow_m3_per_s;
                DriveInput::Flow {
                    from: Flows { a: at(base), b: at(base / ratio) },
                    to: Flows { a: next(base), b: next(base / ratio) },
                }
            }
            Input::Force(_) => DriveInput::Force { from: at(bases.force_n), to: next(bases.force_n) },
        }
    }

    /// The same for one recording.
    pub(crate) fn drive_input_at<N: Scalar>(&self, tick: usize, bases: &Bases) -> DriveInput<N> {
        self.drive_input_by(tick, bases, |series, index, base| N::saturated(value_at(series(self), index) / base))
    }

    /// The values that drive the model, tick by tick.
    #[must_use]
    pub fn driving(&self) -> &[f64] {
        match &self.input {
            Input::Command(series)
            | Input::Spool(series)
            | Input::Pump(series, _)
            | Input::Flow(series, _)
            | Input::Force(series) => series,
        }
    }

    /// The recorded spool in addition to a command.
    fn spool(&self) -> &[f64] {
        self.spool.as_deref().unwrap_or_default()
    }

    /// External force, N; empty where there is none.
    pub(crate) fn load(&self) -> &[f64] {
        self.load_n.as_deref().unwrap_or_default()
    }

    pub(crate) fn load_at<N: Scalar>(&self, tick: usize, bases: &Bases) -> Load<N> {
        let at = |index: usize| N::saturated(value_at(self.load(), index) / bases.force_n);
        if self.load_n.is_some() { Load { from: at(tick), to: at(tick + 1) } } else { Load::NONE }
    }

    /// Whether it is recorded what other consumers take from the same supply.
    #[must_use]
    pub fn knows_others(&self) -> bool {
        self.other_flow.is_some()
    }

    /// Mean flow that other consumers take over a tick, per unit; `None` where none is recorded.
    pub(crate) fn others_at(&self, tick: usize, bases: &Bases) -> Option<f64> {
        let flow = self.other_flow.as_ref()?;
        Some(f64::midpoint(value_at(flow, tick), value_at(flow, tick + 1)) / bases.flow_m3_per_s)
    }

    /// Measured temperature of the oil at the start of a tick, per unit.
    pub(crate) fn oil_at<N: Scalar>(&self, tick: usize, bases: &Bases) -> Option<N> {
        let measured = self.oil_c.as_ref().and_then(|oil_c| oil_c.get(tick));
        measured.map(|temperature_c| N::saturated(temperature_c / bases.temperature_c))
    }

    pub(crate) fn pump_at<N: Scalar>(&self, tick: usize, bases: &Bases) -> PumpDrive<N> {
        match self.drive_input_at(tick, bases) {
            DriveInput::Pump(pump) => pump,
            _ => PumpDrive { speed: N::ZERO, direction: 0 },
        }
    }

    /// The recorded spool that meters the oil.
    pub(crate) fn metering_at<N: Scalar>(&self, point: usize) -> Option<N> {
        let spool = match &self.input {
            Input::Spool(spool) => Some(spool.as_slice()),
            _ => self.followed(),
        };
        spool.and_then(|spool| spool.get(point)).map(|&value| N::saturated(value))
    }
}

/// Adds an error to a series at grid points, drawn for every row and linear in between.
fn disturb(series: &mut [f64], rows: &[(usize, f64)], mut error: impl FnMut() -> f64) {
    let errors: Vec<f64> = rows.iter().map(|_| error()).collect();
    for (rows, errors) in rows.windows(2).zip(errors.windows(2)) {
        let (from, to) = (rows[0].0, rows[1].0);
        for (index, value) in series.iter_mut().enumerate().take(to).skip(from) {
            *value += errors[0] + (errors[1] - errors[0]) * (index - from) as f64 / (to - from) as f64;
        }
    }
}

/// What all other consumers together take from the supply, row by row, whichever way they move, m³/s; `None` where none is recorded.
fn other_flow(recording: &Recording) -> Option<Vec<f64>> {
    let recorded = Signal::OTHER_FLOWS.iter().filter_map(|&signal| recording.signal(signal));
    let sizes = recorded.map(|flow| flow.iter().map(|flow| flow.abs()).collect::<Vec<_>>());
    sizes.reduce(|sum, one| sum.iter().zip(&one).map(|(sum, one)| sum + one).collect())
}

/// A series at a grid point; 0 beyond its end.
#[inline]
pub(crate) fn value_at(series: &[f64], index: usize) -> f64 {
    series.get(index).copied().unwrap_or(0.0)
}

/// The direction of a valve: 1, −1 or 0.
pub(crate) fn sign(value: f64) -> i8 {
    if value > 0.5e-9 {
        1
    } else if value < -0.5e-9 {
        -1
    } else {
        0
    }
}
