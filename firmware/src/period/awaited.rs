//! The same period over devices that are awaited: between its readings and its output it awaits nothing, and computes what the blocking one does.

use super::asynchronous::devices::{convert, count, put_out, sample, write};
use super::{BeginError, Devices, InputVoltage, Period, Place, Report, Request, Rig};
use crate::control::Control;
use crate::io::asynchronous::{AnalogIn, AnalogOut, PositionIn};
use crate::measured::AnalogSignal;
use crate::supervision::Log;

impl<A: AnalogIn, P: PositionIn, O: AnalogOut, C: Control> Period<A, P, O, C> {
    /// As [`Period::begin`], over devices that are awaited.
    ///
    /// # Errors
    /// The limits are not valid, or counter or output do not answer.
    pub async fn begin_async(
        mut devices: Devices<A, P, O>,
        rig: Rig,
        control: C,
        place: Place,
    ) -> Result<Self, BeginError<P::Error, O::Error>> {
        let attempts = rig.limits.attempts;
        write(attempts, &mut devices.output, rig.neutral()?).await.map_err(BeginError::Output)?;
        let count = count(attempts, &mut devices.position, |_| true).await.map_err(BeginError::Position)?;
        Ok(Self::at(devices, &rig, control, place, count))
    }

    /// As [`Period::step`]: reads and awaits, computes, puts out and awaits.
    ///
    /// A future that is dropped halfway has stepped no model, or has not taken note of what was put out: let it end, and tell the next period of an overrun.
    pub async fn step_async(&mut self, request: &Request, log: &mut impl Log) -> Report {
        let sample = sample(&mut self.devices, &self.rig, &self.state.senses.travel).await;
        let decided = self.decide(request, &sample, log);
        let neutral = self.neutral();
        let done = put_out(self.rig.limits.attempts, &mut self.devices.output, decided.count, neutral).await;
        self.conclude(decided, done)
    }

    /// As [`Period::voltage`].
    ///
    /// # Errors
    /// The inputs do not answer.
    pub async fn voltage_async(&mut self, signal: AnalogSignal) -> Result<Option<InputVoltage>, A::Error> {
        let Some(row) = self.rig.calibration.row(signal) else { return Ok(None) };
        let count = convert(self.rig.limits.attempts, &mut self.devices.inputs, row.channel()).await?;
        Ok(Some(InputVoltage::of(signal, row, count, A::SPAN_UV)))
    }
}
