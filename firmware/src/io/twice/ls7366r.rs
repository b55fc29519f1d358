//! The LS7366R on its bus: which frames, in which order. The frames themselves are in [`ls7366r`](crate::io::ls7366r).

use super::device::PositionIn;
use super::{SpiDevice, twice};
use crate::io::ls7366r::{
    CLEAR_COUNT, CLEAR_STATUS, FOUR_BYTES, FOURFOLD, FilterClock, Ls7366rError, MODE_0, MODE_1, Mode, READ_COUNT,
    READ_STATUS, count, counts,
};

/// The part on its bus.
#[derive(Debug)]
pub struct Ls7366r<SPI> {
    spi: SPI,
}

#[twice]
impl<SPI: SpiDevice> Ls7366r<SPI> {
    /// Sets the part up, reads its mode back and clears the count.
    ///
    /// # Errors
    /// The bus fails, or the part does not answer as it must.
    pub async fn begin(spi: SPI, filter: FilterClock) -> Result<Self, Ls7366rError<SPI::Error>> {
        let mut part = Self { spi };
        part.instruct(&CLEAR_STATUS).await?;
        part.set(MODE_0, FOURFOLD | filter as u8).await?;
        part.set(MODE_1, FOUR_BYTES).await?;
        part.instruct(&CLEAR_COUNT).await?;
        counts(part.read(READ_STATUS).await?)?;
        Ok(part)
    }

    /// Gives the bus back.
    pub fn release(self) -> SPI {
        self.spi
    }

    async fn instruct(&mut self, bytes: &[u8]) -> Result<(), Ls7366rError<SPI::Error>> {
        self.spi.write(bytes).await.map_err(Ls7366rError::Bus)
    }

    /// Sends an instruction and reads the bytes that answer it.
    async fn read<const BYTES: usize>(&mut self, bytes: [u8; BYTES]) -> Result<[u8; BYTES], Ls7366rError<SPI::Error>> {
        let mut answer = [0; BYTES];
        self.spi.transfer(&mut answer, &bytes).await.map_err(Ls7366rError::Bus)?;
        Ok(answer)
    }

    /// Writes a mode register and reads it back.
    async fn set(&mut self, mode: Mode, value: u8) -> Result<(), Ls7366rError<SPI::Error>> {
        self.instruct(&mode.writing(value)).await?;
        mode.confirmed(value, self.read(mode.reading()).await?)
    }
}

#[twice(AFIT)]
impl<SPI: SpiDevice> PositionIn for Ls7366r<SPI> {
    type Error = Ls7366rError<SPI::Error>;

    async fn count(&mut self) -> Result<i32, Self::Error> {
        counts(self.read(READ_STATUS).await?)?;
        Ok(count(self.read(READ_COUNT).await?))
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

    #[twice]
    #[test]
    fn a_count_is_four_bytes_highest_first_with_sign() {
        let frames = [
            start(),
            status(0x0A),
            asked(&[0x60, 0, 0, 0, 0], &[0, 0x00, 0x00, 0x38, 0x40]),
            status(0x49),
            asked(&[0x60, 0, 0, 0, 0], &[0, 0xFF, 0xFF, 0xFF, 0xFE]),
        ];
        let (counts, mut spi) = block_on(async {
            let mut part = Ls7366r::begin(Mock::new(&frames.concat()), FilterClock::Halved).await.unwrap();
            ([part.count().await, part.count().await], part.release())
        });
        assert_eq!(counts, [Ok(14_400), Ok(-2)]);
        spi.done();
    }

    #[twice]
    #[test]
    fn a_mode_register_that_reads_otherwise_is_named() {
        let frames = [written(&[0x30]), written(&[0x88, 0x03]), asked(&[0x48, 0], &[0, 0xFF])].concat();
        let mut spi = Mock::new(&frames);
        let refused = block_on(async { Ls7366r::begin(&mut spi, FilterClock::Undivided).await.err() });
        assert_eq!(refused, Some(Ls7366rError::Register { register: 0, expected: 3, found: 0xFF }));
        spi.done();
    }

    #[twice]
    #[test]
    fn a_lost_supply_and_lines_that_hang_are_not_taken_for_a_count() {
        let after = |found| {
            let frames = [start(), status(found)].concat();
            let (refused, mut spi) = block_on(async {
                let mut part = Ls7366r::begin(Mock::new(&frames), FilterClock::Halved).await.unwrap();
                (part.count().await.unwrap_err(), part.release())
            });
            spi.done();
            (refused, refused.cause())
        };
        assert_eq!(after(0x0C), (Ls7366rError::PowerLost { status: 0x0C }, Cause::PowerLost));
        assert_eq!(after(0xFF), (Ls7366rError::PowerLost { status: 0xFF }, Cause::PowerLost));
        let hangs_low = (Ls7366rError::Stopped { status: 0 }, Cause::WrongAnswer { expected: 8, found: 0 });
        assert_eq!(after(0x00), hangs_low);
    }

    #[twice]
    #[test]
    fn a_bus_error_is_handed_on_and_the_next_reading_is_whole() {
        let frames = [start(), status(0x08), status(0x08), asked(&[0x60, 0, 0, 0, 0], &[0, 0, 0, 0, 5])].concat();
        let spi = Failing::at(Mock::new(&frames), 8);
        let (refused, again, spi) = block_on(async {
            let mut part = Ls7366r::begin(spi, FilterClock::Halved).await.unwrap();
            (part.count().await, part.count().await, part.release())
        });
        assert_eq!((refused, again), (Err(Ls7366rError::Bus(ErrorKind::Other)), Ok(5)));
        spi.release().done();
    }
}
