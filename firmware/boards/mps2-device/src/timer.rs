//! CMSDK APB timer: counts down at the processor's clock, and interrupts.

use volatile_register::RW;

/// Registers, in the order of their addresses.
#[repr(C)]
struct Registers {
    control: RW<u32>,
    value: RW<u32>,
    reload: RW<u32>,
    interrupt: RW<u32>,
}

/// Timer 1 of AN385 and AN386.
const TIMER1: *const Registers = 0x4000_1000 as *const Registers;
/// Control: counts, and interrupts at 0.
const RUNS: u32 = 1;
const INTERRUPTS: u32 = 1 << 3;

/// A timer.
pub struct Timer {
    registers: &'static Registers,
}

impl core::fmt::Debug for Timer {
    fn fmt(&self, formatter: &mut core::fmt::Formatter) -> core::fmt::Result {
        write!(formatter, "Timer({} counts left)", self.registers.value.read())
    }
}

#[expect(unsafe_code, reason = "its registers are at one address for every priority")]
// SAFETY: a read or write of a register is whole, whichever task does it.
unsafe impl Send for Timer {}

#[expect(unsafe_code, reason = "registers at the address that the boards have them at, of the layout above")]
impl Timer {
    /// Timer 1.
    #[must_use]
    pub fn one() -> Self {
        // SAFETY: the boards have the timer there as long as the program lives, and it is accessed by volatile reads and writes only.
        Self { registers: unsafe { &*TIMER1 } }
    }

    /// Interrupts after so many counts, and every so many again until it is stopped.
    pub fn start(&self, counts: u32) {
        // SAFETY: none of these registers has an effect on memory.
        unsafe {
            self.registers.reload.write(counts);
            self.registers.value.write(counts);
            self.registers.control.write(RUNS | INTERRUPTS);
        }
    }

    /// Stops, and withdraws its interrupt.
    pub fn stop(&self) {
        // SAFETY: none of these registers has an effect on memory.
        unsafe {
            self.registers.control.write(0);
            self.registers.interrupt.write(1);
        }
    }
}
