//! Whether a recording begins at rest, and what it shows of the motion where it does not.
//!
//! What moves before a command of the recording can have an effect was moved by what came before the recording. So does the spool (or, where no
//! spool is measured, the rod) that changes its motion while the command keeps its first value, for a settled valve would not move it. And a rod that
//! rests under a command that would move it, and is moved only later, had its command given with the first row.

use std::ops::Range;

use model_core::machine::{Machine, Parameter, Source};
use recording::{Recording, Signal};

use crate::input_point::InputPoint;
use crate::signal::noise::extent;
use crate::straight_line::{Line, noise_of};

/// The spool in the first row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpoolAtStart {
    /// What its sensor reads, 1.
    pub reading: f64,
    /// Slope of the reading, 1/s.
    pub slope_per_s: f64,
    /// Whether it rested before: the command was then given only now. Otherwise the command is taken to be as old as the valve's delay.
    pub rests: bool,
}

/// What the first rows of a recording show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    /// 0 for a rod at rest.
    pub(crate) velocity_m_per_s: f64,
    pub(crate) spool: Option<SpoolAtStart>,
    pub(crate) unknown_for_s: f64,
    /// Whether it changes, so that means over a longer time are no initial values.
    pub(crate) is_changing: bool,
    /// Rows from which initial values can be read then.
    pub(crate) first_rows: usize,
}

/// Fewest rows that a slope is taken from.
const LEAST_ROWS: usize = 5;
/// Fewest rows that show whether the spool moves at all.
const LEAST_ROWS_OF_SLOPE: usize = 3;
/// A single reading is that many standard deviations of the noise off less often than once in a hundred million rows.
const BEYOND_NOISE: f64 = 6.0;
/// Least change of the spool that counts, as a share of full travel: less than any dead zone, and more than a drifting neutral moves meanwhile.
const LEAST_TRAVEL: f64 = 0.005;
/// The nominal place of a settled spool is known to a tenth of full travel at zero command …
const NOMINAL_OFFSET: f64 = 0.1;
/// … and within this share of what the command adds.
const NOMINAL_GAIN: f64 = 0.3;
/// A rod at less than this share of the speed that it has later, for as much opening, is not moved by a settled valve: mass and pressures follow sooner.
const LATE_BELOW: f64 = 0.5;
/// A first-order lag has settled to less than a hundredth after this many of its time constants.
const SETTLED: f64 = 5.0;
/// No more than this share of a recording is unknown: less would be left of short ones than they show.
const MOST_UNKNOWN: f64 = 0.25;

/// A command is a ramp in the first rows where none is off a straight line by more than this share of their change.
const STRAIGHT: f64 = 0.1;
/// A spool that follows a ramp from before goes as fast as the ramp; one that rested gains less than 0.6 of that in the time by which it trails, even
/// if the valve is twice as fast as its data sheet says.
const AS_FAST: f64 = 0.7;

/// How long the beginning of a recording may be unknown, s.
pub(crate) fn longest_unknown_s(time_s: &[f64]) -> f64 {
    MOST_UNKNOWN * (time_s[time_s.len() - 1] - time_s[0])
}

/// The first rows of a recording, and a machine's nominal times.
struct Beginning<'a> {
    recording: &'a Recording,
    machine: &'a Machine<f64>,
    time_s: &'a [f64],
    /// Transport delay and lags of the valve.
    settling_s: f64,
    /// Rows before the command's first change can have an effect, none later than the settling time.
    undisturbed: usize,
    /// The time of these rows, s.
    undisturbed_s: f64,
    /// Whether these rows last as long as the valve needs to settle.
    settles: bool,
    first_rows: usize,
}

/// No spool travels this far, 1: half beyond its rated travel.
const MOST_TRAVEL: f64 = 1.5;

impl Motion {
    /// What a recording shows that drives a machine at this point.
    pub(crate) fn of(recording: &Recording, machine: &Machine<f64>, input_point: InputPoint) -> Self {
        let beginning = Beginning::of(recording, machine, input_point);
        let mut motion = Self {
            velocity_m_per_s: 0.0,
            spool: None,
            unknown_for_s: 0.0,
            is_changing: false,
            first_rows: beginning.first_rows,
        };
        if recording.rows() < LEAST_ROWS {
            return motion;
        }
        let by_valve = machine.source == Source::Valve && recording.has(Signal::Command);
        let spool = recording.signal(Signal::Spool).filter(|_| by_valve);
        let unseen = by_valve && spool.is_none();
        let shown = if unseen { beginning.unseen_spool() } else { spool.and_then(|spool| beginning.spool(spool)) };
        let rod_changes = unseen && (shown.is_some() || beginning.rod_changes() || beginning.is_on_a_ramp());
        motion.is_changing = shown.is_some() || rod_changes;
        if input_point == InputPoint::Command {
            motion.spool = shown;
            if rod_changes || shown.is_some_and(|spool| !spool.rests) {
                let longest_s = longest_unknown_s(beginning.time_s);
                motion.unknown_for_s = beginning.settling_s.min(longest_s);
            }
        }
        motion.velocity_m_per_s = beginning.velocity(motion.is_changing);
        motion
    }
}

impl<'a> Beginning<'a> {
    fn of(recording: &'a Recording, machine: &'a Machine<f64>, input_point: InputPoint) -> Self {
        let (time_s, get) = (recording.time_s(), |parameter| machine.get(parameter));
        let delay_s = get(Parameter::TransportDelay);
        let settling_s = delay_s + SETTLED * machine.spool_lag_s();
        let driving =
            recording.signal(if input_point == InputPoint::Pump { Signal::PumpSpeed } else { Signal::Command });
        // No valve waits for a command that stands beside a force.
        let driving = driving.filter(|_| machine.source != Source::Force);
        let changed = driving.and_then(|values| values.iter().position(|value| value.to_bits() != values[0].to_bits()));
        // What only sensors show may move the rod at once.
        let undisturbed_s = match (driving, changed) {
            (None, _) => 0.0,
            (Some(_), None) => f64::INFINITY,
            (Some(_), Some(row)) => time_s[row] - time_s[0] + delay_s,
        };
        let within = |longest_s: f64| time_s.partition_point(|time| time - time_s[0] <= longest_s);
        Self {
            recording,
            machine,
            time_s,
            settling_s,
            undisturbed: within(undisturbed_s.min(settling_s)),
            undisturbed_s,
            settles: undisturbed_s >= settling_s,
            first_rows: within(delay_s).max(LEAST_ROWS).min(time_s.len()),
        }
    }

    /// The spool, where it is not at rest where the command would hold it.
    fn spool(&self, spool: &[f64]) -> Option<SpoolAtStart> {
        let ramp = self.ramp();
        if let Some(followed) = ramp.and_then(|ramp| self.along(ramp, spool)) {
            return Some(followed);
        }
        let noise = noise_of(spool);
        let first = Line::through(&self.time_s[..self.first_rows], &spool[..self.first_rows], noise);
        let (low, high) = extent(&spool[..self.undisturbed]);
        // A spool that follows a command trails it by the delay and the lags.
        let rows = self.undisturbed.max(if self.is_hardly_disturbed(spool) { LEAST_ROWS_OF_SLOPE } else { 0 });
        let slope = Line::through(&self.time_s[..rows], &spool[..rows], noise).clear_slope();
        let trails = self.trails_s();
        let follows = rows >= LEAST_ROWS_OF_SLOPE && (slope * trails).abs() > (BEYOND_NOISE * noise).max(LEAST_TRAVEL);
        let moves = follows || high - low > (2.0 * BEYOND_NOISE * noise).max(LEAST_TRAVEL);
        let by_command = self.by_command();
        let displaced = (first.at_start - by_command - self.machine.get(Parameter::ValveOffset)).abs();
        let is_displaced = !self.settles && displaced > NOMINAL_OFFSET + NOMINAL_GAIN * by_command.abs();
        // A wave's spool that turns just then does not rest.
        let trailed = ramp.map_or(0.0, |(slope_per_s, _)| slope_per_s.abs() * trails);
        // A reading beyond every travel is in another unit, and no state to start from.
        ((moves || is_displaced) && first.at_start.abs() < MOST_TRAVEL).then(|| {
            // Of a command that is held, only the first rows tell how it begins.
            let slope_per_s = if follows && !self.settles { slope } else { first.clear_slope() };
            SpoolAtStart {
                reading: if slope_per_s == 0.0 { first.mean } else { first.at_start },
                slope_per_s,
                rests: slope_per_s == 0.0 && displaced > 2.0 * trailed,
            }
        })
    }

    /// Where the first command holds a spool without offset, 1.
    fn by_command(&self) -> f64 {
        self.machine.get(Parameter::ValveGain) * self.recording.signal(Signal::Command).map_or(0.0, |volts| volts[0])
    }

    /// By what a spool trails its command, s.
    fn trails_s(&self) -> f64 {
        self.machine.get(Parameter::TransportDelay) + self.machine.spool_lag_s()
    }

    /// The slope of the spool, 1/s, that follows a command which changes evenly from the first row on, and the rows in which it does, at most those of the
    /// time by which the spool trails; `None` for another command, and for one so slow that it makes no difference.
    fn ramp(&self) -> Option<(f64, usize)> {
        let command = self.recording.signal(Signal::Command)?;
        let trails_s = self.trails_s();
        let most = self.time_s.partition_point(|time| time - self.time_s[0] <= trails_s);
        (LEAST_ROWS..=most.max(LEAST_ROWS).min(command.len())).rev().find_map(|rows| {
            let (time_s, command) = (&self.time_s[..rows], &command[..rows]);
            let line = Line::through(time_s, command, 0.0);
            let off = |(time, volts): (&f64, &f64)| (volts - line.at(*time)).abs();
            let off = time_s.iter().zip(command).map(off).fold(0.0, f64::max);
            let slope_per_s = self.machine.get(Parameter::ValveGain) * line.slope;
            let is_straight = off < STRAIGHT * (line.slope * (time_s[rows - 1] - time_s[0])).abs();
            (is_straight && (slope_per_s * trails_s).abs() > LEAST_TRAVEL).then_some((slope_per_s, rows))
        })
    }

    /// The spool that goes along with such a ramp from the first row on: it followed it before.
    fn along(&self, (ramp, rows): (f64, usize), spool: &[f64]) -> Option<SpoolAtStart> {
        let line = Line::through(&self.time_s[..rows], &spool[..rows], 0.0);
        (line.slope * ramp.signum() > AS_FAST * ramp.abs() && line.at_start.abs() < MOST_TRAVEL)
            .then_some(SpoolAtStart { reading: line.at_start, slope_per_s: line.slope, rests: false })
    }

    /// Whether a command that is a ramp from the first row on began before it, for it is away from zero or the rod moves: the unseen spool did not rest at its
    /// first value.
    fn is_on_a_ramp(&self) -> bool {
        let Some((slope_per_s, _)) = self.ramp() else { return false };
        let of_two_rows = 2.0 * slope_per_s * (self.time_s[1] - self.time_s[0]);
        self.by_command().abs() > of_two_rows.abs().max(LEAST_TRAVEL) || self.velocity(true) != 0.0
    }

    /// Whether what the command changes in the rows of a slope cannot be what moves the spool in them: it acts only at their end, on a spool that lags, and
    /// would move it by less than half as much. The rows of slow recordings are further apart than the command's delay.
    fn is_hardly_disturbed(&self, spool: &[f64]) -> bool {
        let Some(command) = self.recording.signal(Signal::Command) else { return false };
        let acts_s = self.time_s[LEAST_ROWS_OF_SLOPE - 1] - self.time_s[0] - self.undisturbed_s;
        let change = |values: &[f64]| {
            let (low, high) = extent(&values[..LEAST_ROWS_OF_SLOPE]);
            high - low
        };
        let share = (acts_s / self.machine.spool_lag_s()).clamp(0.0, 1.0);
        2.0 * share * self.machine.get(Parameter::ValveGain) * change(command) < change(spool)
    }

    /// A spool that no sensor shows, where the rod rests under a command that would move it and only then is moved: the command was given with the
    /// first row, or so shortly before that oil has not moved the rod yet. The spool is in its middle, or not far from it.
    fn unseen_spool(&self) -> Option<SpoolAtStart> {
        let (command, position) = (self.recording.signal(Signal::Command)?, self.recording.signal(Signal::Position)?);
        let settled = self.settled_rows();
        if settled < LEAST_ROWS.max(self.first_rows + 1) {
            return None;
        }
        let noise = noise_of(position);
        let first = Line::through(&self.time_s[..self.first_rows], &position[..self.first_rows], noise);
        let (lowest, highest) = extent(&position[..settled]);
        let then_moves = highest - lowest > 2.0 * BEYOND_NOISE * noise;
        let rests = !self.shows(first.clear_slope(), noise);
        (self.is_open(&command[..settled]) && rests && then_moves).then_some(SpoolAtStart {
            reading: self.machine.get(Parameter::ValveOffset),
            slope_per_s: 0.0,
            rests: true,
        })
    }

    /// Whether the rod is not moved as by a settled valve: evenly, or not at all, or as fast as later.
    fn rod_changes(&self) -> bool {
        let Some(position) = self.recording.signal(Signal::Position) else { return false };
        if self.rod_is_late(position) {
            return true;
        }
        let noise = noise_of(position);
        let (time_s, position) = (&self.time_s[..self.undisturbed], &position[..self.undisturbed]);
        if position.len() < LEAST_ROWS {
            return false;
        }
        let line = Line::through(time_s, position, noise);
        let off = |(time, value): (&f64, &f64)| (value - line.at(*time)).abs();
        let uneven = time_s.iter().zip(position).map(off).fold(0.0, f64::max) > BEYOND_NOISE * noise;
        uneven || (!self.settles && self.shows(line.clear_slope(), noise))
    }

    /// Whether the rod begins at less than half of the speed, for as much opening, that it has once a valve has settled under a command that opens the same
    /// way all the time: the spool is still on its way there, even if the command changes in every row.
    fn rod_is_late(&self, position: &[f64]) -> bool {
        let get = |parameter| self.machine.get(parameter);
        let Some(command) = self.recording.signal(Signal::Command) else { return false };
        let settled = self.settled_rows();
        if !self.is_open(&command[..settled]) || settled < 2 * self.first_rows {
            return false;
        }
        let noise = noise_of(position);
        let per_opening = |rows: Range<usize>| {
            let volts = command[rows.clone()].iter().sum::<f64>().abs() / rows.len() as f64;
            let opening = get(Parameter::ValveGain) * volts - get(Parameter::DeadZone);
            Line::through(&self.time_s[rows.clone()], &position[rows], noise).clear_slope() / opening
        };
        let (first, then) = (per_opening(0..self.first_rows), per_opening(settled - self.first_rows..settled));
        then != 0.0 && first * then.signum() < LATE_BELOW * then.abs()
    }

    /// The rows within which a valve settles.
    fn settled_rows(&self) -> usize {
        self.time_s.partition_point(|time| time - self.time_s[0] <= self.settling_s)
    }

    /// Whether these commands open the valve, all in one direction.
    fn is_open(&self, command: &[f64]) -> bool {
        let gain = self.machine.get(Parameter::ValveGain);
        let opens = NOMINAL_OFFSET + (1.0 + NOMINAL_GAIN) * self.machine.get(Parameter::DeadZone);
        let (low, high) = extent(command);
        gain * low > opens || gain * high < -opens
    }

    /// The rod's velocity, m/s; 0 where it is too slow for its sensor to show that a run begins at rest instead.
    fn velocity(&self, is_changing: bool) -> f64 {
        let rows = if is_changing { self.first_rows } else { self.undisturbed.max(LEAST_ROWS) }.min(self.time_s.len());
        let line = |signal| {
            let values: &[f64] = self.recording.signal(signal)?;
            let noise = noise_of(values);
            Some((Line::through(&self.time_s[..rows], &values[..rows], noise), noise))
        };
        if let Some((velocity, noise)) = line(Signal::Velocity) {
            return if velocity.at_start.abs() > BEYOND_NOISE * noise { velocity.at_start } else { 0.0 };
        }
        let Some((position, noise)) = line(Signal::Position) else { return 0.0 };
        let velocity = position.clear_slope();
        if self.shows(velocity, noise) { velocity } else { 0.0 }
    }

    /// Whether a position's sensor with this noise shows that a rod begins with this velocity and not at rest: the oil springs make it
    /// catch up within v/ω, and a mass without oil its viscous friction within v·m/D.
    fn shows(&self, velocity_m_per_s: f64, noise_m: f64) -> bool {
        let mass_kg = self.machine.get(Parameter::MovingMass);
        let per_s = match self.machine.source {
            Source::Valve | Source::Pump => (self.machine.oil_spring_n_per_m() / mass_kg).sqrt(),
            Source::Force => self.machine.get(Parameter::ViscousFriction) / mass_kg,
        };
        velocity_m_per_s.abs() > noise_m * per_s
    }
}

#[cfg(test)]
mod tests {
    use machine_file::LoadSource;
    use model_core::machine::Tick;
    use recording::Column;
    use recording::seeded_noise::Noise;
    use test_press::with_papers_valve;

    use super::*;
    use crate::initial_state::StartOffset;
    use crate::recorded_start::Start;
    use crate::run::simulate_f64;
    use crate::stimulus::Stimulus;
    use crate::{By, Derivatives, Derived, Run, Trajectory, run_in_lanes};

    const NOISE: [(Signal, f64); 4] =
        [(Signal::Spool, 5e-4), (Signal::PressureA, 2e4), (Signal::PressureB, 2e4), (Signal::Position, 1e-5)];

    fn columns(from: u32, command: impl Fn(u32) -> f64) -> Vec<Column> {
        let rows = from..from + 1500;
        let time_s = rows.clone().map(|row| f64::from(row - from) * 1e-3).collect();
        vec![Column::si(Signal::Time, time_s), Column::si(Signal::Command, rows.map(command).collect())]
    }

    fn stimulus(recording: &Recording) -> Stimulus {
        let machine = with_papers_valve();
        Stimulus::new(recording, &machine, InputPoint::Command, LoadSource::Constant, Tick::OneMillisecond).unwrap()
    }

    /// What the press's sensors show of its answer to a command, from this millisecond on.
    fn cut(from: u32, command: impl Fn(u32) -> f64, sensors: &[Signal]) -> Recording {
        let whole: Vec<Column> = {
            let mut columns = columns(0, &command);
            let rows = 0..from + 1500;
            columns[0].values = rows.clone().map(|row| f64::from(row) * 1e-3).collect();
            columns[1].values = rows.map(&command).collect();
            columns.push(Column::si(Signal::Position, vec![0.12; columns[0].values.len()]));
            columns
        };
        let whole = stimulus(&Recording::new("whole", whole).unwrap());
        let run = simulate_f64(&with_papers_valve(), &whole, StartOffset::none()).unwrap();
        let seen =
            (1..).zip(NOISE).filter(|(_, (signal, _))| sensors.contains(signal)).map(|(stream, (signal, std))| {
                let mut noise = Noise::new(3, stream);
                let values = run.signal(signal).unwrap().iter().map(|value| value + noise.gaussian(std));
                Column::si(signal, values.skip(from as usize).collect())
            });
        Recording::new("cut", columns(from, &command).into_iter().chain(seen).collect()).unwrap()
    }

    fn start(recording: &Recording) -> Start {
        stimulus(recording).start
    }

    /// 7 V from the hundredth millisecond on, and back in the seven hundredth.
    fn step(row: u32) -> f64 {
        if (100..700).contains(&row) { 7.0 } else { 0.0 }
    }

    fn wave(row: u32) -> f64 {
        6.0 * (0.02 * f64::from(row)).sin()
    }

    const ALL: [Signal; 4] = [Signal::Spool, Signal::PressureA, Signal::PressureB, Signal::Position];

    /// RMS difference of recorded and simulated over the noise after the time that is not known.
    fn over_noise(recording: &Recording, signal: Signal) -> f64 {
        let stimulus = stimulus(recording);
        let run = simulate_f64(&with_papers_valve(), &stimulus, StartOffset::none()).unwrap();
        let from = recording.time_s().partition_point(|time| *time < stimulus.start.unknown_for_s);
        let rows = recording.signal(signal).unwrap().iter().zip(run.signal(signal).unwrap()).skip(from);
        let squares: Vec<f64> = rows.map(|(recorded, simulated)| (recorded - simulated).powi(2)).collect();
        let noise = NOISE.iter().find(|(known, _)| *known == signal).unwrap().1;
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt() / noise
    }

    #[test]
    fn a_recording_that_begins_at_rest_starts_at_rest() {
        for sensors in [&ALL[..], &ALL[1..], &ALL[3..]] {
            for command in [step, wave] {
                let recording = cut(0, command, sensors);
                let start = start(&recording);
                let at_rest = Start::at_rest(command(0), start.pressures_pa, start.position_m);
                assert_eq!(start, Start { settled: start.settled, ..at_rest }, "{sensors:?}");
                assert_eq!(start.settled.is_some(), sensors.contains(&Signal::Spool));
            }
        }
    }

    #[test]
    fn a_command_that_is_on_from_the_first_row_moves_the_spool_from_where_it_is() {
        let recording = cut(100, step, &ALL);
        let start = start(&recording);
        let spool = start.spool.unwrap();
        assert!(spool.rests && (spool.reading - 0.0345).abs() < 1e-3 && start.unknown_for_s == 0.0, "{start:?}");
        for signal in ALL {
            assert!(over_noise(&recording, signal) < 1.2, "{signal}: {}", over_noise(&recording, signal));
        }
        // A ramp hides what the command did before; the place of the spool shows it.
        let ramp = |row: u32| if row < 100 { 0.0 } else { 8.0 - 0.005 * f64::from(row - 100) };
        assert!(self::start(&cut(100, ramp, &ALL)).spool.is_some_and(|spool| spool.rests));
    }

    #[test]
    fn a_recording_that_is_cut_in_the_middle_of_a_transient_starts_from_the_measured_spool_and_velocity() {
        for (from, command) in [(130, step as fn(u32) -> f64), (715, step), (400, wave), (457, wave)] {
            let recording = cut(from, command, &ALL);
            let start = start(&recording);
            assert!(start.spool.is_some_and(|spool| !spool.rests), "{from}: {start:?}");
            // Of a wave one moment may be far calmer than those before; a quarter is the most that is lost.
            assert!((0.2..0.38).contains(&start.unknown_for_s), "{from}: {start:?}");
            let spool = over_noise(&recording, Signal::Spool);
            assert!(spool < 1.2, "{from}: {spool}");
        }
        let moving = start(&cut(715, step, &ALL)).velocity_m_per_s;
        assert!((0.02..0.08).contains(&moving), "{moving}");
    }

    /// The noise of a first row's velocity would make the oil spring ring by ten times the noise of these pressures.
    #[test]
    fn a_recording_that_begins_in_motion_is_followed_within_its_noise_from_where_it_is_taken_up() {
        for sensors in [&ALL[..], &ALL[1..]] {
            for (from, command) in [(420, step as fn(u32) -> f64), (715, step), (400, wave), (457, wave), (500, wave)] {
                let recording = cut(from, command, sensors);
                for signal in [Signal::PressureA, Signal::PressureB, Signal::Position] {
                    let off = over_noise(&recording, signal);
                    // A bend leaves a position uncertain by its noise, and so is all that follows.
                    let most = if signal == Signal::Position { 2.5 } else { 1.3 };
                    assert!(off < most, "{from}: {signal} of {sensors:?}: {off}");
                }
            }
        }
    }

    /// A row in 2 ms of a spool so noisy that a few rows do not show whether it moves.
    #[test]
    fn a_noisy_spool_that_goes_along_with_its_ramp_followed_it_before() {
        let noisy = |from| {
            let mut noise = Noise::new(7, 1);
            let recording = thinned(&cut(from, wave, &ALL), 2, &[&[Signal::Time, Signal::Command], &ALL[..]].concat());
            let column = |signal: Signal| recording.signal(signal).unwrap().to_vec();
            let spool = column(Signal::Spool).iter().map(|value| value + noise.gaussian(3e-3)).collect();
            let kept =
                [Signal::Time, Signal::Command, Signal::Position].map(|signal| Column::si(signal, column(signal)));
            Recording::new("noisy", kept.into_iter().chain([Column::si(Signal::Spool, spool)]).collect()).unwrap()
        };
        for from in [300, 320, 470, 480] {
            let spool = start(&noisy(from)).spool;
            assert!(spool.is_some_and(|spool| !spool.rests), "{from}: {spool:?}");
        }
        assert_eq!(start(&noisy(0)).spool, None);
    }

    #[test]
    fn without_a_measured_spool_a_changing_motion_is_not_known_and_an_even_one_is() {
        for sensors in [&ALL[1..], &ALL[3..]] {
            for (from, command) in [(100, step as fn(u32) -> f64), (130, step), (715, step), (457, wave)] {
                let start = start(&cut(from, command, sensors));
                assert!(start.unknown_for_s > 0.2, "{from}: {start:?}");
                // With the step, and 30 ms later, the rod still rests: the spool has not opened yet.
                let spool = start.spool.map(|spool| (spool.rests, spool.reading, start.velocity_m_per_s));
                assert_eq!(spool, (from <= 130).then_some((true, 0.0345, 0.0)), "{from}: {start:?}");
            }
            let even = start(&cut(420, step, sensors));
            let taken_up = even.taken_up.is_some();
            assert_eq!((taken_up, even.unknown_for_s), if sensors.len() > 1 { (true, 0.03) } else { (false, 0.0) });
            assert!(even.velocity_m_per_s > 0.02, "{even:?}");
        }
        assert!(start(&cut(420, step, &ALL)).spool.is_none(), "it is where the command holds it");
    }

    /// Every so many rows of some signals.
    fn thinned(recording: &Recording, by: usize, signals: &[Signal]) -> Recording {
        let thinned = |signal: &Signal| {
            let values = recording.signal(*signal).unwrap();
            Column::si(*signal, values.iter().copied().step_by(by).collect())
        };
        Recording::new("slow", signals.iter().map(thinned).collect()).unwrap()
    }

    /// A row in 5 ms under a command that changes in every row: too few rows are undisturbed to show a motion by themselves.
    #[test]
    fn a_rod_under_a_ramp_began_before_the_recording_whether_or_not_it_is_as_fast_as_its_command_makes_it() {
        let ramp = |row: u32| if row < 100 { 0.0 } else { 8.0 - 0.005 * f64::from(row - 100) };
        for sensors in [&ALL[1..], &ALL[3..]] {
            let signals = [&[Signal::Time, Signal::Command], sensors].concat();
            let unknown_for_s = |from| start(&thinned(&cut(from, ramp, sensors), 5, &signals)).unknown_for_s;
            for from in [110, 150, 160, 500] {
                assert!(unknown_for_s(from) > 0.2, "{from}: {sensors:?}");
            }
        }
    }

    /// A row in 20 ms: the command has changed before the second row can show what it did before.
    #[test]
    fn a_slow_recording_of_a_moving_spool_starts_from_it_and_one_from_rest_does_not() {
        let slow = |recording: &Recording| {
            thinned(recording, 20, &[Signal::Time, Signal::Command, Signal::Spool, Signal::Position])
        };
        for from in [400, 457] {
            let spool = start(&slow(&cut(from, wave, &ALL))).spool;
            assert!(spool.is_some_and(|spool| !spool.rests), "{from}: {spool:?}");
        }
        let stepped = |row: u32| if row < 10 { 0.0 } else { 8.0 };
        for command in [wave as fn(u32) -> f64, step, stepped] {
            assert_eq!(start(&slow(&cut(0, command, &ALL))).spool, None);
        }
    }

    #[test]
    fn no_more_than_a_quarter_of_a_short_recording_is_not_known() {
        let short = cut(130, step, &ALL).first(200);
        assert!((start(&short).unknown_for_s - 0.25 * 0.199).abs() < 2e-3, "on the grid of ticks");
    }

    #[test]
    fn derivatives_of_a_run_that_is_taken_up_are_its_differences() {
        const STEP: f64 = 1e-2;
        let (machine, signals) = (with_papers_valve(), [Signal::PressureA, Signal::Position]);
        let stimulus = stimulus(&cut(715, step, &ALL));
        assert!(stimulus.start.taken_up.is_some());
        let moved = [Parameter::FlowCoefficient, Parameter::TimeConstant1, Parameter::BulkModulus];
        let by = moved.map(|parameter| {
            let value = machine.get(parameter);
            By { parameter, value, slope: 1e-4 * value }
        });
        for shift_m in [0.0, 2e-5] {
            let run = |moved: Option<&By>, by: f64| {
                let machine = moved.map_or(machine, |one| machine.with(&[(one.parameter, one.value + by * one.slope)]));
                let shift_m = shift_m + if moved.is_none() { 1e-6 * by } else { 0.0 };
                simulate_f64(&machine, &stimulus, StartOffset { shift_m, ..StartOffset::none() }).unwrap()
            };
            let both = |moved| (run(moved, STEP), run(moved, -STEP));
            let runs: Vec<_> = by.iter().map(Some).chain([None]).map(both).collect();
            let offset = StartOffset { shift_m, ..StartOffset::none() };
            let (level_slope, shift_slope_m) = (0.0, 1e-6);
            let stimulus = &stimulus;
            let derivatives = Derivatives {
                machine: &machine,
                by: &by,
                offset,
                level_slope,
                shift_slope_m,
                stimulus,
                signals: &signals,
            };
            // By signal and by what moves it: the largest difference, and the largest error of a derivative.
            let (mut largest, mut worst) = ([[0.0_f64; 4]; 2], [[0.0_f64; 4]; 2]);
            let mut judged = |row: usize, place: usize, derived: Derived<'_>| {
                let partials = derived.unwrap().1;
                for (index, (up, down)) in runs.iter().enumerate() {
                    let at = |run: &Trajectory| run.signal(signals[place]).unwrap()[row];
                    let difference = (at(up) - at(down)) / (2.0 * STEP);
                    // The level of a start comes before its shift.
                    let partial = f64::from(partials[if index == by.len() { index + 1 } else { index }]);
                    largest[place][index] = largest[place][index].max(difference.abs());
                    worst[place][index] = worst[place][index].max((difference - partial).abs());
                }
            };
            derivatives.run(&mut judged).unwrap();
            for (worst, largest) in worst.iter().flatten().zip(largest.iter().flatten()) {
                assert!(worst <= &(1e-5 * largest), "{worst} of {largest}");
            }
            assert!((largest[1][3] - 1e-6).abs() < 1e-11, "the shift moves the position all along");
        }
    }

    #[test]
    fn in_lanes_a_recording_starts_in_motion_as_it_does_alone() {
        let machine = with_papers_valve();
        let stimuli = [stimulus(&cut(0, step, &ALL)), stimulus(&cut(130, step, &ALL)), stimulus(&cut(100, step, &ALL))];
        let runs: Vec<Run<'_>> = stimuli
            .iter()
            .map(|stimulus| Run { stimulus, offset: StartOffset::none(), signals: ALL.to_vec() })
            .collect();
        let alone = stimuli.each_ref().map(|stimulus| simulate_f64(&machine, stimulus, StartOffset::none()).unwrap());
        let mut rows = 0;
        run_in_lanes(&machine, &runs, &mut |run, row, values| {
            for (signal, value) in ALL.iter().zip(values) {
                assert_eq!(alone[run].signal(*signal).unwrap()[row].to_bits(), value.to_bits(), "{run} {row} {signal}");
            }
            rows += 1;
        })
        .unwrap();
        assert_eq!(rows, 4500);
    }
}
