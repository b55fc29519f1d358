//! The whole firmware of the press, from the exported values and over any devices: period with monitor, and recorder together.
//!
//! ```text
//! Assembly ─ from the exported values, once ─► Station ─ step, once a tick ─► Report
//! ```
//!
//! A board connects the three parts to its buses ([`wired`]); a program that simulates the devices passes its own ([`Assembly::over`]).

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::SpiDevice;
use model_core::control::{FollowError, Follower};
use model_core::machine::{Bases, Machine, MachineError};
use model_core::number::PerUnit;

use super::press::{self, PressError};
use crate::commissioning::{Commissioning, Refusal};
use crate::control::{Control, Following, Predicted, Reference};
use crate::excitation::plan::fingerprint;
use crate::io::ad5754::{Ad5754, Channel as Output, Reference as Supply};
use crate::io::ads8688::Ads8688;
use crate::io::ls7366r::{FilterClock, Ls7366r};
use crate::io::{AnalogIn, AnalogOut, Cause, IoError, PositionIn};
use crate::measured::{AnalogSignal, Measured};
use crate::period::{BeginError, Devices, InputVoltage, Period, Place, Report, Request, Rig};
use crate::recorder::{Channel, Range, Recorder, RecorderError};
use crate::supervision::{ActiveFaults, Deviation, DeviationLimits, Device, Log, Response};

/// Channels of the recorder.
const CHANNELS: usize = 5;
/// Rows of the recorder: six seconds.
pub const ROWS: usize = 6000;
/// Time that the recorder keeps from before its trigger, s, unless [`Assembly::recording_before`] says otherwise.
pub const BEFORE_S: f64 = 2.0;

/// The recorder of this rig: command, spool, pressures and position, one row per period; 60 kB.
pub type Ring = Recorder<CHANNELS, ROWS>;

/// RAM that the recorder's rows take, bytes.
pub const RING_BYTES: usize = CHANNELS * ROWS * size_of::<i16>();

/// The control of this rig.
pub type Press = Following<{ press::values::DELAY_LINE }>;

/// Why no station is made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StationError {
    /// The exported values do not make a drive.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// They make a drive that cannot be controlled.
    #[error(transparent)]
    Follow(#[from] FollowError),
    /// They do not fit the wiring.
    #[error(transparent)]
    Press(#[from] PressError),
    /// The recorder.
    #[error(transparent)]
    Recorder(#[from] RecorderError),
    /// A device does not answer as it must.
    #[error("{device:?} at the start: {cause:?}")]
    Device {
        /// Which.
        device: Device,
        /// Why.
        cause: Cause,
    },
}

impl StationError {
    fn of(device: Device) -> impl Fn(Cause) -> Self {
        move |cause| Self::Device { device, cause }
    }
}

/// What is made from the exported values before there are devices: configuration, and the model at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assembly {
    bases: Bases,
    rig: Rig,
    control: Press,
    commissioning: Commissioning,
    fingerprint: u32,
    /// µV of 2¹⁶ counts of the inputs.
    input_uv: u32,
    /// Rows that the recorder keeps from before its trigger.
    before: usize,
}

impl Assembly {
    /// For converters with these spans, µV per 2¹⁶ counts.
    ///
    /// # Errors
    /// The exported values do not make a drive, or do not fit wiring or monitor.
    pub fn new(input_uv: u32, output_uv: u32) -> Result<Self, StationError> {
        Self::of(&press::machine(), input_uv, output_uv)
    }

    /// The same with another machine instead of the exported one.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(machine: &Machine<f64>, input_uv: u32, output_uv: u32) -> Result<Self, StationError> {
        let tick = press::values::TICK;
        let reference = Reference::at_rest(machine, tick, 0.5)?;
        let bases = *reference.bases();
        let control = Following::new(Follower::new(machine, &press::tuning(machine), tick)?, reference);
        let rig = press::rig(machine, &bases, input_uv, output_uv)?;
        let commissioning = Commissioning::new(machine, &bases, &rig.limits);
        let fingerprint = fingerprint(machine);
        let assembly = Self { bases, rig, control, commissioning, fingerprint, input_uv, before: 0 };
        assembly.recording_before(BEFORE_S)
    }

    /// The same with a recorder that keeps so many seconds from before its trigger; the rest of its [`ROWS`] follows the trigger.
    ///
    /// # Errors
    /// The time is not a number, negative, or leaves no row for the trigger.
    pub fn recording_before(self, seconds: f64) -> Result<Self, StationError> {
        let rows = libm::round(seconds / self.bases.tick_s);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the limits just checked")]
        let before = if (0.0..ROWS as f64).contains(&rows) { rows as usize } else { usize::MAX };
        if before < ROWS {
            Ok(Self { before, ..self })
        } else {
            Err(RecorderError::Before { before, room: ROWS }.into())
        }
    }

    /// The same with the command read back at the valve ([`press::READ_BACK`]): a fault where it differs from the output. The commissioning needs it.
    ///
    /// # Errors
    /// It does not fit the inputs.
    pub fn reading_back(mut self) -> Result<Self, StationError> {
        let Self { rig, bases, input_uv, .. } = &mut self;
        let calibration = rig.calibration.with(AnalogSignal::Command, &press::READ_BACK, *input_uv, bases);
        rig.calibration = calibration.map_err(PressError::from)?;
        rig.limits = rig.limits.reading_back(press::READ_BACK_AWAY, bases).map_err(PressError::from)?;
        Ok(self)
    }

    /// The same with other limits of deviation than those by rule.
    ///
    /// # Errors
    /// A limit does not fit, or the range is empty.
    pub fn deviating(mut self, deviation: &Deviation) -> Result<Self, StationError> {
        let limits = DeviationLimits::new(deviation, &self.bases).map_err(PressError::from)?;
        self.rig.limits.deviation = limits;
        self.commissioning = self.commissioning.within(&self.rig.limits);
        Ok(self)
    }

    /// What 1 per unit stands for, in SI units.
    #[must_use]
    pub fn bases(&self) -> &Bases {
        &self.bases
    }

    /// The output's count at which the valve is neutral.
    #[must_use]
    pub fn neutral(&self) -> i32 {
        self.rig.calibration.output.count(self.rig.limits.neutral)
    }

    /// Builds the station over these devices, and puts the valve to neutral. `memory` holds the recorder, which is too large for a stack.
    ///
    /// # Errors
    /// A device does not answer as it must.
    pub fn over<A: AnalogIn, P: PositionIn, O: AnalogOut>(
        self,
        devices: Devices<A, P, O>,
        place: Place,
        memory: &mut Option<Ring>,
    ) -> Result<Station<'_, A, P, O>, StationError> {
        let Self { bases, rig, control, commissioning, fingerprint, before, .. } = self;
        let channel = |name, unit, base, range| Channel { name, unit, base, range };
        let recorder = memory.insert(Recorder::new(
            [
                channel("command", "V", bases.command_v, Range::One),
                // The spool may overshoot, and a pulling load raises a pressure above the supply.
                channel("spool", "1", 1.0, Range::Two),
                channel("pressure_a", "Pa", bases.pressure_pa, Range::Two),
                channel("pressure_b", "Pa", bases.pressure_pa, Range::Two),
                channel("position", "m", bases.stroke_m, Range::One),
            ],
            before,
        )?);
        let period = Period::begin(devices, rig, control, place).map_err(|error| match error {
            BeginError::Limits(error) => StationError::Press(error.into()),
            BeginError::Position(error) => StationError::of(Device::Position)(error.cause()),
            BeginError::Output(error) => StationError::of(Device::Output)(error.cause()),
        })?;
        Ok(Station { bases, period, commissioning, fingerprint, active_faults: ActiveFaults::NONE, recorder })
    }

    /// Builds the station over the press's three parts, and sets these up: see [`wired`].
    ///
    /// # Errors
    /// A part does not answer as it must.
    pub fn wired<'a, I: SpiDevice, C: SpiDevice, D: SpiDevice>(
        self,
        inputs: I,
        counter: C,
        output: D,
        delay: &mut impl DelayNs,
        memory: &'a mut Option<Ring>,
    ) -> Result<Wired<'a, I, C, D>, StationError> {
        let output = Ad5754::begin(output, delay, Output::A, Supply::External, self.neutral());
        let output = output.map_err(|error| StationError::of(Device::Output)(error.cause()))?;
        let mut ranges = press::RANGES;
        if self.rig.calibration.row(AnalogSignal::Command).is_some() {
            let [command, ..] = &mut ranges;
            *command = Some(press::READ_BACK_RANGE);
        }
        let inputs = Ads8688::begin(inputs, ranges);
        let inputs = inputs.map_err(|error| StationError::of(Device::Inputs)(error.cause()))?;
        let position = Ls7366r::begin(counter, FilterClock::Undivided);
        let position = position.map_err(|error| StationError::of(Device::Position)(error.cause()))?;
        self.over(Devices { inputs, position, output }, Place::Lost, memory)
    }
}

/// A station with the press's parts as analogue inputs, counter and output.
pub type Wired<'a, I, C, D> = Station<'a, Ads8688<I>, Ls7366r<C>, Ad5754<D>>;

/// Sets the parts up on their buses and begins, with the valve at neutral. The rod's position must be given before it follows ([`Station::home`]).
///
/// # Errors
/// The exported values do not make a station, or a part does not answer as it must.
pub fn wired<'a, I: SpiDevice, C: SpiDevice, D: SpiDevice>(
    inputs: I,
    counter: C,
    output: D,
    delay: &mut impl DelayNs,
    memory: &'a mut Option<Ring>,
) -> Result<Wired<'a, I, C, D>, StationError> {
    Assembly::new(Ads8688::<I>::SPAN_UV, Ad5754::<D>::SPAN_UV)?.wired(inputs, counter, output, delay, memory)
}

/// The same with the command read back: [`Assembly::reading_back`].
///
/// # Errors
/// As [`wired`].
pub fn wired_read_back<'a, I: SpiDevice, C: SpiDevice, D: SpiDevice>(
    inputs: I,
    counter: C,
    output: D,
    delay: &mut impl DelayNs,
    memory: &'a mut Option<Ring>,
) -> Result<Wired<'a, I, C, D>, StationError> {
    let assembly = Assembly::new(Ads8688::<I>::SPAN_UV, Ad5754::<D>::SPAN_UV)?.reading_back()?;
    assembly.wired(inputs, counter, output, delay, memory)
}

/// Period and recorder.
#[derive(Debug)]
pub struct Station<'a, A, P, O> {
    bases: Bases,
    period: Period<A, P, O, Press>,
    commissioning: Commissioning,
    fingerprint: u32,
    /// Faults after the last period: a new one triggers the recorder.
    active_faults: ActiveFaults,
    recorder: &'a mut Ring,
}

impl<A: AnalogIn, P: PositionIn, O: AnalogOut> Station<'_, A, P, O> {
    /// One period, called once a tick, then one row of the recording. The monitor's alarm and every fault trigger the recorder.
    pub fn step(&mut self, request: &Request, log: &mut impl Log) -> Report {
        let report = self.period.step(request, log);
        if report.alarm.is_some() || report.active_faults.has_more_than(self.active_faults) {
            self.recorder.trigger();
        }
        self.active_faults = report.active_faults;
        let Measured { position, spool, pressure_a, pressure_b, .. } = report.measured;
        self.recorder.record(&[Some(report.command), spool, pressure_a, pressure_b, Some(position)]);
        report
    }

    /// What 1 per unit stands for, in SI units.
    #[must_use]
    pub fn bases(&self) -> &Bases {
        &self.bases
    }

    /// Sets where the rod is, as a share of the stroke: [`Period::home`].
    pub fn home(&mut self, position: PerUnit) -> bool {
        self.period.home(position)
    }

    /// Whether the rod's place is known: [`Period::place`].
    pub fn place(&self) -> Place {
        self.period.place()
    }

    /// What the steps of the commissioning expect of this machine.
    #[must_use]
    pub fn commissioning(&self) -> Commissioning {
        self.commissioning
    }

    /// What tells the machine's values from others: [`fingerprint`].
    #[must_use]
    pub fn fingerprint(&self) -> u32 {
        self.fingerprint
    }

    /// A command for the reference model in the next period, which the machine follows: [`Period::play`].
    pub fn play(&mut self, command: PerUnit) {
        self.period.play(command);
    }

    /// A command in place of the loops' in the next period: [`Period::put_out_by_hand`].
    pub fn put_out_by_hand(&mut self, command: PerUnit) {
        self.period.put_out_by_hand(command);
    }

    /// The voltage of a signal's input, if it has a sensor: [`Period::voltage`].
    pub fn voltage(&mut self, signal: AnalogSignal) -> Option<Result<InputVoltage, Refusal>> {
        self.period.voltage(signal).map_err(|_| Refusal::Silent).transpose()
    }

    /// Changes what the monitor's alarm leads to: [`Period::answer_alarms`].
    pub fn answer_alarms(&mut self, response: Option<Response>) {
        self.period.answer_alarms(response);
    }

    /// Triggers the recorder.
    pub fn trigger(&mut self) {
        self.recorder.trigger();
    }

    /// The recorder deletes all rows and waits for the next trigger; the monitor may give an alarm again.
    pub fn arm(&mut self) {
        self.recorder.arm();
        self.period.arm_monitor();
    }

    /// The monitor forgets what it has seen: [`Period::arm_monitor`].
    pub fn arm_monitor(&mut self) {
        self.period.arm_monitor();
    }

    /// The recorder.
    #[must_use]
    pub fn recorder(&self) -> &Ring {
        self.recorder
    }

    /// What the model's sensors show now.
    #[must_use]
    pub fn predicted(&self) -> Predicted {
        self.period.control().predicted()
    }
}
