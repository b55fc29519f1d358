//! Arm's MPS2 boards AN385 (Cortex-M3) and AN386 (Cortex-M4F) as RTIC and Embassy need a device: interrupts with their vectors, and the peripherals of a control
//! period. QEMU emulates both. For a real controller this is what its PAC or HAL gives.
//!
//! Arm application note DAI 0386, section Interrupts; Cortex-M System Design Kit, technical reference manual DDI 0479, sections 4.1 (timer) and 4.6 (watchdog).
#![cfg(all(target_arch = "arm", target_os = "none"))]
#![no_std]
#![deny(unsafe_code)]

mod interrupts;
mod timer;
mod watchdog;

pub use cortex_m_rt::interrupt;
pub use interrupts::{Interrupt, Interrupt as interrupt};
pub use timer::Timer;
pub use watchdog::Watchdog;

/// Bits of an interrupt's priority. QEMU has eight, the boards at least these.
pub const NVIC_PRIO_BITS: u8 = 3;

/// Clock of processor, `SysTick`, timers and watchdog, Hz.
pub const CLOCK_HZ: u32 = 25_000_000;
