//! AD5754: four analogue outputs of 16 bits, here ±10 V. Analog Devices, data sheet AD5724/AD5734/AD5754, section Registers.
//!
//! SPI mode 2 (or 1), at most 30 MHz. Pin BIN/2sCOMP low: codes are two's complement, so that the part's power-on code of 0 is 0 V. Pin
//! LDAC low: a code takes effect at the end of its frame. Reference 2.5 V; the AD5754R has its own.
//!
//! Frames of 24 bits (input shift register): R/W, 0, register (3), address (3), data (16). One frame requests a read; the answer comes
//! in the data bits of the next frame, a NOP.
//!
//! | register | address | data |
//! |---|---|---|
//! | 0 DAC | channel | code |
//! | 1 output range | channel | bits 2…0: 4 is ±10 V |
//! | 2 power control | 0 | bits 3…0 power up D…A, 4 power up reference, 5 too hot, 10…7 overcurrent D…A |
//! | 3 control | 1 | bit 3 thermal shutdown on, 2 clamp on, 1 clear code, 0 SDO off |
//! | 3 control | 0 | NOP: 18h |
//!
//! Nothing on this bus acknowledges a write, so the power control register is read after every write of an output: an output that is
//! shorted, too hot, or down because the supply was lost is an error in the same period.
//!
//! The crate `ad57xx` 0.3 is not used: its read-back combines the answer's second byte with the first (the read bit and address) instead
//! of the third, so no configuration could be checked; by its own statement reading was never tried; and it links
//! embedded-hal-async and defmt 0.3 into every build.

use crate::io::{Cause, IoError};

pub use super::blocking::ad5754::Ad5754;

/// Register and address bits of the first byte.
pub(super) const RANGE: u8 = 0x08;
pub(super) const POWER: u8 = 0x10;
pub(super) const CONTROL: u8 = 0x19;
pub(super) const NOP: [u8; 3] = [0x18, 0, 0];
const READ: u8 = 0x80;
/// Output range: ±10 V.
pub(super) const BIPOLAR_10_V: u16 = 4;
/// Control: an output that is too hot is shut down; a shorted output is held at 20 mA and reported.
pub(super) const PROTECTED: u16 = 0b1100;
/// Power control.
pub(super) const REFERENCE_UP: u16 = 1 << 4;
const TOO_HOT: u16 = 1 << 5;
const FIRST_OVERCURRENT: u32 = 7;
/// From powering up to the first code: 10 µs, doubled.
pub(super) const POWER_UP_US: u32 = 20;

/// Outputs of the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// VOUTA
    A = 0,
    /// VOUTB
    B = 1,
    /// VOUTC
    C = 2,
    /// VOUTD
    D = 3,
}

/// Where the part's 2.5 V come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// From outside, at pin REFIN.
    External,
    /// The AD5754R's own.
    Internal,
}

/// A register that is read back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Register {
    /// Output range.
    Range,
    /// Power control.
    Power,
    /// Control.
    Control,
}

/// Why nothing was put out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Ad5754Error<E> {
    /// The bus failed.
    #[error("AD5754: bus: {0:?}")]
    Bus(E),
    /// A register does not read back as it was written.
    #[error("AD5754: register {register:?} reads {found:#06x}; expected {expected:#06x}")]
    Register {
        /// Which.
        register: Register,
        /// What was written.
        expected: u16,
        /// What it reads.
        found: u16,
    },
    /// The output is at its current limit.
    #[error("AD5754: overcurrent (power control {found:#06x})")]
    Overcurrent {
        /// Power control register.
        found: u16,
    },
    /// The part shut itself down.
    #[error("AD5754: too hot (power control {found:#06x})")]
    TooHot {
        /// Power control register.
        found: u16,
    },
}

impl<E: core::fmt::Debug> IoError for Ad5754Error<E> {
    fn cause(&self) -> Cause {
        match *self {
            Ad5754Error::Bus(_) => Cause::Bus,
            Ad5754Error::Register { expected, found, .. } => {
                Cause::WrongAnswer { expected: expected.into(), found: found.into() }
            }
            Ad5754Error::Overcurrent { .. } | Ad5754Error::TooHot { .. } => Cause::Overloaded,
        }
    }
}

/// The frame that writes a register.
pub(super) fn writing(first: u8, data: u16) -> [u8; 3] {
    let [high, low] = data.to_be_bytes();
    [first, high, low]
}

/// The frame that requests a register; a [`NOP`] is answered with it.
pub(super) fn requesting(first: u8) -> [u8; 3] {
    [READ | first, 0, 0]
}

/// The frame that puts out a count, held at the ends of its 16 bits.
pub(super) fn putting_out(channel: Channel, count: i32) -> [u8; 3] {
    #[expect(clippy::cast_possible_truncation, reason = "held within 16 bits")]
    let code = count.clamp(i16::MIN.into(), i16::MAX.into()) as i16;
    writing(channel as u8, code.cast_unsigned())
}

/// The data of an answer.
pub(super) fn data([_, high, low]: [u8; 3]) -> u16 {
    u16::from_be_bytes([high, low])
}

/// Whether the bits of `mask` read as they were written.
pub(super) fn confirmed<E>(register: Register, mask: u16, expected: u16, found: u16) -> Result<(), Ad5754Error<E>> {
    if found & mask == expected { Ok(()) } else { Err(Ad5754Error::Register { register, expected, found }) }
}

/// Whether the output is powered and not overloaded, by the power control register.
pub(super) fn healthy<E>(channel: Channel, powered: u16, found: u16) -> Result<(), Ad5754Error<E>> {
    let overcurrent = 1 << (FIRST_OVERCURRENT + channel as u32);
    // A line that is stuck high reads as power on for the other channels too, which were never powered up.
    if found & 0b1_1111 != powered {
        Err(Ad5754Error::Register { register: Register::Power, expected: powered, found })
    } else if found & TOO_HOT != 0 {
        Err(Ad5754Error::TooHot { found })
    } else if found & overcurrent != 0 {
        Err(Ad5754Error::Overcurrent { found })
    } else {
        Ok(())
    }
}
