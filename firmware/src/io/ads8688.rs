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

use embedded_hal::spi::SpiDevice;

use crate::io::{AnalogIn, Cause, IoError};

/// Channels of the part.
pub const CHANNELS: usize = 8;

/// Command register, table 6: reset the program registers.
const RESET: u8 = 0x85;
/// Command register, table 6: select channel 0; each further one is 4 more.
const MANUAL: u8 = 0xC0;
/// Program registers, 8.5.2.2.
const POWER_DOWN: u8 = 0x02;
const FEATURES: u8 = 0x03;
const FIRST_RANGE: u8 = 0x05;
/// Number that is given to the part, `DEV[1:0]`.
const NUMBER: u8 = 2;
/// `DEV` and `SDO[2:0]` = 3: result, channel, number, range.
const FEATURES_VALUE: u8 = NUMBER << 6 | 3;

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
    fn counts(self, code: u16) -> i32 {
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

/// The part on its bus.
#[derive(Debug)]
pub struct Ads8688<SPI> {
    spi: SPI,
    /// Range of each channel in use; a channel without one is powered down.
    ranges: [Option<Range>; CHANNELS],
    /// Channel that the next frame converts, where that is certain.
    selected: Option<u8>,
}

impl<SPI: SpiDevice> Ads8688<SPI> {
    /// Resets the part, sets its ranges and reads everything back. Channels without a range are powered down.
    ///
    /// # Errors
    /// The bus fails, or a register does not read back as it was written.
    pub fn begin(spi: SPI, ranges: [Option<Range>; CHANNELS]) -> Result<Self, Ads8688Error<SPI::Error>> {
        let mut part = Self { spi, ranges, selected: None };
        part.configure()?;
        Ok(part)
    }

    /// Does the same again, after the part lost its configuration.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn configure(&mut self) -> Result<(), Ads8688Error<SPI::Error>> {
        self.selected = None;
        self.spi.write(&[RESET, 0, 0, 0]).map_err(Ads8688Error::Bus)?;
        let mut unused = 0;
        for (bit, range) in self.ranges.iter().enumerate() {
            unused |= u8::from(range.is_none()) << bit;
        }
        self.set(FEATURES, FEATURES_VALUE)?;
        self.set(POWER_DOWN, unused)?;
        for (register, range) in (FIRST_RANGE..).zip(self.ranges) {
            if let Some(range) = range {
                self.set(register, range as u8)?;
            }
        }
        Ok(())
    }

    /// Gives the bus back.
    pub fn release(self) -> SPI {
        self.spi
    }

    /// Writes a program register and reads it back. 8.5.2.1.
    fn set(&mut self, register: u8, expected: u8) -> Result<(), Ads8688Error<SPI::Error>> {
        self.spi.write(&[register << 1 | 1, expected, 0]).map_err(Ads8688Error::Bus)?;
        let mut answer = [0; 3];
        self.spi.transfer(&mut answer, &[register << 1, 0, 0]).map_err(Ads8688Error::Bus)?;
        let [.., found] = answer;
        if found == expected { Ok(()) } else { Err(Ads8688Error::Register { register, expected, found }) }
    }

    /// One frame: converts the channel that was selected before, and selects `next`. Returns result and tag.
    fn frame(&mut self, next: u8) -> Result<(u16, u16), Ads8688Error<SPI::Error>> {
        let mut answer = [0; 6];
        self.spi.transfer(&mut answer, &[MANUAL | next << 2, 0, 0, 0, 0, 0]).map_err(Ads8688Error::Bus)?;
        let [_, _, high, low, tag_high, tag_low] = answer;
        Ok((u16::from_be_bytes([high, low]), u16::from_be_bytes([tag_high, tag_low])))
    }

    /// The next channel in use after this one, in a cycle.
    fn after(&self, channel: u8) -> u8 {
        let in_use = |number: &u8| self.ranges.get(usize::from(*number)).is_some_and(Option::is_some);
        (channel + 1..8).chain(0..channel).find(in_use).unwrap_or(channel)
    }
}

impl<SPI: SpiDevice> AnalogIn for Ads8688<SPI> {
    type Error = Ads8688Error<SPI::Error>;
    const SPAN_UV: u32 = 5_120_000;

    fn convert(&mut self, channel: u8) -> Result<i32, Self::Error> {
        let range = self.ranges.get(usize::from(channel)).copied().flatten();
        let range = range.ok_or(Ads8688Error::NotInUse { channel })?;
        // Uncertain until the part has given the right answer.
        if self.selected.take() != Some(channel) {
            self.frame(channel)?;
        }
        let next = self.after(channel);
        let (code, found) = self.frame(next)?;
        let expected = u16::from(channel) << 12 | u16::from(NUMBER) << 10 | (range as u16) << 7;
        if found != expected {
            return Err(Ads8688Error::Tag { expected, found });
        }
        self.selected = Some(next);
        Ok(range.counts(code))
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use embedded_hal::spi::ErrorKind;
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};
    use proptest::prelude::*;

    use super::*;
    use crate::mock::{Failing, asked, written};

    const RANGES: [Option<Range>; CHANNELS] =
        [Some(Range::Bipolar10V), None, None, Some(Range::Unipolar5V), None, None, None, Some(Range::Bipolar5V)];

    fn register(address: u8, value: u8, found: u8) -> Vec<Transaction<u8>> {
        [written(&[address * 2 + 1, value, 0]), asked(&[address * 2, 0, 0], &[0, 0, found])].concat()
    }

    fn start() -> Vec<Transaction<u8>> {
        [
            written(&[0x85, 0, 0, 0]),
            register(0x03, 0x83, 0x83),
            register(0x02, 0b0111_0110, 0b0111_0110),
            register(0x05, 0, 0),
            register(0x08, 6, 6),
            register(0x0C, 1, 1),
        ]
        .concat()
    }

    fn part(then: &[Vec<Transaction<u8>>]) -> Ads8688<Mock<u8>> {
        let all = [start(), then.concat()].concat();
        Ads8688::begin(Mock::new(&all), RANGES).unwrap()
    }

    #[test]
    fn channels_in_rising_order_cost_one_frame_each_and_any_other_order_two() {
        let mut part = part(&[
            asked(&[0xC0, 0, 0, 0, 0, 0], &[0, 0, 0x12, 0x34, 0, 0]), // whatever was selected before
            asked(&[0xCC, 0, 0, 0, 0, 0], &[0, 0, 0xC0, 0x00, 0x08, 0x00]), // channel 0: half of +10.24 V
            asked(&[0xDC, 0, 0, 0, 0, 0], &[0, 0, 0x80, 0x00, 0x3B, 0x00]), // channel 3: half of 5.12 V
            asked(&[0xC0, 0, 0, 0, 0, 0], &[0, 0, 0x00, 0x00, 0x78, 0x80]), // channel 7: -5.12 V
            asked(&[0xDC, 0, 0, 0, 0, 0], &[0, 0, 0x00, 0x00, 0x08, 0x00]), // channel 7 again: select it …
            asked(&[0xC0, 0, 0, 0, 0, 0], &[0, 0, 0x80, 0x01, 0x78, 0x80]), // … and convert
        ]);
        assert_eq!(part.convert(0), Ok(65_536)); // 5.12 V
        assert_eq!(part.convert(3), Ok(32_768)); // 2.56 V
        assert_eq!(part.convert(7), Ok(-65_536)); // -5.12 V
        assert_eq!(part.convert(7), Ok(2)); // one step of 156.25 µV
        part.release().done();
    }

    #[test]
    fn a_register_that_reads_otherwise_is_named() {
        let frames = [written(&[0x85, 0, 0, 0]), register(0x03, 0x83, 0x83), register(0x02, 0x76, 0xFF)].concat();
        let mut spi = Mock::new(&frames);
        let refused = Ads8688::begin(&mut spi, RANGES).err();
        assert_eq!(refused, Some(Ads8688Error::Register { register: 2, expected: 0x76, found: 0xFF }));
        spi.done();
    }

    #[test]
    fn lines_that_hang_and_a_part_that_fell_back_to_its_defaults_are_wrong_answers() {
        let select = asked(&[0xC0, 0, 0, 0, 0, 0], &[0; 6]);
        for (answer, found) in [([0xFF; 6], 0xFFFF), ([0; 6], 0), ([0, 0, 0x80, 0, 0x00, 0x00], 0)] {
            let mut part = part(&[
                select.clone(),
                asked(&[0xCC, 0, 0, 0, 0, 0], &answer),
                // The next attempt selects anew and succeeds.
                select.clone(),
                asked(&[0xCC, 0, 0, 0, 0, 0], &[0, 0, 0x80, 0, 0x08, 0]),
            ]);
            let refused = part.convert(0).unwrap_err();
            assert_eq!(refused, Ads8688Error::Tag { expected: 0x0800, found });
            assert_eq!(refused.cause(), Cause::WrongAnswer { expected: 0x0800, found: found.into() });
            assert_eq!(part.convert(0), Ok(0));
            part.release().done();
        }
    }

    #[test]
    fn an_open_input_reads_a_voltage_like_any_other() {
        // 2.2 V on ±10.24 V: code 0x8000 + 2.2 V / 312.5 µV.  Only the limits of the calibration table can detect it.
        let mut part = part(&[
            asked(&[0xC0, 0, 0, 0, 0, 0], &[0; 6]),
            asked(&[0xCC, 0, 0, 0, 0, 0], &[0, 0, 0x9B, 0x80, 0x08, 0]),
        ]);
        assert_eq!(part.convert(0), Ok(28_160));
        part.release().done();
    }

    #[test]
    fn a_channel_without_a_range_is_refused_before_the_bus_is_used() {
        let mut part = part(&[]);
        assert_eq!(part.convert(1), Err(Ads8688Error::NotInUse { channel: 1 }));
        assert_eq!(part.convert(8), Err(Ads8688Error::NotInUse { channel: 8 }));
        part.release().done();
    }

    #[test]
    fn a_bus_error_is_handed_on_and_the_channel_selected_anew() {
        let frames = [
            start(),
            asked(&[0xC0, 0, 0, 0, 0, 0], &[0; 6]),
            // The frame that converts fails on the bus; then both are sent again.
            asked(&[0xC0, 0, 0, 0, 0, 0], &[0; 6]),
            asked(&[0xCC, 0, 0, 0, 0, 0], &[0, 0, 0x80, 0, 0x08, 0]),
        ];
        // Eleven transactions at the start, one that selects, and then the failing one.
        let spi = Failing::at(Mock::new(&frames.concat()), 12);
        let mut part = Ads8688::begin(spi, RANGES).unwrap();
        let refused = part.convert(0).unwrap_err();
        assert_eq!((refused, refused.cause()), (Ads8688Error::Bus(ErrorKind::Other), Cause::Bus));
        assert_eq!(part.convert(0), Ok(0));
        part.release().release().done();
    }

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
