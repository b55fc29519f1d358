//! What drives a trial: a recorded command, or everything at random.

use core::str::Lines;

use model_core::drive::{DriveInput, Load};
use model_core::flow::PumpDrive;
use model_core::number::{Number, PerUnit};
use model_core::ports::{Flows, Spool};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// The command of the shipped case's four training recordings one after the other: lines of `ticks of 1 ms, tenths of a millivolt`.
pub const RECORDED: &str = include_str!("recorded.txt");

/// Recorded units in a command of 1, which is 10 V.
const RECORDED_PER_UNIT: i64 = 100_000;

/// Seed of all random inputs.
const SEED: u64 = 6340;
/// Shortest and longest time for which a random moment is held, ticks.
const HELD: [u32; 2] = [80, 500];

/// The paper's steps: 0.1 s of rest, then 0.5 s out, 0.35 s of rest, 0.5 s back, 0.35 s of rest; commands of so many volts.
pub fn steps_of(volts: i32) -> impl Iterator<Item = Moment> {
    let command = PerUnit::from_bits(volts * ((1 << 28) / 10));
    let parts = [(100, PerUnit::ZERO), (500, command), (350, PerUnit::ZERO), (500, -command), (350, PerUnit::ZERO)];
    parts.into_iter().flat_map(|(ticks, command)| core::iter::repeat_n(Moment::command(command), ticks))
}

/// What drives a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// The recorded command.
    Recorded,
    /// Commands within ±10 V held for 80 to 500 ms, loads, oil temperatures.
    Random,
    /// The same, but driving the model at a randomly drawn link, with values up to the ends of the format.
    Anywhere,
    /// Speeds and directions of a pump, loads.
    Pump,
    /// Forces on the mass, loads.
    Force,
}

/// Inputs of a drive in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment<N = PerUnit> {
    /// At which link the model is driven, and with what.
    pub drive_input: DriveInput<N>,
    /// External force.
    pub load: Load<N>,
    /// Measured oil temperature; `None` leaves it as it was.
    pub oil_temperature: Option<N>,
}

impl<N: Number> Moment<N> {
    /// A command alone.
    #[must_use]
    pub fn command(command: N) -> Self {
        Self { drive_input: DriveInput::Command(command), load: Load::NONE, oil_temperature: None }
    }
}

impl Moment {
    /// The same in another number type, each value rounded to it.
    #[must_use]
    pub fn rounded_to<N: Number>(self) -> Moment<N> {
        let to = |signal: PerUnit| N::saturated(signal.to_f64());
        let spool = |spool: Spool<PerUnit>| Spool { from: to(spool.from), to: to(spool.to) };
        let flows = |flows: Flows<PerUnit>| Flows { a: to(flows.a), b: to(flows.b) };
        let drive_input = match self.drive_input {
            DriveInput::Command(command) => DriveInput::Command(to(command)),
            DriveInput::Spool(measured) => DriveInput::Spool(spool(measured)),
            DriveInput::Followed { command, spool: measured } => {
                DriveInput::Followed { command: to(command), spool: spool(measured) }
            }
            DriveInput::Pump(pump) => DriveInput::Pump(PumpDrive { speed: to(pump.speed), direction: pump.direction }),
            DriveInput::Flow { from, to } => DriveInput::Flow { from: flows(from), to: flows(to) },
            DriveInput::Force { from, to: end } => DriveInput::Force { from: to(from), to: to(end) },
        };
        let load = Load { from: to(self.load.from), to: to(self.load.to) };
        Moment { drive_input, load, oil_temperature: self.oil_temperature.map(to) }
    }
}

impl Input {
    /// Its name in a trace.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Input::Recorded => "recorded",
            Input::Random => "random",
            Input::Anywhere => "anywhere",
            Input::Pump => "pump",
            Input::Force => "force",
        }
    }

    /// The moments, tick by tick; a random input never ends.
    #[must_use]
    pub fn moments(self) -> Moments {
        Moments {
            input: self,
            lines: RECORDED.lines(),
            generator: ChaCha8Rng::seed_from_u64(SEED),
            left: 0,
            now: Moment::command(PerUnit::ZERO),
        }
    }
}

/// The moments of an input.
#[derive(Clone, Debug)]
pub struct Moments {
    input: Input,
    lines: Lines<'static>,
    generator: ChaCha8Rng,
    /// Ticks for which the present moment is still held.
    left: u32,
    now: Moment,
}

impl Iterator for Moments {
    type Item = Moment;

    fn next(&mut self) -> Option<Moment> {
        if self.left == 0 {
            (self.left, self.now) = match self.input {
                Input::Recorded => self.recorded()?,
                Input::Random | Input::Anywhere | Input::Pump | Input::Force => self.held(),
            };
        }
        self.left = self.left.checked_sub(1)?;
        Some(self.now)
    }
}

impl Moments {
    fn recorded(&mut self) -> Option<(u32, Moment)> {
        let (ticks, tenths) = self.lines.next()?.split_once(' ')?;
        let tenths: i64 = tenths.parse().ok()?;
        let bits = (tenths << 28) / RECORDED_PER_UNIT;
        Some((ticks.parse().ok()?, Moment::command(PerUnit::from_bits(i32::try_from(bits).ok()?))))
    }

    fn held(&mut self) -> (u32, Moment) {
        let [shortest, longest] = HELD;
        let ticks = shortest + self.generator.next_u32() % (longest - shortest);
        (ticks, self.drawn())
    }

    fn drawn(&mut self) -> Moment {
        let drive_input = match self.input {
            Input::Recorded | Input::Random => DriveInput::Command(self.within_one()),
            Input::Anywhere => self.anywhere(),
            Input::Pump => DriveInput::Pump(self.pump()),
            Input::Force => DriveInput::Force { from: self.within_one(), to: self.within_one() },
        };
        let load = Load { from: self.within_one().halved().halved(), to: self.within_one().halved().halved() };
        // −25 to 100 °C; one in four is not measured.
        let warm = PerUnit::ONE.halved() + PerUnit::ONE + self.within_one() + self.within_one().halved();
        let oil_temperature = (!self.generator.next_u32().is_multiple_of(4)).then_some(warm);
        Moment { drive_input, load, oil_temperature }
    }

    fn anywhere(&mut self) -> DriveInput<PerUnit> {
        let spool = Spool { from: self.within_one(), to: self.within_one() };
        match self.generator.next_u32() % 6 {
            0 => DriveInput::Command(PerUnit::from_bits(self.bits())),
            1 => DriveInput::Spool(spool),
            2 => DriveInput::Followed { command: self.within_one(), spool },
            3 => DriveInput::Flow {
                from: Flows { a: self.within_one(), b: self.within_one() },
                to: Flows { a: self.within_one(), b: self.within_one() },
            },
            4 => DriveInput::Force { from: self.within_one(), to: self.within_one() },
            _ => DriveInput::Pump(self.pump()),
        }
    }

    fn pump(&mut self) -> PumpDrive<PerUnit> {
        let direction = match self.generator.next_u32() % 3 {
            0 => -1,
            1 => 0,
            _ => 1,
        };
        PumpDrive { speed: self.within_one(), direction }
    }

    /// −1..1
    fn within_one(&mut self) -> PerUnit {
        PerUnit::from_bits(self.bits() >> 3)
    }

    fn bits(&mut self) -> i32 {
        self.generator.next_u32().cast_signed()
    }
}
