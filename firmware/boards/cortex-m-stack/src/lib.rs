//! The stack: how much of it some work uses, and a guard at its end.
//!
//! To measure, the memory below the stack is painted, and checked afterwards. For a Cortex-M alone: on other processors this crate is empty.
#![no_std]
#![cfg(all(target_arch = "arm", target_os = "none"))]
#![deny(unsafe_code)]

/// How much is painted, bytes.
const PAINTED: usize = 64 * 1024;
const PAINT: u32 = 0xa5a5_a5a5;

/// Does some work; returns its result and how far below the caller its stack went, bytes. For boards with 64 KiB below the caller's stack that nobody else uses.
#[inline(never)]
#[expect(
    unsafe_code,
    reason = "only the words below the stack pointer, which nobody owns, say how far a call has gone"
)]
pub fn used_by<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let pointer = cortex_m::register::msp::read() as usize;
    // What the compiler keeps right below the pointer is not painted.
    let painted = (pointer - PAINTED..pointer - 64).step_by(4);
    for address in painted.clone() {
        // SAFETY: aligned, within the RAM, below the stack of the only thread; no interrupt is on.
        unsafe { core::ptr::with_exposed_provenance_mut::<u32>(address).write_volatile(PAINT) };
    }
    let done = work();
    for address in painted {
        // SAFETY: as above.
        if unsafe { core::ptr::with_exposed_provenance::<u32>(address).read_volatile() } != PAINT {
            return (done, pointer - address);
        }
    }
    (done, 0)
}

/// Sets the processor's limit of the stack to its end: a stack that overflows is a fault, before it overwrites anything. Without a handler of its own
/// the processor then stands still, and the watchdog restarts it. Not for an ARMv8-M without the main extension, which has no limit outside its secure state.
///
/// # Panics
/// `_stack_end` is not at a whole double word.
#[cfg(armv8m_main)]
#[expect(unsafe_code, reason = "the limit of the stack is written")]
pub fn guard() {
    let lowest = end();
    // The limit has no lower bits: cut down, it would take what lies below the stack.
    assert!(lowest.is_multiple_of(8), "_stack_end is at {lowest:#x}; expected a whole double word");
    // SAFETY: below the limit nobody owns anything on this stack.
    unsafe { cortex_m::register::msplim::write(lowest) };
}

/// Where the linker script ends the stack.
#[cfg(any(not(armv8m), armv8m_main))]
#[expect(unsafe_code, reason = "the linker's symbol has an address only")]
fn end() -> u32 {
    unsafe extern "C" {
        static _stack_end: u32;
    }
    let lowest = (&raw const _stack_end).expose_provenance();
    #[expect(clippy::cast_possible_truncation, reason = "an address has 32 bits here")]
    let lowest = lowest as u32;
    lowest
}

/// Size of the guard, bytes: a power of two, as `memory.x` aligns the end of the stack.
#[cfg(not(armv8m))]
const GUARD_BITS: u32 = 10;

/// Makes the lowest kilobyte of the stack a place that nobody may touch: a stack that overflows is a fault, before it overwrites anything. Without
/// a handler of its own the processor then stands still, and the watchdog restarts it.
///
/// The linker script has to put the stack at the bottom of the memory, from a whole kilobyte `_stack_end` on; a frame that is larger than the guard then ends where
/// there is no memory. The memory protection is that of ARMv6-M and ARMv7-M.
///
/// # Panics
/// `_stack_end` is not at a whole kilobyte.
#[cfg(not(armv8m))]
#[expect(unsafe_code, reason = "the registers of the memory protection are written")]
pub fn guard(mpu: &mut cortex_m::peripheral::MPU) {
    let lowest = end();
    // Cut down to a whole kilobyte, it would take what lies below the stack.
    assert!(lowest.trailing_zeros() >= GUARD_BITS, "_stack_end is at {lowest:#x}; expected a whole kilobyte");
    // Never executed, no access, of this size, on; elsewhere as without the protection, and off in the fault's own handler.
    let attributes = 1 << 28 | (GUARD_BITS - 1) << 1 | 1;
    // SAFETY: the region holds nothing but the end of the stack, and no other region is on.
    unsafe {
        mpu.ctrl.write(0);
        mpu.rnr.write(0);
        mpu.rbar.write(lowest);
        mpu.rasr.write(attributes);
        mpu.ctrl.write(0b101);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}
