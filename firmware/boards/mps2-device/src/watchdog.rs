//! CMSDK APB watchdog: when it elapses it interrupts (the NMI, which no priority holds back), and when it elapses again it resets the board.

use volatile_register::{RO, RW, WO};

/// Registers, in the order of their addresses.
#[repr(C)]
struct Registers {
    load: RW<u32>,
    value: RO<u32>,
    control: RW<u32>,
    clear: WO<u32>,
}

const WATCHDOG: *const Registers = 0x4000_8000 as *const Registers;
/// Control: counts, and resets.
const RUNS: u32 = 1;
const RESETS: u32 = 1 << 1;

/// The watchdog.
pub struct Watchdog {
    registers: &'static Registers,
}

impl core::fmt::Debug for Watchdog {
    fn fmt(&self, formatter: &mut core::fmt::Formatter) -> core::fmt::Result {
        write!(formatter, "Watchdog({} counts left)", self.registers.value.read())
    }
}

#[expect(unsafe_code, reason = "its registers are at one address for every priority")]
// SAFETY: a read or write of a register is whole, whichever task does it.
unsafe impl Send for Watchdog {}

#[expect(unsafe_code, reason = "registers at the address that the boards have them at, of the layout above")]
impl Watchdog {
    /// Starts it, with so many counts of the clock: it must be fed within them.
    #[must_use]
    pub fn start(counts: u32) -> Self {
        // SAFETY: the boards have the watchdog there as long as the program lives, and it is accessed by volatile reads and writes only.
        let watchdog = Self { registers: unsafe { &*WATCHDOG } };
        watchdog.set(counts);
        // SAFETY: no effect on memory.
        unsafe { watchdog.registers.control.write(RUNS | RESETS) };
        watchdog
    }

    /// Gives it so many counts from now on.
    pub fn set(&self, counts: u32) {
        // SAFETY: no effect on memory.
        unsafe { self.registers.load.write(counts) };
    }

    /// Begins its time again.
    pub fn feed(&self) {
        // SAFETY: no effect on memory; any value does.
        unsafe { self.registers.clear.write(0) };
    }
}
