//! A stack that overflows, on purpose: the fault is caught before anything else is overwritten. `memory.x` puts the stack at the bottom of the memory.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]
#![cfg_attr(
    all(target_arch = "arm", target_os = "none"),
    expect(unsafe_code, reason = "a handler whose stack is gone has to begin in assembly")
)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod on_target {
    use core::fmt::Write;
    use core::hint::black_box;
    use core::sync::atomic::{AtomicU32, Ordering};

    use cortex_m_stack as stack;
    use mps2::{console, exit};
    use panic_semihosting as _;

    /// What lies in the memory above the stack.
    static KEPT: AtomicU32 = AtomicU32::new(0);
    const FULL: u32 = 0x5afe_5afe;
    static DEPTH: AtomicU32 = AtomicU32::new(0);

    // What was pushed last is gone: the handler takes the whole stack anew.
    core::arch::global_asm!(
        ".section .text.HardFault, \"ax\"",
        ".global HardFault",
        ".type HardFault, %function",
        ".thumb_func",
        "HardFault:",
        "ldr r0, =_stack_start",
        "mov sp, r0",
        "b {caught}",
        caught = sym caught,
    );

    extern "C" fn caught() -> ! {
        let whole = KEPT.load(Ordering::Relaxed) == FULL;
        if let Some(mut console) = console() {
            let depth = DEPTH.load(Ordering::Relaxed);
            // SAFETY: the status of the fault, read only.
            let faults = unsafe { (*cortex_m::peripheral::SCB::PTR).cfsr.read() };
            // Its lowest byte is the memory protection's; where there is no memory at all, the bus has failed.
            let by_guard = faults & 0xff != 0;
            let _ = writeln!(
                console,
                "overflow caught after {depth} calls, by the guard: {by_guard}, memory whole: {whole}"
            );
        }
        exit(whole)
    }

    #[inline(never)]
    #[expect(unconditional_recursion, reason = "it is to overflow")]
    fn deeper(depth: u32) -> u32 {
        DEPTH.store(depth, Ordering::Relaxed);
        let room = black_box([depth; 64]);
        deeper(depth + 1).wrapping_add(room[black_box(7)])
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        KEPT.store(black_box(FULL), Ordering::Relaxed);
        let Some(mut peripherals) = cortex_m::Peripherals::take() else { exit(false) };
        stack::guard(&mut peripherals.MPU);
        black_box(deeper(0));
        exit(false)
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    eprintln!("the stack overflows on the target: --target thumbv7em-none-eabihf");
}
