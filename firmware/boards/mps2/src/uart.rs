//! First serial line of the MPS2 boards: Arm's CMSDK APB UART. Technical reference manual DDI 0479, section 4.3, table 4-4.

use core::convert::Infallible;

use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::NVIC;
use embedded_io::{ErrorType, Read, Write};
use volatile_register::{RO, RW};

/// Registers, in the order of their addresses.
#[repr(C)]
struct Registers {
    data: RW<u32>,
    state: RO<u32>,
    control: RW<u32>,
    interrupt: RW<u32>,
    divider: RW<u32>,
}

/// `UART0` of AN385 and AN386.
const UART0: *const Registers = 0x4000_4000 as *const Registers;
/// State: the byte to be sent has not gone yet; a byte has arrived.
const SENDING: u32 = 1;
const ARRIVED: u32 = 1 << 1;
/// Control: send and receive, and an interrupt when a byte has arrived.
const BOTH_WAYS: u32 = 0b11;
const TELL_ARRIVED: u32 = 1 << 3;
/// Least divider of the clock: 1.56 Mbit/s at 25 MHz.
const FASTEST: u32 = 16;

/// The interrupt when a byte has arrived. No handler runs: the interrupt only ends a sleep.
#[derive(Clone, Copy)]
struct Arrival;

#[expect(unsafe_code, reason = "the number that the boards have it at")]
// SAFETY: `UART0`'s receiver is interrupt 0 of AN385 and AN386.
unsafe impl InterruptNumber for Arrival {
    fn number(self) -> u16 {
        0
    }
}

/// The serial line, blocking; it sleeps while it waits, so that the emulator leaves its core to the program at the other end.
pub struct Uart {
    registers: &'static Registers,
}

impl core::fmt::Debug for Uart {
    fn fmt(&self, formatter: &mut core::fmt::Formatter) -> core::fmt::Result {
        write!(formatter, "Uart(state {:#04b})", self.registers.state.read())
    }
}

impl Uart {
    /// Opens the line at its fastest. To be called only once: two lines would take each other's bytes.
    #[must_use]
    #[expect(unsafe_code, reason = "registers at the address that the board has them at, of the layout above")]
    pub fn open() -> Self {
        // SAFETY: the boards of this module have the peripheral there, it lives as long as the program, and its registers are
        // accessed by volatile reads and writes only.
        let registers = unsafe { &*UART0 };
        // SAFETY: writing divider and control has no effect on memory.
        unsafe {
            registers.divider.write(FASTEST);
            registers.control.write(BOTH_WAYS | TELL_ARRIVED);
        }
        cortex_m::interrupt::disable();
        // SAFETY: interrupts are off, so none is taken.
        unsafe { NVIC::unmask(Arrival) };
        Self { registers }
    }
}

impl ErrorType for Uart {
    type Error = Infallible;
}

impl Read for Uart {
    /// Waits for one byte, then takes all others that have arrived.
    #[expect(unsafe_code, reason = "a write of the interrupt's register")]
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Self::Error> {
        let mut count = 0;
        for byte in bytes {
            while self.registers.state.read() & ARRIVED == 0 {
                if count > 0 {
                    return Ok(count);
                }
                cortex_m::asm::wfi();
            }
            // Cleared before the byte is read, so that the next byte raises the interrupt again.
            // SAFETY: clearing an interrupt has no effect on memory.
            unsafe { self.registers.interrupt.write(ARRIVED) };
            NVIC::unpend(Arrival);
            *byte = self.registers.data.read().to_le_bytes()[0];
            count += 1;
        }
        Ok(count)
    }
}

impl Write for Uart {
    #[expect(unsafe_code, reason = "a write of the data register")]
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        for &byte in bytes {
            while self.registers.state.read() & SENDING != 0 {}
            // SAFETY: writing data has no effect on memory.
            unsafe { self.registers.data.write(u32::from(byte)) };
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Self::Error> {
        while self.registers.state.read() & SENDING != 0 {}
        Ok(())
    }
}
