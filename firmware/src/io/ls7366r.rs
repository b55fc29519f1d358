//! LS7366R: a 32-bit counter for a quadrature encoder. LSI/CSI, data sheet 7366R.
//!
//! SPI mode 0. An instruction byte, then up to four data bytes; one instruction per chip select (table 1). The counter runs free over
//! 32 bits and counts every edge: an encoder of 3600 impulses per revolution gives 14 400 counts.
//!
//! Each reading takes two instructions: the status first, then the count, which the part latches by itself. The status must show
//! that counting is enabled and that the supply has not been lost since the start; a line that is stuck low fails the first
//! condition, a line that is stuck high the second.
//!
//! | instruction | CLR STR | WR MDR0 | WR MDR1 | CLR CNTR | RD MDR0 | RD MDR1 | RD CNTR | RD STR |
//! |---|---|---|---|---|---|---|---|---|
//! | byte | 30h | 88h | 90h | 20h | 48h | 50h | 60h | 70h |

use crate::io::{Cause, IoError};

pub use super::blocking::ls7366r::Ls7366r;

pub(super) const CLEAR_COUNT: [u8; 1] = [0x20];
pub(super) const CLEAR_STATUS: [u8; 1] = [0x30];
pub(super) const READ_COUNT: [u8; 5] = [0x60, 0, 0, 0, 0];
pub(super) const READ_STATUS: [u8; 2] = [0x70, 0];
/// Mode registers: number, and the instructions that write and read them.
pub(super) const MODE_0: Mode = Mode { register: 0, write: 0x88, read: 0x48 };
pub(super) const MODE_1: Mode = Mode { register: 1, write: 0x90, read: 0x50 };
/// MDR0: four counts per period of the encoder, free running, index unused.
pub(super) const FOURFOLD: u8 = 0x03;
/// MDR1: four bytes, counting enabled, no flags.
pub(super) const FOUR_BYTES: u8 = 0x00;
/// STR: counting is enabled; the supply was lost.
const ENABLED: u8 = 1 << 3;
const LOST: u8 = 1 << 2;

/// Divisor for the clock at pin fCKi, with which the part filters A and B; MDR0, bit 7. The filter's clock must be at least four
/// times the frequency of A.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilterClock {
    /// The clock itself.
    Undivided = 0x00,
    /// Half of it.
    Halved = 0x80,
}

/// Why there is no count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Ls7366rError<E> {
    /// The bus failed.
    #[error("LS7366R: bus: {0:?}")]
    Bus(E),
    /// A mode register does not read back as it was written.
    #[error("LS7366R: MDR{register} reads {found:#04x}; expected {expected:#04x}")]
    Register {
        /// 0 or 1.
        register: u8,
        /// What was written.
        expected: u8,
        /// What it reads.
        found: u8,
    },
    /// The supply was lost: the count starts again from 0, at an unknown position.
    #[error("LS7366R: supply was lost (status {status:#04x})")]
    PowerLost {
        /// STR.
        status: u8,
    },
    /// Counting is not enabled: pin `CNT_EN` is low, or nothing answers.
    #[error("LS7366R: does not count (status {status:#04x}); expected bit 3")]
    Stopped {
        /// STR.
        status: u8,
    },
}

impl<E: core::fmt::Debug> IoError for Ls7366rError<E> {
    fn cause(&self) -> Cause {
        match *self {
            Ls7366rError::Bus(_) => Cause::Bus,
            Ls7366rError::Register { expected, found, .. } => {
                Cause::WrongAnswer { expected: expected.into(), found: found.into() }
            }
            Ls7366rError::PowerLost { .. } => Cause::PowerLost,
            Ls7366rError::Stopped { status } => Cause::WrongAnswer { expected: ENABLED.into(), found: status.into() },
        }
    }
}

/// A mode register.
#[derive(Clone, Copy)]
pub(super) struct Mode {
    register: u8,
    write: u8,
    read: u8,
}

impl Mode {
    pub(super) fn writing(self, value: u8) -> [u8; 2] {
        [self.write, value]
    }

    pub(super) fn reading(self) -> [u8; 2] {
        [self.read, 0]
    }

    /// Whether it reads as it was written.
    pub(super) fn confirmed<E>(self, expected: u8, [_, found]: [u8; 2]) -> Result<(), Ls7366rError<E>> {
        let Self { register, .. } = self;
        if found == expected { Ok(()) } else { Err(Ls7366rError::Register { register, expected, found }) }
    }
}

/// Whether the part still counts as it was set up, by its status.
pub(super) fn counts<E>([_, status]: [u8; 2]) -> Result<(), Ls7366rError<E>> {
    if status & LOST != 0 {
        Err(Ls7366rError::PowerLost { status })
    } else if status & ENABLED == 0 {
        Err(Ls7366rError::Stopped { status })
    } else {
        Ok(())
    }
}

/// The count in an answer, highest byte first.
pub(super) fn count([_, count @ ..]: [u8; 5]) -> i32 {
    i32::from_be_bytes(count)
}
