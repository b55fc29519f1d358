//! A trial: a machine under an input, run to its fingerprint.

use core::fmt::{self, Write};
use core::hash::{Hash, Hasher};

use model_core::drive::{Baked, BakedDrive, Drive, DriveInput, DriveState, Interfaces, Load};
use model_core::machine::{Form, Machine, MachineError, Tick};
use model_core::number::Number;
use model_core::ports::ChamberState;
use model_core::sensing::Sensed;

use super::DELAY;
use super::effects::{ON_A_MASS, SETS, Set, every_effect, forms};
use super::fingerprint::Fingerprint;
use super::input::Input;
use super::machines::{mass, press, pump};
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
    Several(&'static Set),
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

/// All trials: no effect, each alone, several and all together; under the recorded and the random input, and with any drive input; the pump, and a
/// mass that a force moves.
pub fn cases() -> impl Iterator<Item = Case> {
    let sets = || {
        let several = SETS.iter().map(On::Several);
        [On::Nothing, On::Everything].into_iter().chain(forms().map(On::One)).chain(several)
    };
    let under = |input: Input| sets().map(move |on| Case { on, input });
    let recorded = [On::Nothing, On::Everything].map(|on| Case { on, input: Input::Recorded });
    let of_oil =
        recorded.into_iter().chain(under(Input::Random)).chain(under(Input::Anywhere)).chain(under(Input::Pump));
    of_oil.chain([On::Nothing, On::Several(&ON_A_MASS)].map(|on| Case { on, input: Input::Force }))
}

/// What is stepped in a trial: coefficients that were built, or baked ones.
pub trait Model<N: Traced> {
    /// At rest, as [`Drive::at_rest`].
    fn at_rest(&self, pressures: ChamberState<N>, position: N::Travel) -> State<N>;

    /// One tick, as [`Drive::step`].
    fn step(&self, state: &mut State<N>, drive_input: DriveInput<N>, load: Load<N>) -> Interfaces<N>;

    /// What the sensors read, as [`Drive::sensed`].
    fn sensed(&self, state: &State<N>) -> Sensed<N>;

    /// The coefficients.
    fn coefficients(&self) -> &Drive<N>;
}

/// State of a trial.
type State<N> = DriveState<N, DELAY>;

impl<N: Traced> Model<N> for Drive<N> {
    fn at_rest(&self, pressures: ChamberState<N>, position: N::Travel) -> State<N> {
        Drive::at_rest(self, N::ZERO, pressures, position)
    }
    fn step(&self, state: &mut State<N>, drive_input: DriveInput<N>, load: Load<N>) -> Interfaces<N> {
        Drive::step(self, state, drive_input, load)
    }
    fn sensed(&self, state: &State<N>) -> Sensed<N> {
        Drive::sensed(self, state)
    }
    fn coefficients(&self) -> &Drive<N> {
        self
    }
}

impl<B: Baked<Number: Traced>> Model<B::Number> for BakedDrive<B> {
    fn at_rest(&self, pressures: ChamberState<B::Number>, position: <B::Number as Number>::Travel) -> State<B::Number> {
        BakedDrive::at_rest(self, B::Number::ZERO, pressures, position)
    }
    fn step(
        &self,
        state: &mut State<B::Number>,
        drive_input: DriveInput<B::Number>,
        load: Load<B::Number>,
    ) -> Interfaces<B::Number> {
        BakedDrive::step(self, state, drive_input, load)
    }
    fn sensed(&self, state: &State<B::Number>) -> Sensed<B::Number> {
        BakedDrive::sensed(self, state)
    }
    fn coefficients(&self) -> &Drive<B::Number> {
        B::DRIVE
    }
}

impl Case {
    /// The machine.
    #[must_use]
    pub fn machine(&self) -> Machine<f64> {
        let plain = match self.input {
            Input::Pump => pump(),
            Input::Force => mass(),
            Input::Recorded | Input::Random | Input::Anywhere => press(),
        };
        match self.on {
            On::Nothing => plain,
            On::One(form) => plain.with(form.values),
            On::Several(set) => set.on(&plain),
            On::Everything => every_effect(&plain),
        }
    }

    /// Runs the trial in a number type and passes on samples.
    ///
    /// # Errors
    /// The machine is not valid, or the samples cannot be taken.
    pub fn run<N: Traced>(&self, take: impl FnMut(Sample) -> fmt::Result) -> Result<(), CaseError> {
        let drive = Drive::<N>::new::<DELAY>(&self.machine(), Tick::OneMillisecond)?;
        Ok(run(&drive, self.input, take)?)
    }

    /// What drives it.
    #[must_use]
    pub fn input(&self) -> Input {
        self.input
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

/// Runs a model under an input and passes on samples.
///
/// # Errors
/// The samples cannot be taken.
pub fn run<N: Traced>(model: &impl Model<N>, input: Input, mut take: impl FnMut(Sample) -> fmt::Result) -> fmt::Result {
    let mut fingerprint = Fingerprint::new();
    // Every coefficient in plain text, real numbers with all their digits.
    write!(fingerprint, "{:?}", model.coefficients())?;
    let pressures = ChamberState { a: N::saturated(0.3), b: N::saturated(0.5) };
    let mut state = model.at_rest(pressures, N::travel(0.5));
    let ticks = if input == Input::Recorded { usize::MAX } else { RANDOM_TICKS };
    let mut tick = 0;
    for moment in input.moments().take(ticks).map(N::moment) {
        if let Some(temperature) = moment.oil_temperature {
            state.oil_temperature = temperature;
        }
        model.step(&mut state, moment.drive_input, moment.load).hash(&mut fingerprint);
        state.hash(&mut fingerprint);
        model.sensed(&state).hash(&mut fingerprint);
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

impl fmt::Display for Case {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let on = match self.on {
            On::Nothing => "no effect",
            On::One(form) => form.name,
            On::Several(set) => set.name,
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
