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

pub use blocking::device::{AnalogIn, AnalogOut, PositionIn};

/// Over buses that block. The source is that of `asynchronous`, from which `twice` takes `async` and `.await`; its `AFIT` means plain async functions in traits.
#[path = "twice"]
mod blocking {
    use embedded_hal::delay::DelayNs;
    use embedded_hal::spi::SpiDevice;
    use maybe_async::must_be_sync as twice;

    #[cfg(test)]
    use crate::mock::done as block_on;

    pub(super) mod ad5754;
    pub(super) mod ads8688;
    pub(super) mod device;
    pub(super) mod ls7366r;
}

/// The same traits and drivers over buses that are awaited: feature `async`.
///
/// They are compiled from the same source as the blocking ones: frames, their order and the checks of answers are the same. A closure ([`FromFn`]) answers at once
/// here too, as a counter does that is a timer of the controller.
#[cfg(feature = "async")]
#[path = "twice"]
#[expect(
    async_fn_in_trait,
    reason = "whether a future may change threads is the executor's concern; on a controller it stays"
)]
#[expect(clippy::duplicate_mod, reason = "one source of the protocol for both kinds of bus")]
pub mod asynchronous {
    use embedded_hal_async::delay::DelayNs;
    use embedded_hal_async::spi::SpiDevice;
    use maybe_async::must_be_async as twice;
    #[cfg(test)]
    use pollster::block_on;

    mod ad5754;
    mod ads8688;
    mod device;
    mod ls7366r;

    pub use ad5754::Ad5754;
    pub use ads8688::Ads8688;
    pub use device::{AnalogIn, AnalogOut, PositionIn};
    pub use ls7366r::Ls7366r;
}

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
