//! Initial state of a run: that of the recording, with the changes that a fit makes to it.

use model_core::drive::{Drive, DriveState};
use model_core::machine::{Bases, Machine, Parameter};
use model_core::number::{Real, Scalar};
use model_core::ports::ChamberState;
use model_core::valve::ValveState;

use crate::recorded_start::Start;
use crate::sensor_bias::{PRESSURE_A, PRESSURE_B, SPOOL, behind, within};
use crate::start_in_motion::SpoolAtStart;

/// Ticks in the delay line on the desktop: more than a quarter of a second at any tick.
pub const DELAY_LINE: usize = 512;

/// Freedom of a run in addition to the recording: what a fit may change in the initial state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartOffset {
    /// Share of supply pressure in chamber B at rest, where pressures are not recorded; `None` for the machine's value.
    pub level: Option<f64>,
    /// Distance of the rod further out than the recorded initial position, m: less than its sensor resolves.
    pub shift_m: f64,
}

impl StartOffset {
    /// The machine's level, and the position as recorded.
    #[must_use]
    pub const fn none() -> Self {
        Self { level: None, shift_m: 0.0 }
    }

    /// The same in the number type of a run.
    pub(crate) fn lifted<R: Real>(self) -> Offset<R> {
        Offset { level: self.level.map(R::constant), shift_m: R::constant(self.shift_m) }
    }
}

/// A [`StartOffset`] in the number type of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Offset<R> {
    pub(crate) level: Option<R>,
    pub(crate) shift_m: R,
}

/// Initial pressures where the recording has none: from the level in B and the balance of forces, viscous friction included.
fn balanced<R: Real>(machine: &Machine<R>, level: R, position_m: R, velocity: R) -> (R, R) {
    let get = |parameter| machine.get(parameter);
    let beyond = position_m - get(Parameter::Stroke) * R::constant(0.5);
    let spring = get(Parameter::LoadSpringForce)
        + beyond * (get(Parameter::LoadSpring) + beyond * get(Parameter::LoadSpringBow));
    let force = get(Parameter::LoadForce) - spring - get(Parameter::ViscousFriction) * velocity;
    let supply = get(Parameter::SupplyPressure);
    let a = (level * supply * get(Parameter::AreaB) - force) / get(Parameter::AreaA);
    let (low, high) = (supply * R::constant(0.02), supply * R::constant(0.98));
    let a = if a < low {
        low
    } else if a > high {
        high
    } else {
        a
    };
    let b = (a * get(Parameter::AreaA) + force) / get(Parameter::AreaB);
    (
        a,
        if b < low {
            low
        } else if b > high {
            high
        } else {
            b
        },
    )
}

/// Where a run starts, per unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InitialState<R> {
    /// Command, in 10 V.
    pub(crate) command: f64,
    pub(crate) pressures: ChamberState<R>,
    pub(crate) strokes: R,
    /// 0 at rest.
    pub(crate) velocity: f64,
    /// The valve, where it has not settled at the command.
    pub(crate) valve: Option<ValveOnItsWay<R>>,
}

/// A valve whose spool is not where the command would hold it after a long time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ValveOnItsWay<R> {
    pub(crate) spool: R,
    /// Output of the first lag, which the spool follows with the second.
    pub(crate) lag: R,
    /// Set value for longer than the delay.
    pub(crate) set: R,
}

impl<R: Real> InitialState<R> {
    pub(crate) fn of(machine: &Machine<R>, bases: &Bases, start: &Start, offset: Offset<R>) -> Self {
        let constant = R::constant;
        let position_m = constant(start.position_m) + offset.shift_m;
        let (a, b) = if let Some((a, b)) = start.pressures_pa {
            (behind(machine, PRESSURE_A, constant(a)), behind(machine, PRESSURE_B, constant(b)))
        } else {
            let level = offset.level.unwrap_or(machine.get(Parameter::LevelAtRest));
            balanced(machine, level, position_m, constant(start.velocity_m_per_s))
        };
        let per_unit = |pressure: R| pressure / constant(bases.pressure_pa);
        Self {
            command: start.command_v / bases.command_v,
            pressures: ChamberState { a: per_unit(a), b: per_unit(b) },
            strokes: position_m / machine.get(Parameter::Stroke),
            velocity: start.velocity_m_per_s / bases.velocity_m_per_s,
            valve: start.spool.map(|spool| ValveOnItsWay::of(machine, spool, start.command_v)),
        }
    }
}

impl<R: Real> ValveOnItsWay<R> {
    /// T2·ẋ = l − x gives the first lag's output l from the slope of the spool x.
    fn of(machine: &Machine<R>, SpoolAtStart { reading, slope_per_s, rests }: SpoolAtStart, command_v: f64) -> Self {
        let spool = behind(machine, SPOOL, R::constant(reading));
        let get = |parameter| machine.get(parameter);
        let target = get(Parameter::ValveGain) * R::constant(command_v) + get(Parameter::ValveOffset);
        Self {
            spool,
            lag: spool + machine.spool_lead_s() * R::constant(slope_per_s),
            set: if rests { spool } else { target },
        }
    }
}

/// The state that a run starts from.
pub(crate) fn at_start<N: Scalar>(
    drive: &Drive<N>,
    machine: &Machine<N::Real>,
    start: &Start,
    offset: Offset<N::Real>,
) -> DriveState<N, DELAY_LINE> {
    let InitialState { command, pressures, strokes, velocity, valve } =
        InitialState::of(machine, drive.bases(), start, offset);
    let pressures = ChamberState { a: within(pressures.a), b: within(pressures.b) };
    let mut state = drive.at_rest(N::saturated(command), pressures, N::travel(strokes));
    state.motion.velocity = N::saturated(velocity);
    if let Some(ValveOnItsWay { spool, lag, set }) = valve {
        state.valve = ValveState::on_its_way(within(spool), within(lag), within(set));
    }
    state
}
