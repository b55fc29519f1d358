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

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::SpiDevice;

use crate::io::{AnalogOut, Cause, IoError};

/// Register and address bits of the first byte.
const RANGE: u8 = 0x08;
const POWER: u8 = 0x10;
const CONTROL: u8 = 0x19;
const NOP: u8 = 0x18;
const READ: u8 = 0x80;
/// Output range: ±10 V.
const BIPOLAR_10_V: u16 = 4;
/// Control: an output that is too hot is shut down; a shorted output is held at 20 mA and reported.
const PROTECTED: u16 = 0b1100;
/// Power control.
const REFERENCE_UP: u16 = 1 << 4;
const TOO_HOT: u16 = 1 << 5;
const FIRST_OVERCURRENT: u32 = 7;
/// From powering up to the first code: 10 µs, doubled.
const POWER_UP_US: u32 = 20;

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

/// One output of the part, on its bus.
#[derive(Debug)]
pub struct Ad5754<SPI> {
    spi: SPI,
    channel: Channel,
    /// Power control value while the output is up.
    powered: u16,
}

impl<SPI: SpiDevice> Ad5754<SPI> {
    /// First puts out `count`, whatever the part did before; then sets the part up, powers the output up and reads everything back.
    ///
    /// # Errors
    /// The bus fails, a register does not read back as it was written, or the output is overloaded.
    pub fn begin(
        spi: SPI,
        delay: &mut impl DelayNs,
        channel: Channel,
        reference: Reference,
        count: i32,
    ) -> Result<Self, Ad5754Error<SPI::Error>> {
        let reference = if reference == Reference::Internal { REFERENCE_UP } else { 0 };
        let mut part = Self { spi, channel, powered: reference | 1 << channel as u16 };
        part.put_out(count)?;
        part.send(CONTROL, PROTECTED)?;
        part.send(RANGE | channel as u8, BIPOLAR_10_V)?;
        part.send(POWER, part.powered)?;
        delay.delay_us(POWER_UP_US);
        part.confirm(Register::Control, CONTROL, 0b1111, PROTECTED)?;
        part.confirm(Register::Range, RANGE | channel as u8, 0b111, BIPOLAR_10_V)?;
        part.write(count)?;
        Ok(part)
    }

    /// Gives the bus back.
    pub fn release(self) -> SPI {
        self.spi
    }

    fn send(&mut self, first: u8, data: u16) -> Result<(), Ad5754Error<SPI::Error>> {
        let [high, low] = data.to_be_bytes();
        self.spi.write(&[first, high, low]).map_err(Ad5754Error::Bus)
    }

    /// The code of the channel, held at the ends of its 16 bits.
    fn put_out(&mut self, count: i32) -> Result<(), Ad5754Error<SPI::Error>> {
        #[expect(clippy::cast_possible_truncation, reason = "held within 16 bits")]
        let code = count.clamp(i16::MIN.into(), i16::MAX.into()) as i16;
        self.send(self.channel as u8, code.cast_unsigned())
    }

    fn read(&mut self, first: u8) -> Result<u16, Ad5754Error<SPI::Error>> {
        self.spi.write(&[READ | first, 0, 0]).map_err(Ad5754Error::Bus)?;
        let mut answer = [0; 3];
        self.spi.transfer(&mut answer, &[NOP, 0, 0]).map_err(Ad5754Error::Bus)?;
        let [_, high, low] = answer;
        Ok(u16::from_be_bytes([high, low]))
    }

    /// Whether the bits of `mask` read as they were written.
    fn confirm(
        &mut self,
        register: Register,
        first: u8,
        mask: u16,
        expected: u16,
    ) -> Result<(), Ad5754Error<SPI::Error>> {
        let found = self.read(first)?;
        if found & mask == expected { Ok(()) } else { Err(Ad5754Error::Register { register, expected, found }) }
    }

    /// Whether the output is powered and not overloaded.
    fn check(&mut self) -> Result<(), Ad5754Error<SPI::Error>> {
        let found = self.read(POWER)?;
        let overcurrent = 1 << (FIRST_OVERCURRENT + self.channel as u32);
        // A line that is stuck high reads as power on for the other channels too, which were never powered up.
        if found & 0b1_1111 != self.powered {
            Err(Ad5754Error::Register { register: Register::Power, expected: self.powered, found })
        } else if found & TOO_HOT != 0 {
            Err(Ad5754Error::TooHot { found })
        } else if found & overcurrent != 0 {
            Err(Ad5754Error::Overcurrent { found })
        } else {
            Ok(())
        }
    }
}

impl<SPI: SpiDevice> AnalogOut for Ad5754<SPI> {
    type Error = Ad5754Error<SPI::Error>;
    const SPAN_UV: u32 = 20_000_000;

    fn write(&mut self, count: i32) -> Result<(), Self::Error> {
        self.put_out(count)?;
        self.check()
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use embedded_hal::spi::ErrorKind;
    use embedded_hal_mock::eh1::delay::NoopDelay;
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};

    use super::*;
    use crate::mock::{Failing, asked, written};

    fn read(first: u8, answer: [u8; 3]) -> Vec<Transaction<u8>> {
        [written(&[first, 0, 0]), asked(&[0x18, 0, 0], &answer)].concat()
    }

    /// A write of −1 (−305 µV), and then the power control register's answer.
    fn output(power: [u8; 3]) -> Vec<Transaction<u8>> {
        [written(&[0x01, 0xFF, 0xFF]), read(0x90, power)].concat()
    }

    /// Channel B with the internal reference.
    fn start(then: &[Vec<Transaction<u8>>]) -> Vec<Transaction<u8>> {
        let start = [
            written(&[0x01, 0x00, 0x05]), // code 5 before anything else
            written(&[0x19, 0x00, 0x0C]),
            written(&[0x09, 0x00, 0x04]),
            written(&[0x10, 0x00, 0x12]),
            read(0x99, [0x19, 0x00, 0x0C]),
            read(0x89, [0x09, 0x00, 0x04]),
            written(&[0x01, 0x00, 0x05]),
            read(0x90, [0x10, 0x00, 0x12]),
        ];
        [start.concat(), then.concat()].concat()
    }

    fn part<SPI: SpiDevice>(spi: SPI) -> Result<Ad5754<SPI>, Ad5754Error<SPI::Error>> {
        Ad5754::begin(spi, &mut NoopDelay::new(), Channel::B, Reference::Internal, 5)
    }

    #[test]
    fn a_count_is_a_code_in_twos_complement_held_at_the_ends() {
        let up = [0x10, 0x00, 0x12];
        let frames = start(&[
            output(up),
            written(&[0x01, 0x7F, 0xFF]),
            read(0x90, up),
            written(&[0x01, 0x80, 0x00]),
            read(0x90, up),
        ]);
        let mut part = part(Mock::new(&frames)).unwrap();
        part.write(-1).unwrap();
        part.write(40_000).unwrap();
        part.write(i32::MIN).unwrap();
        part.release().done();
    }

    #[test]
    fn a_range_that_reads_otherwise_is_named() {
        let mut frames = start(&[]);
        frames.truncate(3 * 4 + 6);
        let mut spi = Mock::new(&[frames, read(0x89, [0, 0, 0])].concat());
        let refused = part(&mut spi).err();
        assert_eq!(refused, Some(Ad5754Error::Register { register: Register::Range, expected: 4, found: 0 }));
        spi.done();
    }

    #[test]
    fn an_output_that_is_down_shorted_or_hot_is_an_error_of_the_write() {
        let after = |power| {
            let mut part = part(Mock::new(&start(&[output(power)]))).unwrap();
            let refused = part.write(-1).unwrap_err();
            part.release().done();
            (refused, refused.cause())
        };
        let down = |found| Ad5754Error::Register { register: Register::Power, expected: 0x12, found };
        assert_eq!(after([0, 0, 0]), (down(0), Cause::WrongAnswer { expected: 0x12, found: 0 }));
        assert_eq!(after([0xFF, 0xFF, 0xFF]).0, down(0xFFFF));
        assert_eq!(after([0, 0x01, 0x12]), (Ad5754Error::Overcurrent { found: 0x112 }, Cause::Overloaded));
        assert_eq!(after([0, 0x00, 0x32]), (Ad5754Error::TooHot { found: 0x32 }, Cause::Overloaded));
    }

    #[test]
    fn a_bus_error_is_handed_on_and_the_next_write_is_whole() {
        let frames = start(&[output([0, 0, 0x12])]);
        let mut part = part(Failing::at(Mock::new(&frames), 11)).unwrap();
        assert_eq!(part.write(7), Err(Ad5754Error::Bus(ErrorKind::Other)));
        assert_eq!(part.write(-1), Ok(()));
        part.release().release().done();
    }
}
