//! Arm MPS2 as QEMU emulates it: `mps2-an386` (Cortex-M4F) and `mps2-an385` (Cortex-M3), a console by semihosting, an instruction counter.
//!
//! Under `-icount shift=0` an instruction takes 1 ns, and `SysTick` counts at 25 MHz: one count is 40 instructions.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hio::{self, HostStream};

/// What the firmware logs on this board: everything by defmt if that feature is on, otherwise nothing.
#[cfg(feature = "defmt")]
pub type Log = firmware::supervision::Defmt;
/// What the firmware logs on this board: everything by defmt if that feature is on, otherwise nothing.
#[cfg(not(feature = "defmt"))]
pub type Log = ();

/// Clock of the processor, Hz.
pub const CLOCK_HZ: u32 = 25_000_000;

/// Instructions in a count of `SysTick`.
pub const INSTRUCTIONS_PER_COUNT: u32 = 40;

/// `SysTick` counts in 24 bits.
const RELOAD: u32 = 0x00ff_ffff;

/// The emulator's standard output; `None` where there is no emulator or debugger.
#[must_use]
pub fn console() -> Option<HostStream> {
    hio::hstdout().ok()
}

/// Ends the emulation; its exit status is 0 if all went well, else 1.
pub fn exit(well: bool) -> ! {
    debug::exit(if well { EXIT_SUCCESS } else { EXIT_FAILURE });
    loop {
        cortex_m::asm::wfi();
    }
}

/// Counts the instructions of short pieces of work: up to 2²⁴ counts, 671 million instructions.
pub struct Counter {
    timer: SYST,
}

impl core::fmt::Debug for Counter {
    fn fmt(&self, formatter: &mut core::fmt::Formatter) -> core::fmt::Result {
        write!(formatter, "Counter({} counts)", SYST::get_current())
    }
}

impl Counter {
    /// Starts `SysTick`.
    #[must_use]
    pub fn start(mut timer: SYST) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(RELOAD);
        timer.clear_current();
        timer.enable_counter();
        Self { timer }
    }

    /// Counts while `work` is done.
    pub fn counts(&mut self, work: impl FnOnce()) -> u32 {
        debug_assert!(self.timer.is_counter_enabled(), "it counts from its start on");
        let before = SYST::get_current();
        work();
        // It counts down.
        before.wrapping_sub(SYST::get_current()) & RELOAD
    }
}
