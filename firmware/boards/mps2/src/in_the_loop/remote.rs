//! Parts at the other end of a serial line: SPI devices whose frames go over it, for a processor in the loop.
//!
//! The drivers run on the target as they would on a board; a simulation answers. The target starts every exchange, so both sides stay in
//! step:
//!
//! | byte 0 | byte 1 | byte 2 | bytes | answer |
//! |---|---|---|---|---|
//! | number of the part | n, 0…255 | m, 0…255 | n bytes to the part | m bytes from the part |
//!
//! A part is clocked for the longer of n and m: it gets zeros after the n bytes, and its output after the m bytes is discarded. So a write
//! waits for no answer. [`SerialLine::exchange`] also serves what is not an SPI part: a request for a set point, or a report.

use core::cell::RefCell;

use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use embedded_io::{Read, ReadExactError, Write};

/// Most bytes of a frame.
pub const MOST_BYTES: usize = 255;

/// A serial line with parts at its other end.
#[derive(Debug)]
pub struct SerialLine<L> {
    line: RefCell<L>,
}

/// Why a frame failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RemoteError {
    /// The line failed or was closed.
    #[error("the line to the simulated parts failed")]
    Line,
    /// A frame is empty or too long.
    #[error("{bytes} bytes in a frame; expected 1 to 255")]
    Frame {
        /// Its bytes, in the longer direction.
        bytes: usize,
    },
}

impl embedded_hal::spi::Error for RemoteError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

impl embedded_io::Error for RemoteError {
    fn kind(&self) -> embedded_io::ErrorKind {
        embedded_io::ErrorKind::Other
    }
}

impl<L: Read + Write> SerialLine<L> {
    /// A line to parts.
    pub fn new(line: L) -> Self {
        Self { line: RefCell::new(line) }
    }

    /// Sends bytes to a part and takes its answer.
    ///
    /// # Errors
    /// The line fails, or the frame is empty or too long.
    pub fn exchange(&self, part: u8, sent: &[u8], answer: &mut [u8]) -> Result<(), RemoteError> {
        let bytes = sent.len().max(answer.len());
        let (Ok(to), Ok(from), 1..) = (u8::try_from(sent.len()), u8::try_from(answer.len()), bytes) else {
            return Err(RemoteError::Frame { bytes });
        };
        let mut line = self.line.try_borrow_mut().map_err(|_| RemoteError::Line)?;
        line.write_all(&[part, to, from]).and_then(|()| line.write_all(sent)).map_err(|_| RemoteError::Line)?;
        line.flush().map_err(|_| RemoteError::Line)?;
        line.read_exact(answer).map_err(|_: ReadExactError<_>| RemoteError::Line)
    }

    /// Waits for a byte from the other end; bytes before it are discarded.
    ///
    /// # Errors
    /// The line fails.
    pub fn wait_for(&self, byte: u8) -> Result<(), RemoteError> {
        let mut line = self.line.try_borrow_mut().map_err(|_| RemoteError::Line)?;
        let mut found = [0];
        loop {
            line.read_exact(&mut found).map_err(|_: ReadExactError<_>| RemoteError::Line)?;
            if found == [byte] {
                return Ok(());
            }
        }
    }

    /// The part of this number, as an SPI device.
    pub fn part(&self, number: u8) -> Part<'_, L> {
        Part { line: self, number }
    }
}

/// An SPI device at the other end of a line.
#[derive(Debug)]
pub struct Part<'a, L> {
    line: &'a SerialLine<L>,
    number: u8,
}

impl<L> ErrorType for Part<'_, L> {
    type Error = RemoteError;
}

impl<L: Read + Write> SpiDevice for Part<'_, L> {
    /// Each operation is a frame of its own: no driver here needs its part selected for longer.
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        for operation in operations {
            match operation {
                Operation::Read(answer) => self.line.exchange(self.number, &[], answer)?,
                Operation::Write(sent) => self.line.exchange(self.number, sent, &mut [])?,
                Operation::Transfer(answer, sent) => self.line.exchange(self.number, sent, answer)?,
                Operation::TransferInPlace(bytes) => {
                    let mut sent = [0; MOST_BYTES];
                    let length = bytes.len();
                    let sent = sent.get_mut(..length).ok_or(RemoteError::Frame { bytes: length })?;
                    sent.copy_from_slice(bytes);
                    self.line.exchange(self.number, sent, bytes)?;
                }
                Operation::DelayNs(_) => {}
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use core::convert::Infallible;
    use std::vec::Vec;

    use super::*;

    /// A part that answers every byte with the byte plus one.
    #[derive(Default)]
    struct Echo {
        sent: Vec<u8>,
        answer: Vec<u8>,
    }

    impl embedded_io::ErrorType for Echo {
        type Error = Infallible;
    }

    impl Write for Echo {
        fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
            self.sent.extend(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> Result<(), Infallible> {
            let mut frame = self.sent.split_off(3);
            let [7, to, from] = *self.sent else { panic!("{:?}", self.sent) };
            assert_eq!(frame.len(), usize::from(to));
            frame.resize(from.into(), 0);
            self.answer.extend(frame.iter().map(|byte| byte + 1));
            self.sent.clear();
            Ok(())
        }
    }

    impl Read for Echo {
        fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
            let count = bytes.len().min(self.answer.len());
            for (byte, answer) in bytes.iter_mut().zip(self.answer.drain(..count)) {
                *byte = answer;
            }
            Ok(count)
        }
    }

    #[test]
    fn what_a_part_is_asked_goes_over_the_line_and_its_answer_comes_back() {
        let line = SerialLine::new(Echo::default());
        let mut part = line.part(7);
        let (mut same, mut fewer, mut more) = ([0; 3], [0; 1], [0; 4]);
        part.transfer(&mut same, &[1, 2, 3]).unwrap();
        part.transfer(&mut fewer, &[4, 5]).unwrap();
        part.transfer(&mut more, &[6, 7]).unwrap();
        assert_eq!((same, fewer, more), ([2, 3, 4], [5], [7, 8, 1, 1]));
        part.transfer_in_place(&mut same).unwrap();
        part.read(&mut fewer).unwrap();
        assert_eq!((same, fewer), ([3, 4, 5], [1]));
    }

    #[test]
    fn nobody_answers_a_write() {
        let line = SerialLine::new(Echo::default());
        line.part(7).write(&[9, 8]).unwrap();
        assert!(line.line.borrow().answer.is_empty());
    }

    #[test]
    fn a_frame_that_is_empty_or_too_long_is_refused() {
        let line = SerialLine::new(Echo::default());
        assert_eq!(line.part(7).write(&[]), Err(RemoteError::Frame { bytes: 0 }));
        for refused in [
            line.part(7).write(&[0; 256]),
            line.part(7).read(&mut [0; 256]),
            line.part(7).transfer_in_place(&mut [0; 256]),
        ] {
            assert_eq!(refused, Err(RemoteError::Frame { bytes: 256 }));
        }
    }

    #[test]
    fn what_comes_before_the_awaited_byte_is_passed_over() {
        let line = SerialLine::new(Echo { answer: Vec::from([7, 0xA5, 3, 13]), ..Echo::default() });
        line.wait_for(0xA5).unwrap();
        assert_eq!(line.line.borrow().answer, [3, 13]);
        assert_eq!(line.wait_for(0xA5), Err(RemoteError::Line), "it never comes");
    }

    /// A line that was closed.
    struct Closed;

    impl embedded_io::ErrorType for Closed {
        type Error = Infallible;
    }

    impl Write for Closed {
        fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
            Ok(bytes.len())
        }

        fn flush(&mut self) -> Result<(), Infallible> {
            Ok(())
        }
    }

    impl Read for Closed {
        fn read(&mut self, _: &mut [u8]) -> Result<usize, Infallible> {
            Ok(0)
        }
    }

    #[test]
    fn a_closed_line_is_an_error_of_the_bus() {
        assert_eq!(SerialLine::new(Closed).part(7).read(&mut [0]), Err(RemoteError::Line));
    }
}
