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

use embedded_hal::spi::SpiDevice;

use crate::io::{Cause, IoError, PositionIn};

const CLEAR_COUNT: u8 = 0x20;
const CLEAR_STATUS: u8 = 0x30;
const READ_MODE_0: u8 = 0x48;
const READ_MODE_1: u8 = 0x50;
const READ_COUNT: u8 = 0x60;
const READ_STATUS: u8 = 0x70;
const WRITE_MODE_0: u8 = 0x88;
const WRITE_MODE_1: u8 = 0x90;
/// MDR0: four counts per period of the encoder, free running, index unused.
const FOURFOLD: u8 = 0x03;
/// MDR1: four bytes, counting enabled, no flags.
const FOUR_BYTES: u8 = 0x00;
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

/// The part on its bus.
#[derive(Debug)]
pub struct Ls7366r<SPI> {
    spi: SPI,
}

impl<SPI: SpiDevice> Ls7366r<SPI> {
    /// Sets the part up, reads its mode back and clears the count.
    ///
    /// # Errors
    /// The bus fails, or the part does not answer as it must.
    pub fn begin(spi: SPI, filter: FilterClock) -> Result<Self, Ls7366rError<SPI::Error>> {
        let mut part = Self { spi };
        part.instruct(&[CLEAR_STATUS])?;
        part.set(0, [WRITE_MODE_0, READ_MODE_0], FOURFOLD | filter as u8)?;
        part.set(1, [WRITE_MODE_1, READ_MODE_1], FOUR_BYTES)?;
        part.instruct(&[CLEAR_COUNT])?;
        part.check()?;
        Ok(part)
    }

    /// Gives the bus back.
    pub fn release(self) -> SPI {
        self.spi
    }

    fn instruct(&mut self, bytes: &[u8]) -> Result<(), Ls7366rError<SPI::Error>> {
        self.spi.write(bytes).map_err(Ls7366rError::Bus)
    }

    /// Sends an instruction and reads the bytes that answer it.
    fn read<const BYTES: usize>(&mut self, bytes: [u8; BYTES]) -> Result<[u8; BYTES], Ls7366rError<SPI::Error>> {
        let mut answer = [0; BYTES];
        self.spi.transfer(&mut answer, &bytes).map_err(Ls7366rError::Bus)?;
        Ok(answer)
    }

    /// Writes a mode register and reads it back.
    fn set(&mut self, register: u8, [write, read]: [u8; 2], expected: u8) -> Result<(), Ls7366rError<SPI::Error>> {
        self.instruct(&[write, expected])?;
        let [_, found] = self.read([read, 0])?;
        if found == expected { Ok(()) } else { Err(Ls7366rError::Register { register, expected, found }) }
    }

    /// Whether the part still counts as it was set up.
    fn check(&mut self) -> Result<(), Ls7366rError<SPI::Error>> {
        let [_, status] = self.read([READ_STATUS, 0])?;
        if status & LOST != 0 {
            Err(Ls7366rError::PowerLost { status })
        } else if status & ENABLED == 0 {
            Err(Ls7366rError::Stopped { status })
        } else {
            Ok(())
        }
    }
}

impl<SPI: SpiDevice> PositionIn for Ls7366r<SPI> {
    type Error = Ls7366rError<SPI::Error>;

    fn count(&mut self) -> Result<i32, Self::Error> {
        self.check()?;
        let [_, count @ ..] = self.read([READ_COUNT, 0, 0, 0, 0])?;
        Ok(i32::from_be_bytes(count))
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use embedded_hal::spi::ErrorKind;
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};

    use super::*;
    use crate::mock::{Failing, asked, written};

    fn start() -> Vec<Transaction<u8>> {
        [
            written(&[0x30]),
            written(&[0x88, 0x83]),
            asked(&[0x48, 0], &[0, 0x83]),
            written(&[0x90, 0x00]),
            asked(&[0x50, 0], &[0, 0x00]),
            written(&[0x20]),
            status(0x08),
        ]
        .concat()
    }

    fn status(found: u8) -> Vec<Transaction<u8>> {
        asked(&[0x70, 0], &[0, found])
    }

    #[test]
    fn a_count_is_four_bytes_highest_first_with_sign() {
        let frames = [
            start(),
            status(0x0A),
            asked(&[0x60, 0, 0, 0, 0], &[0, 0x00, 0x00, 0x38, 0x40]),
            status(0x49),
            asked(&[0x60, 0, 0, 0, 0], &[0, 0xFF, 0xFF, 0xFF, 0xFE]),
        ];
        let mut part = Ls7366r::begin(Mock::new(&frames.concat()), FilterClock::Halved).unwrap();
        assert_eq!(part.count(), Ok(14_400));
        assert_eq!(part.count(), Ok(-2));
        part.release().done();
    }

    #[test]
    fn a_mode_register_that_reads_otherwise_is_named() {
        let frames = [written(&[0x30]), written(&[0x88, 0x03]), asked(&[0x48, 0], &[0, 0xFF])].concat();
        let mut spi = Mock::new(&frames);
        let refused = Ls7366r::begin(&mut spi, FilterClock::Undivided).err();
        assert_eq!(refused, Some(Ls7366rError::Register { register: 0, expected: 3, found: 0xFF }));
        spi.done();
    }

    #[test]
    fn a_lost_supply_and_lines_that_hang_are_not_taken_for_a_count() {
        let after = |found| {
            let frames = [start(), status(found)].concat();
            let mut part = Ls7366r::begin(Mock::new(&frames), FilterClock::Halved).unwrap();
            let refused = part.count().unwrap_err();
            part.release().done();
            (refused, refused.cause())
        };
        assert_eq!(after(0x0C), (Ls7366rError::PowerLost { status: 0x0C }, Cause::PowerLost));
        assert_eq!(after(0xFF), (Ls7366rError::PowerLost { status: 0xFF }, Cause::PowerLost));
        let hangs_low = (Ls7366rError::Stopped { status: 0 }, Cause::WrongAnswer { expected: 8, found: 0 });
        assert_eq!(after(0x00), hangs_low);
    }

    #[test]
    fn a_bus_error_is_handed_on_and_the_next_reading_is_whole() {
        let frames = [start(), status(0x08), status(0x08), asked(&[0x60, 0, 0, 0, 0], &[0, 0, 0, 0, 5])].concat();
        let mut part = Ls7366r::begin(Failing::at(Mock::new(&frames), 8), FilterClock::Halved).unwrap();
        assert_eq!(part.count(), Err(Ls7366rError::Bus(ErrorKind::Other)));
        assert_eq!(part.count(), Ok(5));
        part.release().release().done();
    }
}
