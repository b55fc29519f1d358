//! Where the firmware meets its hardware: three traits of one method each, in whole counts.
//!
//! embedded-hal 1.0 has no converter and no encoder. A driver of this crate, or a closure around the functions of a HAL
//! ([`FromFn`]), implements each trait; nothing beyond this file knows a bus. The type states its scale: what 2¹⁶ counts are, in µV
//! (a scale in µV per count would not be whole). How volts and counts become physical quantities is described in
//! [`scaling`](crate::scaling).
//!
//! ```
//! use core::convert::Infallible;
//! use firmware::io::{AnalogIn, FromFn};
//!
//! // A 12-bit converter of the controller itself, 0 to 3.3 V: 2¹⁶ of its counts are 52.8 V.
//! let mut raw = [0_u16, 4095].into_iter();
//! let mut inputs = FromFn::<_, 52_800_000>(|_channel| Ok::<i32, Infallible>(i32::from(raw.next().unwrap_or(0))));
//! assert_eq!(inputs.convert(0)?, 0);
//! assert_eq!(inputs.convert(0)?, 4095);
//! # Ok::<(), firmware::io::Foreign<Infallible>>(())
//! ```

pub mod ad5754;
pub mod ads8688;
pub mod ls7366r;

use core::fmt::Debug;

/// Why a device did not do what was requested, in a form that a log can carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Cause {
    /// The bus itself failed: the device said nothing.
    Bus,
    /// The device, or what is connected in its place, gives a wrong answer.
    WrongAnswer {
        /// What it must answer.
        expected: u32,
        /// What it answers.
        found: u32,
    },
    /// The device lost its supply, and with it its configuration or its count.
    PowerLost,
    /// The device protects itself: its output is shorted or it is too hot.
    Overloaded,
    /// The wiring uses a channel that the driver was not configured for.
    NotInUse,
}

/// An error of a device.
pub trait IoError: Debug {
    /// What went wrong, without the bus's own types.
    fn cause(&self) -> Cause;
}

/// An analogue input of one or more channels.
pub trait AnalogIn {
    /// Why there is no conversion.
    type Error: IoError;
    /// What 2¹⁶ counts are, in µV.
    const SPAN_UV: u32;

    /// One conversion of one channel, in counts; 0 is 0 V.
    ///
    /// # Errors
    /// The device does not answer, or gives a wrong answer.
    fn convert(&mut self, channel: u8) -> Result<i32, Self::Error>;
}

/// An analogue output.
pub trait AnalogOut {
    /// Why nothing was put out.
    type Error: IoError;
    /// What 2¹⁶ counts are, in µV.
    const SPAN_UV: u32;

    /// Puts out a count, and holds it until the next; 0 is 0 V. Beyond its range the device puts out the range's end.
    ///
    /// # Errors
    /// The device does not answer, or gives a wrong answer.
    fn write(&mut self, count: i32) -> Result<(), Self::Error>;
}

/// A position as a count that wraps around: after `i32::MAX` comes `i32::MIN`.
pub trait PositionIn {
    /// Why there is no count.
    type Error: IoError;

    /// The count now.
    ///
    /// # Errors
    /// The device does not answer, or gives a wrong answer.
    fn count(&mut self) -> Result<i32, Self::Error>;
}

/// A closure as an input or output: `FnMut(u8) -> Result<i32, E>`, `FnMut(i32) -> Result<(), E>` or `FnMut() -> Result<i32, E>`.
///
/// `SPAN_UV` is what 2¹⁶ counts are, in µV; a position has none.
#[derive(Clone, Copy, Debug)]
pub struct FromFn<F, const SPAN_UV: u32 = 0>(pub F);

/// The error of a closure: a failure of the bus behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("bus: {0:?}")]
pub struct Foreign<E>(pub E);

impl<E: Debug> IoError for Foreign<E> {
    fn cause(&self) -> Cause {
        Cause::Bus
    }
}

impl<F, E, const SPAN_UV: u32> AnalogIn for FromFn<F, SPAN_UV>
where
    F: FnMut(u8) -> Result<i32, E>,
    E: Debug,
{
    type Error = Foreign<E>;
    const SPAN_UV: u32 = SPAN_UV;

    fn convert(&mut self, channel: u8) -> Result<i32, Self::Error> {
        (self.0)(channel).map_err(Foreign)
    }
}

impl<F, E, const SPAN_UV: u32> AnalogOut for FromFn<F, SPAN_UV>
where
    F: FnMut(i32) -> Result<(), E>,
    E: Debug,
{
    type Error = Foreign<E>;
    const SPAN_UV: u32 = SPAN_UV;

    fn write(&mut self, count: i32) -> Result<(), Self::Error> {
        (self.0)(count).map_err(Foreign)
    }
}

impl<F, E> PositionIn for FromFn<F>
where
    F: FnMut() -> Result<i32, E>,
    E: Debug,
{
    type Error = Foreign<E>;

    fn count(&mut self) -> Result<i32, Self::Error> {
        (self.0)().map_err(Foreign)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_closure_is_any_of_the_three_and_its_failure_is_one_of_the_bus() {
        let mut written = 0;
        let mut output = FromFn::<_, 20_000_000>(|count: i32| -> Result<(), ()> {
            written = count;
            Ok(())
        });
        output.write(-5).unwrap();
        assert_eq!(written, -5);
        let mut position = FromFn::<_>(|| Err::<i32, _>("no clock"));
        let error = position.count().unwrap_err();
        assert_eq!((error, error.cause()), (Foreign("no clock"), Cause::Bus));
    }
}
