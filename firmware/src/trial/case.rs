//! A trial: a machine under an input, run to its fingerprint.

use core::fmt::{self, Write};
use core::hash::{Hash, Hasher};

use model_core::drive::{Drive, DriveState};
use model_core::machine::{Form, Machine, MachineError, Tick};
use model_core::ports::ChamberState;

use super::DELAY;
use super::effects::{every_effect, forms};
use super::fingerprint::Fingerprint;
use super::input::Input;
use super::machines::{press, pump};
use super::traced::Traced;

/// Ticks of a random input.
const RANDOM_TICKS: usize = 3000;
/// Every so many ticks a state is written in plain text.
const SAMPLED: usize = 1000;

/// The effects that are on in a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
enum On {
    Nothing,
    One(&'static Form),
    Everything,
}

/// A machine with effects under an input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    on: On,
    input: Input,
}

/// The state after so many ticks, raw words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Ticks since the start.
    pub tick: usize,
    /// Spool.
    pub spool: i32,
    /// Pressure in A.
    pub pressure_a: i32,
    /// Pressure in B.
    pub pressure_b: i32,
    /// Velocity.
    pub velocity: i32,
    /// Position.
    pub position: i64,
    /// Fingerprint of everything up to here.
    pub fingerprint: u64,
}

/// Why a trial cannot be run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CaseError {
    /// The machine does not become a drive.
    Machine(MachineError),
    /// The receiver of the samples failed.
    Taken(fmt::Error),
}

impl From<MachineError> for CaseError {
    fn from(error: MachineError) -> Self {
        CaseError::Machine(error)
    }
}

impl From<fmt::Error> for CaseError {
    fn from(error: fmt::Error) -> Self {
        CaseError::Taken(error)
    }
}

/// All trials: no effect, each alone and all together; under the recorded and the random input, and with any drive input; and the pump.
pub fn cases() -> impl Iterator<Item = Case> {
    let sets = || [On::Nothing, On::Everything].into_iter().chain(forms().map(On::One));
    let under = |input: Input| sets().map(move |on| Case { on, input });
    let recorded = [On::Nothing, On::Everything].map(|on| Case { on, input: Input::Recorded });
    recorded.into_iter().chain(under(Input::Random)).chain(under(Input::Anywhere)).chain(under(Input::Pump))
}

impl Case {
    /// The machine.
    #[must_use]
    pub fn machine(&self) -> Machine<f64> {
        let plain = if self.input == Input::Pump { pump() } else { press() };
        match self.on {
            On::Nothing => plain,
            On::One(form) => plain.with(form.values),
            On::Everything => every_effect(&plain),
        }
    }

    /// Runs the trial in a number type and passes on samples.
    ///
    /// # Errors
    /// The machine is not valid, or the samples cannot be taken.
    pub fn run<N: Traced>(&self, mut take: impl FnMut(Sample) -> fmt::Result) -> Result<(), CaseError> {
        let drive = Drive::<N>::new::<DELAY>(&self.machine(), Tick::OneMillisecond)?;
        let mut fingerprint = Fingerprint::new();
        // Every coefficient in plain text, real numbers with all their digits.
        write!(fingerprint, "{drive:?}")?;
        let pressures = ChamberState { a: N::saturated(0.3), b: N::saturated(0.5) };
        let mut state: DriveState<N, DELAY> = drive.at_rest(N::ZERO, pressures, N::travel(0.5));
        let ticks = if self.input == Input::Recorded { usize::MAX } else { RANDOM_TICKS };
        let mut tick = 0;
        for moment in self.input.moments().take(ticks).map(N::moment) {
            if let Some(temperature) = moment.oil_temperature {
                state.oil_temperature = temperature;
            }
            drive.step(&mut state, moment.drive_input, moment.load).hash(&mut fingerprint);
            state.hash(&mut fingerprint);
            drive.sensed(&state).hash(&mut fingerprint);
            tick += 1;
            if tick % SAMPLED == 0 {
                take(Sample {
                    tick,
                    spool: state.valve.spool().word(),
                    pressure_a: state.chambers.a.word(),
                    pressure_b: state.chambers.b.word(),
                    velocity: state.motion.velocity.word(),
                    position: N::place(state.motion.position),
                    fingerprint: fingerprint.finish(),
                })?;
            }
        }
        Ok(())
    }

    /// Writes its trace in a number type: name, then samples.
    ///
    /// # Errors
    /// As [`Case::run`].
    pub fn trace<N: Traced>(&self, out: &mut impl Write) -> Result<(), CaseError> {
        writeln!(out, "{}{self}", N::PREFIX)?;
        self.run::<N>(|sample| writeln!(out, "{sample}"))
    }
}

impl fmt::Display for Case {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let on = match self.on {
            On::Nothing => "no effect",
            On::One(form) => form.name,
            On::Everything => "every effect",
        };
        write!(formatter, "{}: {on}", self.input.name())
    }
}

impl fmt::Display for Sample {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let Self { tick, spool, pressure_a, pressure_b, velocity, position, fingerprint } = self;
        write!(
            formatter,
            "{tick:>6} {spool:>11} {pressure_a:>11} {pressure_b:>11} {velocity:>11} {position:>18} {fingerprint:016x}"
        )
    }
}
