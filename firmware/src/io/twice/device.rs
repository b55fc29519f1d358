//! What the firmware asks of a device.

use core::fmt::Debug;

use super::twice;
use crate::io::{Foreign, FromFn, IoError};

/// An analogue input of one or more channels.
#[twice(AFIT)]
pub trait AnalogIn {
    /// Why there is no conversion.
    type Error: IoError;
    /// What 2¹⁶ counts are, in µV.
    const SPAN_UV: u32;

    /// One conversion of one channel, in counts; 0 is 0 V.
    ///
    /// # Errors
    /// The device does not answer, or gives a wrong answer.
    async fn convert(&mut self, channel: u8) -> Result<i32, Self::Error>;
}

/// An analogue output.
#[twice(AFIT)]
pub trait AnalogOut {
    /// Why nothing was put out.
    type Error: IoError;
    /// What 2¹⁶ counts are, in µV.
    const SPAN_UV: u32;

    /// Puts out a count, and holds it until the next; 0 is 0 V. Beyond its range the device puts out the range's end.
    ///
    /// # Errors
    /// The device does not answer, or gives a wrong answer.
    async fn write(&mut self, count: i32) -> Result<(), Self::Error>;
}

/// A position as a count that wraps around: after `i32::MAX` comes `i32::MIN`.
#[twice(AFIT)]
pub trait PositionIn {
    /// Why there is no count.
    type Error: IoError;

    /// The count now.
    ///
    /// # Errors
    /// The device does not answer, or gives a wrong answer.
    async fn count(&mut self) -> Result<i32, Self::Error>;
}

#[twice(AFIT)]
impl<F, E, const SPAN_UV: u32> AnalogIn for FromFn<F, SPAN_UV>
where
    F: FnMut(u8) -> Result<i32, E>,
    E: Debug,
{
    type Error = Foreign<E>;
    const SPAN_UV: u32 = SPAN_UV;

    async fn convert(&mut self, channel: u8) -> Result<i32, Self::Error> {
        (self.0)(channel).map_err(Foreign)
    }
}

#[twice(AFIT)]
impl<F, E, const SPAN_UV: u32> AnalogOut for FromFn<F, SPAN_UV>
where
    F: FnMut(i32) -> Result<(), E>,
    E: Debug,
{
    type Error = Foreign<E>;
    const SPAN_UV: u32 = SPAN_UV;

    async fn write(&mut self, count: i32) -> Result<(), Self::Error> {
        (self.0)(count).map_err(Foreign)
    }
}

#[twice(AFIT)]
impl<F, E> PositionIn for FromFn<F>
where
    F: FnMut() -> Result<i32, E>,
    E: Debug,
{
    type Error = Foreign<E>;

    async fn count(&mut self) -> Result<i32, Self::Error> {
        (self.0)().map_err(Foreign)
    }
}
