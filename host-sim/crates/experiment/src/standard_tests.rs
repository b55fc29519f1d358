//! The standard tests of a drive: short commands that anyone can give, each of which shows something different.
//!
//! They are designed for the drive: no larger than the commands it was recorded with, and slow enough to stay within its stroke.

use machine_file::LoadSource;
use model_core::machine::{Machine, Parameter, Tick};
use recording::excitation::signals::Excitation;
use recording::{Column, Recording, RecordingError, Signal, Unit};
use simulation::{InputPoint, Stimulus};

/// Interval between the rows of a test, s.
const INTERVAL_S: f64 = 2e-3;
/// The rod moves by this share of its stroke in each direction.
const TRAVEL: f64 = 0.3;

/// A command over time, and a load where the test needs one.
#[derive(Clone, Debug, PartialEq)]
pub struct StandardTest {
    /// Its name.
    pub name: &'static str,
    /// How to run it.
    pub how: String,
    /// Interval between rows, s.
    pub interval_s: f64,
    /// V, one value per row.
    pub command_v: Vec<f64>,
    /// External force, N, one value per row; empty for none.
    pub load_n: Vec<f64>,
}

impl StandardTest {
    /// An excitation with a given name and one row per tick.
    #[must_use]
    pub fn of_input(excitation: &Excitation, how: &str, tick: Tick) -> Self {
        let interval_s = tick.seconds();
        let command_v = excitation.sample(interval_s);
        Self { name: "the input", how: how.to_owned(), interval_s, command_v, load_n: Vec::new() }
    }

    /// Length, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.interval_s * (self.command_v.len().max(2) - 1) as f64
    }

    /// Its command, and the load where it needs one, with the rod at mid-stroke.
    pub fn recording(&self, machine: &Machine<f64>) -> Result<Recording, RecordingError> {
        let position = vec![0.5 * machine.get(Parameter::Stroke); self.command_v.len()];
        Recording::new(self.name, self.columns().chain([Column::si(Signal::Position, position)]).collect())
    }

    /// The same of a command in this unit.
    pub fn recording_in(&self, unit: Unit, machine: &Machine<f64>) -> Result<Recording, RecordingError> {
        let mut recording = self.recording(machine)?;
        recording.count_command_in(unit);
        Ok(recording)
    }

    /// Time, command, and the load where it needs one.
    pub fn columns(&self) -> impl Iterator<Item = Column> {
        // Times to the nanosecond: 0.006 and not 0.0060000000000000001.
        let time = |row: usize| (row as f64 * self.interval_s * 1e9).round() / 1e9;
        let times = (0..self.command_v.len()).map(time).collect();
        let load = (!self.load_n.is_empty()).then(|| Column::si(Signal::LoadForce, self.load_n.clone()));
        [Column::si(Signal::Time, times), Column::si(Signal::Command, self.command_v.clone())].into_iter().chain(load)
    }

    /// The stimulus from which a drive with a valve is simulated in this test.
    #[must_use]
    pub fn stimulus(&self, machine: &Machine<f64>, tick: Tick) -> Option<Stimulus> {
        let recording = self.recording(machine).ok()?;
        Stimulus::new(&recording, machine, InputPoint::Command, LoadSource::Constant, tick).ok()
    }
}

/// The tests for a drive that was recorded with commands up to `largest_v`.
#[must_use]
pub fn standard_tests(machine: &Machine<f64>, largest_v: f64) -> Vec<StandardTest> {
    let drive = Drive::of(machine, largest_v);
    let plain = |name, how: String, command_v| StandardTest {
        name,
        how,
        interval_s: INTERVAL_S,
        command_v,
        load_n: Vec::new(),
    };
    let volts = |value: f64| recording::display_unit::significant(value, 2);
    let slow = drive.volts_for(0.02).max(0.3 * largest_v);
    let excited = |excitation: Excitation| excitation.sample(INTERVAL_S);
    let full = largest_v;
    let (sizes, speeds) = ([0.25, 0.5, 0.75, 1.0], [0.005, 0.01, 0.03, 0.1]);
    let mut tests = vec![
        drive.hold(),
        plain(
            "slow triangle",
            format!("±{} V at 0.25 Hz", volts(slow)),
            excited(Excitation::Triangle { amplitude_v: slow, frequency_hz: 0.25, duration_s: 8.0 }),
        ),
        plain(
            "constant speeds",
            "both ways at 5, 10, 30 and 100 mm/s".to_owned(),
            drive.strokes(&speeds.map(|speed| (drive.volts_for(speed), speed))),
        ),
        plain(
            "steps of several sizes",
            format!("a quarter, half, three quarters and all of {} V, both ways", volts(full)),
            drive.strokes(&sizes.map(|size| (size * full, drive.speed_at(size * full)))),
        ),
        plain(
            "sine sweep",
            format!("±{} V from 0.4 to 10 Hz", volts(0.6 * full)),
            excited(Excitation::Sweep { amplitude_v: 0.6 * full, from_hz: 0.4, to_hz: 10.0, duration_s: 6.0 }),
        ),
        plain(
            "small sine sweep",
            format!("±{} V from 0.5 to 10 Hz", volts(slow)),
            excited(Excitation::Sweep { amplitude_v: slow, from_hz: 0.5, to_hz: 10.0, duration_s: 6.0 }),
        ),
        plain("ramps", format!("trapezoids up to {} V", volts(full)), drive.ramps(full)),
        plain(
            "random steps",
            format!("within ±{} V, 0.08 to 0.5 s each", volts(full)),
            excited(Excitation::Random {
                amplitude_v: full,
                shortest_s: 0.08,
                longest_s: 0.5,
                duration_s: 6.0,
                seed: 1,
            }),
        ),
    ];
    let whole = drive.whole_stroke(0.4 * full);
    tests.push(plain("whole stroke", "slowly from end to end".to_owned(), whole));
    tests
}

/// Command that moves the rod at about this speed, m/s, out (positive) or in; at most `largest_v`.
pub(crate) fn command_for(machine: &Machine<f64>, largest_v: f64, speed_m_per_s: f64) -> f64 {
    let volts = Drive::of(machine, largest_v).volts_for(speed_m_per_s.abs());
    volts.copysign(speed_m_per_s * machine.get(Parameter::ValveGain))
}

/// The values of a drive that the design of tests needs.
struct Drive {
    gain: f64,
    offset: f64,
    dead_zone: f64,
    /// Approximate speed per opening, m/s.
    speed: f64,
    stroke_m: f64,
    full_force_n: f64,
    largest_v: f64,
}

impl Drive {
    fn of(machine: &Machine<f64>, largest_v: f64) -> Self {
        let get = |parameter| machine.get(parameter);
        let supply = get(Parameter::SupplyPressure);
        Self {
            gain: get(Parameter::ValveGain),
            offset: get(Parameter::ValveOffset),
            dead_zone: get(Parameter::DeadZone),
            speed: get(Parameter::FlowCoefficient) * (0.5 * supply).sqrt() / get(Parameter::AreaA),
            stroke_m: get(Parameter::Stroke),
            full_force_n: supply * get(Parameter::AreaB),
            largest_v,
        }
    }

    /// Command that moves the rod at about this speed, m/s, computed for the slower direction.
    fn volts_for(&self, speed: f64) -> f64 {
        ((self.dead_zone + speed / self.speed + self.offset.abs()) / self.gain.abs()).min(self.largest_v)
    }

    fn speed_at(&self, volts: f64) -> f64 {
        ((self.gain * volts).abs() - self.dead_zone).max(0.0) * self.speed
    }

    fn rows(seconds: f64) -> usize {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small positive count")]
        let rows = (seconds / INTERVAL_S).round().max(1.0) as usize;
        rows
    }

    /// Each command in both directions with a rest after it, for as long as the stroke allows at its speed.
    fn strokes(&self, commands: &[(f64, f64)]) -> Vec<f64> {
        let mut volts = vec![0.0; Self::rows(0.1)];
        for (command, speed) in commands {
            let hold = (TRAVEL * self.stroke_m / speed.max(1e-4)).clamp(0.1, 1.2);
            for sign in [1.0, -1.0] {
                volts.extend(std::iter::repeat_n(sign * command, Self::rows(hold)));
                volts.extend(std::iter::repeat_n(0.0, Self::rows(0.2)));
            }
        }
        volts
    }

    fn ramps(&self, full: f64) -> Vec<f64> {
        let hold = (TRAVEL * self.stroke_m / self.speed_at(full).max(1e-4)).clamp(0.1, 0.6);
        let rise = 0.5;
        let length = 2.0 * rise + hold;
        (0..Self::rows(2.0 * length))
            .map(|row| {
                let time = row as f64 * INTERVAL_S;
                let (sign, within) = if time < length { (1.0, time) } else { (-1.0, time - length) };
                sign * full * (within / rise).min((length - within) / rise).clamp(0.0, 1.0)
            })
            .collect()
    }

    /// To the extended end and back beyond the middle, at a moderate command.
    fn whole_stroke(&self, volts: f64) -> Vec<f64> {
        let half = 0.47 * self.stroke_m / self.speed_at(volts).max(0.02);
        let half = half.min(2.5);
        let phase = |sign: f64, seconds: f64| std::iter::repeat_n(sign * volts, Self::rows(seconds));
        phase(1.0, half).chain(phase(-1.0, 2.0 * half)).chain(phase(1.0, half)).collect()
    }

    /// The valve closed, with a load switched on and off.
    fn hold(&self) -> StandardTest {
        let command_v = vec![0.0; Self::rows(6.0)];
        let load_n = (0..command_v.len())
            .map(|row| match row as f64 * INTERVAL_S {
                time if time < 0.5 => 0.0,
                time if time < 3.0 => 0.3 * self.full_force_n,
                time if time < 5.5 => -0.3 * self.full_force_n,
                _ => 0.0,
            })
            .collect();
        StandardTest {
            name: "closed-valve hold under load",
            how: "valve closed, a third of full force pulling, then pushing".to_owned(),
            interval_s: INTERVAL_S,
            command_v,
            load_n,
        }
    }
}
