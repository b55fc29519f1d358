//! For tests: whole frames of embedded-hal-mock, a bus that fails at one of them (which those mocks cannot do), and a machine.

use std::vec;
use std::vec::Vec;

use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use embedded_hal_mock::eh1::spi::Transaction;
use model_core::machine::{Machine, Parameter, Source};

/// A cylinder of 63/40 mm and 300 mm stroke on 7 MPa.
pub(crate) fn press() -> Machine<f64> {
    let mut machine = Machine::with_defaults(Source::Valve);
    machine.set(Parameter::AreaA, 3.117e-3);
    machine.set(Parameter::AreaB, 1.861e-3);
    machine.set(Parameter::VolumeA, 5.2e-4);
    machine.set(Parameter::VolumeB, 3.3e-4);
    machine
}

/// A frame that is only written.
pub(crate) fn written(bytes: &[u8]) -> Vec<Transaction<u8>> {
    vec![Transaction::transaction_start(), Transaction::write_vec(bytes.to_vec()), Transaction::transaction_end()]
}

/// A frame that is answered.
pub(crate) fn asked(bytes: &[u8], answer: &[u8]) -> Vec<Transaction<u8>> {
    vec![
        Transaction::transaction_start(),
        Transaction::transfer(bytes.to_vec(), answer.to_vec()),
        Transaction::transaction_end(),
    ]
}

/// Passes on every transaction except the failing one, which does not reach the device.
#[derive(Debug)]
pub(crate) struct Failing<SPI> {
    spi: SPI,
    /// Transactions until the one that fails.
    left: Option<usize>,
}

impl<SPI> Failing<SPI> {
    /// Fails at this transaction; the first is 0.
    pub(crate) fn at(spi: SPI, transaction: usize) -> Self {
        Self { spi, left: Some(transaction) }
    }

    /// Gives the bus back.
    pub(crate) fn release(self) -> SPI {
        self.spi
    }
}

impl<SPI> ErrorType for Failing<SPI> {
    type Error = ErrorKind;
}

impl<SPI> Failing<SPI> {
    /// Counts a transaction.
    fn next(&mut self) -> Result<(), ErrorKind> {
        let fails = self.left == Some(0);
        self.left = self.left.and_then(|left| left.checked_sub(1));
        if fails { Err(ErrorKind::Other) } else { Ok(()) }
    }
}

impl<SPI: SpiDevice<Error = ErrorKind>> SpiDevice for Failing<SPI> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        self.next()?;
        self.spi.transaction(operations)
    }
}

#[cfg(feature = "async")]
impl<SPI: embedded_hal_async::spi::SpiDevice<Error = ErrorKind>> embedded_hal_async::spi::SpiDevice for Failing<SPI> {
    async fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        self.next()?;
        self.spi.transaction(operations).await
    }
}

/// What `block_on` is where nothing is awaited.
pub(crate) fn done<T>(value: T) -> T {
    value
}
