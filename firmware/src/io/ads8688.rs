//! ADS8688: eight analogue inputs of 16 bits, up to ±10.24 V. Texas Instruments, data sheet SBAS582C.
//!
//! SPI mode 1, at most 17 MHz. Reference 4.096 V (internal: pin REFSEL low). Manual mode: each frame names the channel of the next
//! one (command register, table 6), so a lost frame disturbs no more than one conversion, unlike in the automatic sequence.
//! Channels that are read in rising order cost one frame each; any other order costs two.
//!
//! The part is set to append to the 16 bits of a result its channel, its range and the number that was given to the part (feature
//! select register, 8.5.2.3.2, tables 12 to 14). A frame is therefore 6 bytes:
//!
//! | bits of the frame | 47…32 | 31…16 | 15…12 | 11, 10 | 9…7 | 6…0 |
//! |---|---|---|---|---|---|---|
//! | to the part | command | 0 | 0 | 0 | 0 | 0 |
//! | from the part | – | result | channel | part's number | range | 0 |
//!
//! The number is 2. A line that is stuck low or high does not answer with it, nor does a part that fell back to its defaults (those are
//! 0 and ±10.24 V on all channels; an overvoltage at one input has been seen to cause this, TI E2E 1529715), so a wrong scale is never
//! taken for the right one. For the ADS8688 only; the A and W have more ranges. The reference needs some 15 ms after power-up.
//!
//! A count is 78.125 µV on every range, which is the finest step of all ranges (table 4): 2¹⁶ counts are 5.12 V.
//!
//! **The part does not detect an open input.** Its own 1 MΩ leads to a bias, so on ±10.24 V an open input reads some +2 V (TI E2E 1245625),
//! in the middle of the permitted range. The limits of [`scaling`](crate::scaling) detect it, if the sensor has a live zero (0.5…4.5 V, or
//! 4…20 mA over 250 Ω: 1…5 V) and 100 kΩ to ground, which pulls an open wire below the zero; or, for ±10 V without a live zero, 100 kΩ to
//! +15 V, which pulls it to the rail. Either resistor takes 5 mV of 10 V from a sensor of 50 Ω.

use crate::io::{Cause, IoError};

pub use super::blocking::ads8688::Ads8688;

/// Channels of the part.
pub const CHANNELS: usize = 8;

/// Command register, table 6: reset the program registers.
pub(super) const RESET: [u8; 4] = [0x85, 0, 0, 0];
/// Command register, table 6: select channel 0; each further one is 4 more.
const MANUAL: u8 = 0xC0;
/// Program registers, 8.5.2.2.
pub(super) const POWER_DOWN: u8 = 0x02;
pub(super) const FEATURES: u8 = 0x03;
pub(super) const FIRST_RANGE: u8 = 0x05;
/// Number that is given to the part, `DEV[1:0]`.
const NUMBER: u8 = 2;
/// `DEV` and `SDO[2:0]` = 3: result, channel, number, range.
pub(super) const FEATURES_VALUE: u8 = NUMBER << 6 | 3;

/// Input range of a channel, with the code of table 14 and 8.5.2.3.3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// ±10.24 V, ±2.5 of the reference.
    Bipolar10V = 0,
    /// ±5.12 V, ±1.25 of the reference.
    Bipolar5V = 1,
    /// ±2.56 V, ±0.625 of the reference.
    Bipolar2V5 = 2,
    /// 0 to 10.24 V.
    Unipolar10V = 5,
    /// 0 to 5.12 V.
    Unipolar5V = 6,
}

impl Range {
    /// Counts of 78.125 µV from the part's straight binary code. Table 4.
    pub(super) fn counts(self, code: u16) -> i32 {
        let middle = i32::from(code) - 0x8000;
        match self {
            Range::Bipolar10V => 4 * middle,
            Range::Bipolar5V => 2 * middle,
            Range::Bipolar2V5 => middle,
            Range::Unipolar10V => 2 * i32::from(code),
            Range::Unipolar5V => i32::from(code),
        }
    }
}

/// Why there is no conversion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Ads8688Error<E> {
    /// The bus failed.
    #[error("ADS8688: bus: {0:?}")]
    Bus(E),
    /// A program register does not read back as it was written.
    #[error("ADS8688: register {register:#04x} reads {found:#04x}; expected {expected:#04x}")]
    Register {
        /// Address, 8.5.2.2.
        register: u8,
        /// What was written.
        expected: u8,
        /// What it reads.
        found: u8,
    },
    /// A result belongs to another channel or range, or does not come from such a part.
    #[error("ADS8688: result comes with {found:#06x} for channel, number and range; expected {expected:#06x}")]
    Tag {
        /// Channel, number and range that the result must carry, as in bits 15 to 0 of the frame.
        expected: u16,
        /// What it carries.
        found: u16,
    },
    /// The channel has no range.
    #[error("ADS8688: channel {channel} is not in use")]
    NotInUse {
        /// Which.
        channel: u8,
    },
}

impl<E: core::fmt::Debug> IoError for Ads8688Error<E> {
    fn cause(&self) -> Cause {
        match *self {
            Ads8688Error::Bus(_) => Cause::Bus,
            Ads8688Error::Register { expected, found, .. } => {
                Cause::WrongAnswer { expected: expected.into(), found: found.into() }
            }
            Ads8688Error::Tag { expected, found } => {
                Cause::WrongAnswer { expected: expected.into(), found: found.into() }
            }
            Ads8688Error::NotInUse { .. } => Cause::NotInUse,
        }
    }
}

/// The frame that writes a program register. 8.5.2.1.
pub(super) fn writing(register: u8, value: u8) -> [u8; 3] {
    [register << 1 | 1, value, 0]
}

/// The frame that reads a program register.
pub(super) fn reading(register: u8) -> [u8; 3] {
    [register << 1, 0, 0]
}

/// Whether a register reads as it was written.
pub(super) fn confirmed<E>(register: u8, expected: u8, answer: [u8; 3]) -> Result<(), Ads8688Error<E>> {
    let [.., found] = answer;
    if found == expected { Ok(()) } else { Err(Ads8688Error::Register { register, expected, found }) }
}

/// The frame that converts the channel that was selected before, and selects this one.
pub(super) fn selecting(next: u8) -> [u8; 6] {
    [MANUAL | next << 2, 0, 0, 0, 0, 0]
}

/// The count in an answer, if it carries this channel, its range and the part's number.
pub(super) fn count<E>(channel: u8, range: Range, answer: [u8; 6]) -> Result<i32, Ads8688Error<E>> {
    let [_, _, high, low, tag_high, tag_low] = answer;
    let found = u16::from_be_bytes([tag_high, tag_low]);
    let expected = u16::from(channel) << 12 | u16::from(NUMBER) << 10 | (range as u16) << 7;
    if found == expected {
        Ok(range.counts(u16::from_be_bytes([high, low])))
    } else {
        Err(Ads8688Error::Tag { expected, found })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn counts_are_the_volts_of_table_4(code in any::<u16>()) {
            let part = f64::from(code) / 65_536.0;
            for (range, low_v, high_v) in [
                (Range::Bipolar10V, -10.24, 10.24), (Range::Bipolar5V, -5.12, 5.12), (Range::Bipolar2V5, -2.56, 2.56),
                (Range::Unipolar10V, 0.0, 10.24), (Range::Unipolar5V, 0.0, 5.12),
            ] {
                let volts = f64::from(range.counts(code)) * 5.12 / 65_536.0;
                prop_assert!((volts - (low_v + part * (high_v - low_v))).abs() < 1e-9);
            }
        }
    }
}
