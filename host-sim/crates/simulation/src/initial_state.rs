//! Initial state of a run: that of the recording, with the changes that a fit makes to it.

use machine_file::DELAY_LINE;
use model_core::drive::{Drive, DriveState};
use model_core::machine::{Bases, Machine, Parameter, Source};
use model_core::number::{Real, Scalar};
use model_core::ports::ChamberState;
use model_core::valve::ValveState;

use crate::recorded_start::Start;
use crate::sensor_bias::{PRESSURE_A, PRESSURE_B, SPOOL, behind, within};
use crate::start_in_motion::SpoolAtStart;

/// Freedom of a run in addition to the recording: what a fit may change in the initial state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartOffset {
    /// Share of supply pressure in chamber B at rest, where pressures are not recorded; `None` for the machine's value.
    pub level: Option<f64>,
    /// Distance of the rod further out than the recorded initial position, m: less than its sensor resolves, or within the play behind it.
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

/// Initial pressures where the recording has none: from the level in B and the balance of forces, viscous friction and a measured load included.
/// 0 where a force moves the mass.
fn balanced<R: Real>(machine: &Machine<R>, level: R, position_m: R, start: &Start) -> (R, R) {
    if machine.source == Source::Force {
        return (R::ZERO, R::ZERO);
    }
    let get = |parameter| machine.get(parameter);
    let force = around(machine, position_m, start);
    let supply = get(Parameter::SupplyPressure);
    let a = (level * supply * get(Parameter::AreaB) - force) / get(Parameter::AreaA);
    let (low, high) = (supply * R::constant(0.02), supply * R::constant(0.98));
    let a = limited(a, low, high);
    let b = (a * get(Parameter::AreaA) + force) / get(Parameter::AreaB);
    (a, limited(b, low, high))
}

/// The force on the rod without the pressures and dry friction, N; positive extends.
fn external<R: Real>(machine: &Machine<R>, position_m: R, velocity: R) -> R {
    let get = |parameter| machine.get(parameter);
    let beyond = position_m - get(Parameter::Stroke) * R::constant(0.5);
    let spring = get(Parameter::LoadSpringForce)
        + beyond * (get(Parameter::LoadSpring) + beyond * get(Parameter::LoadSpringBow));
    get(Parameter::LoadForce) - spring - get(Parameter::ViscousFriction) * velocity
}

/// The force on the rod without the pressures and dry friction as a recording starts, a measured load included, N.
fn around<R: Real>(machine: &Machine<R>, position_m: R, start: &Start) -> R {
    external(machine, position_m, R::constant(start.velocity_m_per_s)) + R::constant(start.load_n)
}

/// The force on the rod without dry friction, N; positive extends.
fn surplus<R: Real>(machine: &Machine<R>, (a, b): (R, R), position_m: R, start: &Start) -> R {
    let hydraulic = a * machine.get(Parameter::AreaA) - b * machine.get(Parameter::AreaB);
    hydraulic + around(machine, position_m, start)
}

fn limited<R: Real>(value: R, low: R, high: R) -> R {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

/// The part of a shift of the rod that is its place within the play behind its sensor, m.
pub(crate) fn beside<R: Real>(machine: &Machine<R>, shift_m: R) -> R {
    let play = machine.get(Parameter::BacklashPlay);
    // Without a play a shift of 0 is none of its places, nor are those beside it.
    if play.is_nil() {
        return R::ZERO;
    }
    let half_play = play * R::constant(0.5);
    limited(shift_m, -half_play, half_play)
}

/// Where a run starts, per unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InitialState<R> {
    /// Command, in 10 V.
    pub(crate) command: f64,
    pub(crate) pressures: ChamberState<R>,
    pub(crate) strokes: R,
    /// What the position's sensor shows, strokes: where the rod stands, but for its place within a play.
    pub(crate) shown: R,
    /// What the position's sensor reads beyond that, strokes: of a rod in motion, the lag's output is behind.
    pub(crate) sensed_beyond: R,
    /// 0 at rest.
    pub(crate) velocity: f64,
    /// Force of the bristles, in shares of their reference: what the measured pressures and the load leave, for the seals hold that. A rod that stands
    /// between unequal forces would otherwise start with a jerk.
    pub(crate) bristles: R,
    /// By how much what other consumers take has brought the supply down.
    pub(crate) fallen: R,
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
        let reading_m = constant(start.position_m) + offset.shift_m;
        let beside_m = beside(machine, offset.shift_m);
        let behind_m = constant(start.velocity_m_per_s) * machine.get(Parameter::PositionLag);
        let position_m = reading_m + behind_m;
        let (a, b) = if let Some((a, b)) = start.pressures_pa {
            (behind(machine, PRESSURE_A, constant(a)), behind(machine, PRESSURE_B, constant(b)))
        } else {
            let level = offset.level.unwrap_or(machine.get(Parameter::LevelAtRest));
            balanced(machine, level, position_m, start)
        };
        let per_unit = |pressure: R| pressure / constant(bases.pressure_pa);
        let bristles = if start.pressures_pa.is_some() && machine.has_bristles(bases) {
            let left = surplus(machine, (a, b), position_m, start);
            limited(left / constant(machine.largest_friction_n(bases)), constant(-1.0), constant(1.0))
        } else {
            R::ZERO
        };
        let taken = if machine.source == Source::Valve { start.other_flow_m3_per_s } else { 0.0 };
        let fallen = machine.get(Parameter::DroopResistance) * constant(taken);
        let fallen = limited(fallen, R::ZERO, machine.get(Parameter::SupplyPressure));
        Self {
            bristles,
            fallen: per_unit(fallen),
            command: start.command_v / bases.command_v,
            pressures: ChamberState { a: per_unit(a), b: per_unit(b) },
            strokes: position_m / machine.get(Parameter::Stroke),
            shown: (position_m - beside_m) / machine.get(Parameter::Stroke),
            sensed_beyond: -behind_m / machine.get(Parameter::Stroke),
            velocity: start.velocity_m_per_s / bases.velocity_m_per_s,
            valve: match (start.spool, start.settled) {
                (Some(spool), _) => Some(ValveOnItsWay::of(machine, spool, start.command_v)),
                (None, Some(reading)) => ValveOnItsWay::settled(machine, reading, start.command_v),
                (None, None) => None,
            },
        }
    }
}

impl<R: Real> ValveOnItsWay<R> {
    /// T2·ẋ = l − x gives the first lag's output l from the slope of the spool x.
    fn of(machine: &Machine<R>, SpoolAtStart { reading, slope_per_s, rests }: SpoolAtStart, command_v: f64) -> Self {
        let spool = behind(machine, SPOOL, R::constant(reading));
        // What is wound up in the hysteresis trails the command.
        let half = half_hysteresis(machine);
        let trailing = if slope_per_s < 0.0 { half } else { -half };
        Self {
            spool,
            lag: spool + machine.spool_lead_s() * R::constant(slope_per_s),
            set: if rests { spool } else { target(machine, command_v) + trailing },
        }
    }

    /// A spool that rests within the hysteresis about the command's target; `None` without hysteresis.
    fn settled(machine: &Machine<R>, reading: f64, command_v: f64) -> Option<Self> {
        let half = half_hysteresis(machine);
        if half.is_nil() {
            return None;
        }
        let target = target(machine, command_v);
        let spool = limited(behind(machine, SPOOL, R::constant(reading)), target - half, target + half);
        Some(Self { spool, lag: spool, set: spool })
    }
}

/// How far the spool may be from where the command would hold it without hysteresis.
fn half_hysteresis<R: Real>(machine: &Machine<R>) -> R {
    R::constant(0.5) * machine.get(Parameter::HysteresisWidth)
}

/// Where the command holds the spool in the end, without hysteresis.
fn target<R: Real>(machine: &Machine<R>, command_v: f64) -> R {
    machine.get(Parameter::ValveGain) * R::constant(command_v) + machine.get(Parameter::ValveOffset)
}

/// The state that a run starts from.
pub(crate) fn at_start<N: Scalar>(
    drive: &Drive<N>,
    machine: &Machine<N::Real>,
    start: &Start,
    offset: Offset<N::Real>,
) -> DriveState<N, DELAY_LINE> {
    let InitialState { command, pressures, strokes, shown, sensed_beyond, velocity, bristles, fallen, valve } =
        InitialState::of(machine, drive.bases(), start, offset);
    let pressures = ChamberState { a: within(pressures.a), b: within(pressures.b) };
    let mut state = drive.at_rest(N::saturated(command), pressures, N::travel(strokes));
    state.motion.velocity = N::saturated(velocity);
    state.motion.bristles = within(bristles);
    state.supply.pressure = state.supply.pressure - within(fallen);
    if !machine.get(Parameter::BacklashPlay).is_nil() {
        state.sensed.show(within(shown));
    }
    if velocity != 0.0 {
        state.sensed.trail(within(sensed_beyond));
    }
    if let Some(ValveOnItsWay { spool, lag, set }) = valve {
        state.valve = ValveState::on_its_way(within(spool), within(lag), within(set));
    }
    state
}

#[cfg(test)]
mod tests {
    use machine_file::LoadSource;
    use model_core::machine::Tick;
    use recording::{Column, Recording, Signal};
    use test_press::with_papers_valve;

    use super::*;
    use crate::run::simulate_f64;
    use crate::stimulus::Stimulus;
    use crate::{InputPoint, Trajectory};

    /// A quarter of a second at no command, from a first row with these readings.
    fn held(machine: &Machine<f64>, readings: &[(Signal, f64)]) -> Trajectory {
        let time_s: Vec<f64> = (0..250).map(|row| f64::from(row) * 1e-3).collect();
        let constant = |signal, value| Column::si(signal, vec![value; time_s.len()]);
        let mut columns = vec![Column::si(Signal::Time, time_s.clone()), constant(Signal::Command, 0.0)];
        columns.extend(readings.iter().map(|&(signal, value)| constant(signal, value)));
        let recording = Recording::new("held", columns).unwrap();
        let (command, load) = (InputPoint::Command, LoadSource::Constant);
        let stimulus = Stimulus::new(&recording, machine, command, load, Tick::OneMillisecond).unwrap();
        simulate_f64(machine, &stimulus, StartOffset::none()).unwrap()
    }

    #[test]
    fn seals_hold_a_rod_that_stands_between_unequal_forces_from_the_first_tick() {
        let seals = [(Parameter::CoulombFriction, 400.0), (Parameter::PreslidingStiffness, 1e7)];
        let machine = with_papers_valve().with(&seals);
        // 300 N more than the balance of forces.
        let b = 2.5e6;
        let a = (b * machine.get(Parameter::AreaB) - machine.get(Parameter::LoadForce) + 300.0)
            / machine.get(Parameter::AreaA);
        let run = held(&machine, &[(Signal::PressureA, a), (Signal::PressureB, b), (Signal::Position, 0.12)]);
        let moved = |signal, from: f64| {
            run.signal(signal).unwrap().iter().map(|value| (value - from).abs()).fold(0.0, f64::max)
        };
        // Bristles that are straight at first yield by 30 µm.
        assert!(moved(Signal::Position, 0.12) < 1e-7, "{}", moved(Signal::Position, 0.12));
        assert!(moved(Signal::PressureA, a) < 1e3, "{}", moved(Signal::PressureA, a));
    }

    #[test]
    fn a_rod_beside_the_middle_of_its_play_shows_what_was_recorded_until_it_has_moved_through_it() {
        let machine = with_papers_valve().with(&[(Parameter::BacklashPlay, 1e-3)]);
        let time_s: Vec<f64> = (0..600).map(|row| f64::from(row) * 1e-3).collect();
        let columns = [
            Column::si(Signal::Time, time_s.clone()),
            Column::si(Signal::Command, time_s.iter().map(|time| if *time < 0.1 { 0.0 } else { 5.0 }).collect()),
            Column::si(Signal::Position, vec![0.12; time_s.len()]),
        ];
        let recording = Recording::new("extends", columns.to_vec()).unwrap();
        let (command, load) = (InputPoint::Command, LoadSource::Constant);
        let stimulus = Stimulus::new(&recording, &machine, command, load, Tick::OneMillisecond).unwrap();
        let position = |shift_m: f64| {
            let run = simulate_f64(&machine, &stimulus, StartOffset { shift_m, ..StartOffset::none() }).unwrap();
            let position = run.signal(Signal::Position).unwrap();
            (position[50], position[599])
        };
        let (middle, beside, beyond) = (position(0.0), position(-4e-4), position(-7e-4));
        assert!((middle.0 - 0.12).abs() < 1e-6 && (beside.0 - 0.12).abs() < 1e-6, "{middle:?} {beside:?}");
        // Extending, the rod pushes the sensor from the other end of its play.
        assert!((beside.1 - middle.1 + 4e-4).abs() < 2e-5, "{middle:?} {beside:?}");
        // Where it cannot be within the play, the sensor goes along.
        assert!((beyond.0 - 0.12 + 2e-4).abs() < 1e-6, "{beyond:?}");
    }

    #[test]
    fn a_settled_spool_starts_where_it_was_read_within_the_hysteresis() {
        let machine = with_papers_valve().with(&[(Parameter::HysteresisWidth, 0.02)]);
        let offset = machine.get(Parameter::ValveOffset);
        let spool = |machine: &Machine<f64>, reading: f64| {
            let run = held(machine, &[(Signal::Spool, reading), (Signal::Position, 0.12)]);
            let spool = run.signal(Signal::Spool).unwrap();
            (spool[0], spool[249])
        };
        for off in [-0.008, 0.004] {
            let (first, last) = spool(&machine, offset + off);
            assert!((first - offset - off).abs() < 1e-9 && (last - first).abs() < 1e-9, "{first} {last}");
        }
        // No further than the hysteresis reaches, and without one at the target.
        assert!((spool(&machine, offset + 0.03).0 - offset - 0.01).abs() < 1e-9);
        assert!((spool(&with_papers_valve(), offset + 0.004).0 - offset).abs() < 1e-9);
    }
}
