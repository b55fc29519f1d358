//! The ADS8688 on its bus: which frames, in which order. The frames themselves are in [`ads8688`](crate::io::ads8688).

use super::device::AnalogIn;
use super::{SpiDevice, twice};
use crate::io::ads8688::{
    Ads8688Error, CHANNELS, FEATURES, FEATURES_VALUE, FIRST_RANGE, POWER_DOWN, RESET, Range, confirmed, count, reading,
    selecting, writing,
};

/// The part on its bus.
#[derive(Debug)]
pub struct Ads8688<SPI> {
    spi: SPI,
    /// Range of each channel in use; a channel without one is powered down.
    ranges: [Option<Range>; CHANNELS],
    /// Channel that the next frame converts, where that is certain.
    selected: Option<u8>,
}

#[twice]
impl<SPI: SpiDevice> Ads8688<SPI> {
    /// Resets the part, sets its ranges and reads everything back. Channels without a range are powered down.
    ///
    /// # Errors
    /// The bus fails, or a register does not read back as it was written.
    pub async fn begin(spi: SPI, ranges: [Option<Range>; CHANNELS]) -> Result<Self, Ads8688Error<SPI::Error>> {
        let mut part = Self { spi, ranges, selected: None };
        part.configure().await?;
        Ok(part)
    }

    /// Does the same again, after the part lost its configuration.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub async fn configure(&mut self) -> Result<(), Ads8688Error<SPI::Error>> {
        self.selected = None;
        self.spi.write(&RESET).await.map_err(Ads8688Error::Bus)?;
        let mut unused = 0;
        for (bit, range) in self.ranges.iter().enumerate() {
            unused |= u8::from(range.is_none()) << bit;
        }
        self.set(FEATURES, FEATURES_VALUE).await?;
        self.set(POWER_DOWN, unused).await?;
        for (register, range) in (FIRST_RANGE..).zip(self.ranges) {
            if let Some(range) = range {
                self.set(register, range as u8).await?;
            }
        }
        Ok(())
    }

    /// Gives the bus back.
    pub fn release(self) -> SPI {
        self.spi
    }

    /// Writes a program register and reads it back.
    async fn set(&mut self, register: u8, value: u8) -> Result<(), Ads8688Error<SPI::Error>> {
        self.spi.write(&writing(register, value)).await.map_err(Ads8688Error::Bus)?;
        let mut answer = [0; 3];
        self.spi.transfer(&mut answer, &reading(register)).await.map_err(Ads8688Error::Bus)?;
        confirmed(register, value, answer)
    }

    /// One frame: converts the channel that was selected before, and selects `next`.
    async fn frame(&mut self, next: u8) -> Result<[u8; 6], Ads8688Error<SPI::Error>> {
        let mut answer = [0; 6];
        self.spi.transfer(&mut answer, &selecting(next)).await.map_err(Ads8688Error::Bus)?;
        Ok(answer)
    }

    /// The next channel in use after this one, in a cycle.
    fn after(&self, channel: u8) -> u8 {
        let in_use = |number: &u8| self.ranges.get(usize::from(*number)).is_some_and(Option::is_some);
        (channel + 1..8).chain(0..channel).find(in_use).unwrap_or(channel)
    }
}

#[twice(AFIT)]
impl<SPI: SpiDevice> AnalogIn for Ads8688<SPI> {
    type Error = Ads8688Error<SPI::Error>;
    const SPAN_UV: u32 = 5_120_000;

    async fn convert(&mut self, channel: u8) -> Result<i32, Self::Error> {
        let range = self.ranges.get(usize::from(channel)).copied().flatten();
        let range = range.ok_or(Ads8688Error::NotInUse { channel })?;
        // Uncertain until the part has given the right answer.
        if self.selected.take() != Some(channel) {
            self.frame(channel).await?;
        }
        let next = self.after(channel);
        let count = count(channel, range, self.frame(next).await?)?;
        self.selected = Some(next);
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use embedded_hal::spi::ErrorKind;
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};

    use super::super::block_on;
    use super::*;
    use crate::io::{Cause, IoError};
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

    #[twice]
    async fn part(then: &[Vec<Transaction<u8>>]) -> Ads8688<Mock<u8>> {
        let all = [start(), then.concat()].concat();
        Ads8688::begin(Mock::new(&all), RANGES).await.unwrap()
    }

    #[twice]
    #[test]
    fn channels_in_rising_order_cost_one_frame_each_and_any_other_order_two() {
        let frames = [
            asked(&[0xC0, 0, 0, 0, 0, 0], &[0, 0, 0x12, 0x34, 0, 0]), // whatever was selected before
            asked(&[0xCC, 0, 0, 0, 0, 0], &[0, 0, 0xC0, 0x00, 0x08, 0x00]), // channel 0: half of +10.24 V
            asked(&[0xDC, 0, 0, 0, 0, 0], &[0, 0, 0x80, 0x00, 0x3B, 0x00]), // channel 3: half of 5.12 V
            asked(&[0xC0, 0, 0, 0, 0, 0], &[0, 0, 0x00, 0x00, 0x78, 0x80]), // channel 7: -5.12 V
            asked(&[0xDC, 0, 0, 0, 0, 0], &[0, 0, 0x00, 0x00, 0x08, 0x00]), // channel 7 again: select it …
            asked(&[0xC0, 0, 0, 0, 0, 0], &[0, 0, 0x80, 0x01, 0x78, 0x80]), // … and convert
        ];
        let (counts, mut spi) = block_on(async {
            let mut part = part(&frames).await;
            let mut counts = [0; 4];
            for (count, channel) in counts.iter_mut().zip([0, 3, 7, 7]) {
                *count = part.convert(channel).await.unwrap();
            }
            (counts, part.release())
        });
        // 5.12 V, 2.56 V, -5.12 V, one step of 156.25 µV.
        assert_eq!(counts, [65_536, 32_768, -65_536, 2]);
        spi.done();
    }

    #[twice]
    #[test]
    fn a_register_that_reads_otherwise_is_named() {
        let frames = [written(&[0x85, 0, 0, 0]), register(0x03, 0x83, 0x83), register(0x02, 0x76, 0xFF)].concat();
        let mut spi = Mock::new(&frames);
        let refused = block_on(async { Ads8688::begin(&mut spi, RANGES).await.err() });
        assert_eq!(refused, Some(Ads8688Error::Register { register: 2, expected: 0x76, found: 0xFF }));
        spi.done();
    }

    #[twice]
    #[test]
    fn lines_that_hang_and_a_part_that_fell_back_to_its_defaults_are_wrong_answers() {
        let select = asked(&[0xC0, 0, 0, 0, 0, 0], &[0; 6]);
        for (answer, found) in [([0xFF; 6], 0xFFFF), ([0; 6], 0), ([0, 0, 0x80, 0, 0x00, 0x00], 0)] {
            let frames = [
                select.clone(),
                asked(&[0xCC, 0, 0, 0, 0, 0], &answer),
                // The next attempt selects anew and succeeds.
                select.clone(),
                asked(&[0xCC, 0, 0, 0, 0, 0], &[0, 0, 0x80, 0, 0x08, 0]),
            ];
            let (refused, again, mut spi) = block_on(async {
                let mut part = part(&frames).await;
                let refused = part.convert(0).await.unwrap_err();
                (refused, part.convert(0).await, part.release())
            });
            assert_eq!(refused, Ads8688Error::Tag { expected: 0x0800, found });
            assert_eq!(refused.cause(), Cause::WrongAnswer { expected: 0x0800, found: found.into() });
            assert_eq!(again, Ok(0));
            spi.done();
        }
    }

    #[twice]
    #[test]
    fn an_open_input_reads_a_voltage_like_any_other() {
        // 2.2 V on ±10.24 V: code 0x8000 + 2.2 V / 312.5 µV.  Only the limits of the calibration table can detect it.
        let frames =
            [asked(&[0xC0, 0, 0, 0, 0, 0], &[0; 6]), asked(&[0xCC, 0, 0, 0, 0, 0], &[0, 0, 0x9B, 0x80, 0x08, 0])];
        let (count, mut spi) = block_on(async {
            let mut part = part(&frames).await;
            (part.convert(0).await, part.release())
        });
        assert_eq!(count, Ok(28_160));
        spi.done();
    }

    #[twice]
    #[test]
    fn a_channel_without_a_range_is_refused_before_the_bus_is_used() {
        let (refused, mut spi) = block_on(async {
            let mut part = part(&[]).await;
            ([part.convert(1).await, part.convert(8).await], part.release())
        });
        assert_eq!(refused, [1, 8].map(|channel| Err(Ads8688Error::NotInUse { channel })));
        spi.done();
    }

    #[twice]
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
        let (refused, again, spi) = block_on(async {
            let mut part = Ads8688::begin(spi, RANGES).await.unwrap();
            let refused = part.convert(0).await.unwrap_err();
            (refused, part.convert(0).await, part.release())
        });
        assert_eq!((refused, refused.cause()), (Ads8688Error::Bus(ErrorKind::Other), Cause::Bus));
        assert_eq!(again, Ok(0));
        spi.release().done();
    }
}
