//! A bus whose transfer ends with an interrupt, as one by DMA does: timer 1 takes as long as the bytes do, and the task sleeps meanwhile.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice as _};
use embedded_hal_async::spi::SpiDevice;
use mps2_device::{CLOCK_HZ, Timer, interrupt};
use simulated_press::parts::Wire;

/// Clock of the bus, Hz.
const BUS_HZ: u32 = 10_000_000;

/// The transfer has ended.
static ENDED: Signal<CriticalSectionRawMutex, ()> = Signal::new();

#[cortex_m_rt::interrupt]
fn TIMER1() {
    Timer::one().stop();
    ENDED.signal(());
}

/// A simulated part behind such a bus. One transfer at a time: the period asks one part after the other.
pub(crate) struct Transfers<'a>(pub(crate) Wire<'a>);

impl ErrorType for Transfers<'_> {
    type Error = ErrorKind;
}

impl SpiDevice for Transfers<'_> {
    async fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let bytes = operations.iter().map(|operation| match operation {
            Operation::Write(bytes) => bytes.len(),
            Operation::Read(bytes) | Operation::TransferInPlace(bytes) => bytes.len(),
            Operation::Transfer(read, sent) => read.len().max(sent.len()),
            Operation::DelayNs(_) => 0,
        });
        let bits = 8 * u32::try_from(bytes.sum::<usize>()).map_err(|_| ErrorKind::Other)?;
        ENDED.reset();
        Timer::one().start(bits * (CLOCK_HZ / 1_000_000) / (BUS_HZ / 1_000_000));
        ENDED.wait().await;
        self.0.transaction(operations)
    }
}
