//! The AD5754 on its bus: which frames, in which order. The frames themselves are in [`ad5754`](crate::io::ad5754).

use super::device::AnalogOut;
use super::{DelayNs, SpiDevice, twice};
use crate::io::ad5754::{
    Ad5754Error, BIPOLAR_10_V, CONTROL, Channel, NOP, POWER, POWER_UP_US, PROTECTED, RANGE, REFERENCE_UP, Reference,
    Register, confirmed, data, healthy, putting_out, requesting, writing,
};

/// One output of the part, on its bus.
#[derive(Debug)]
pub struct Ad5754<SPI> {
    spi: SPI,
    channel: Channel,
    /// Power control value while the output is up.
    powered: u16,
}

#[twice]
impl<SPI: SpiDevice> Ad5754<SPI> {
    /// First puts out `count`, whatever the part did before; then sets the part up, powers the output up and reads everything back.
    ///
    /// # Errors
    /// The bus fails, a register does not read back as it was written, or the output is overloaded.
    pub async fn begin(
        spi: SPI,
        delay: &mut impl DelayNs,
        channel: Channel,
        reference: Reference,
        count: i32,
    ) -> Result<Self, Ad5754Error<SPI::Error>> {
        let reference = if reference == Reference::Internal { REFERENCE_UP } else { 0 };
        let mut part = Self { spi, channel, powered: reference | 1 << channel as u16 };
        part.send(putting_out(channel, count)).await?;
        part.send(writing(CONTROL, PROTECTED)).await?;
        part.send(writing(RANGE | channel as u8, BIPOLAR_10_V)).await?;
        part.send(writing(POWER, part.powered)).await?;
        delay.delay_us(POWER_UP_US).await;
        confirmed(Register::Control, 0b1111, PROTECTED, part.read(CONTROL).await?)?;
        confirmed(Register::Range, 0b111, BIPOLAR_10_V, part.read(RANGE | channel as u8).await?)?;
        part.write(count).await?;
        Ok(part)
    }

    /// Gives the bus back.
    pub fn release(self) -> SPI {
        self.spi
    }

    async fn send(&mut self, frame: [u8; 3]) -> Result<(), Ad5754Error<SPI::Error>> {
        self.spi.write(&frame).await.map_err(Ad5754Error::Bus)
    }

    async fn read(&mut self, first: u8) -> Result<u16, Ad5754Error<SPI::Error>> {
        self.send(requesting(first)).await?;
        let mut answer = [0; 3];
        self.spi.transfer(&mut answer, &NOP).await.map_err(Ad5754Error::Bus)?;
        Ok(data(answer))
    }
}

#[twice(AFIT)]
impl<SPI: SpiDevice> AnalogOut for Ad5754<SPI> {
    type Error = Ad5754Error<SPI::Error>;
    const SPAN_UV: u32 = 20_000_000;

    async fn write(&mut self, count: i32) -> Result<(), Self::Error> {
        self.send(putting_out(self.channel, count)).await?;
        healthy(self.channel, self.powered, self.read(POWER).await?)
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use embedded_hal::spi::ErrorKind;
    use embedded_hal_mock::eh1::delay::NoopDelay;
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};

    use super::super::block_on;
    use super::*;
    use crate::io::{Cause, IoError};
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

    #[twice]
    async fn part<SPI: SpiDevice>(spi: SPI) -> Result<Ad5754<SPI>, Ad5754Error<SPI::Error>> {
        Ad5754::begin(spi, &mut NoopDelay::new(), Channel::B, Reference::Internal, 5).await
    }

    #[twice]
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
        let mut spi = block_on(async {
            let mut part = part(Mock::new(&frames)).await.unwrap();
            for count in [-1, 40_000, i32::MIN] {
                part.write(count).await.unwrap();
            }
            part.release()
        });
        spi.done();
    }

    #[twice]
    #[test]
    fn a_range_that_reads_otherwise_is_named() {
        let mut frames = start(&[]);
        frames.truncate(3 * 4 + 6);
        let mut spi = Mock::new(&[frames, read(0x89, [0, 0, 0])].concat());
        let refused = block_on(async { part(&mut spi).await.err() });
        assert_eq!(refused, Some(Ad5754Error::Register { register: Register::Range, expected: 4, found: 0 }));
        spi.done();
    }

    #[twice]
    #[test]
    fn an_output_that_is_down_shorted_or_hot_is_an_error_of_the_write() {
        let after = |power| {
            let (refused, mut spi) = block_on(async {
                let mut part = part(Mock::new(&start(&[output(power)]))).await.unwrap();
                (part.write(-1).await.unwrap_err(), part.release())
            });
            spi.done();
            (refused, refused.cause())
        };
        let down = |found| Ad5754Error::Register { register: Register::Power, expected: 0x12, found };
        assert_eq!(after([0, 0, 0]), (down(0), Cause::WrongAnswer { expected: 0x12, found: 0 }));
        assert_eq!(after([0xFF, 0xFF, 0xFF]).0, down(0xFFFF));
        assert_eq!(after([0, 0x01, 0x12]), (Ad5754Error::Overcurrent { found: 0x112 }, Cause::Overloaded));
        assert_eq!(after([0, 0x00, 0x32]), (Ad5754Error::TooHot { found: 0x32 }, Cause::Overloaded));
    }

    #[twice]
    #[test]
    fn a_bus_error_is_handed_on_and_the_next_write_is_whole() {
        let frames = start(&[output([0, 0, 0x12])]);
        let (refused, again, spi) = block_on(async {
            let mut part = part(Failing::at(Mock::new(&frames), 11)).await.unwrap();
            (part.write(7).await, part.write(-1).await, part.release())
        });
        assert_eq!(refused, Err(Ad5754Error::Bus(ErrorKind::Other)));
        assert_eq!(again, Ok(()));
        spi.release().done();
    }
}
