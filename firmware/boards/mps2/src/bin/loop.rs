//! Processor in the loop: the whole firmware on the emulated target, its parts and its machine at the other end of the serial line.
//!
//! `cargo run --release -p system-tests --example in_the_loop` starts it together with its other end.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
#[cortex_m_rt::entry]
fn main() -> ! {
    use core::fmt::Write;

    use cortex_m::delay::Delay;
    use cortex_m_stack as stack;
    use firmware::app::Ring;
    use mps2::in_the_loop::lockstep::run;
    use mps2::uart::Uart;
    use mps2::{CLOCK_HZ, Log, console, exit};
    use panic_semihosting as _;

    let mut delay = cortex_m::Peripherals::take().map(|mut peripherals| {
        stack::guard(&mut peripherals.MPU);
        Delay::new(peripherals.SYST, CLOCK_HZ)
    });
    let memory = cortex_m::singleton!(: Option<Ring> = None);
    let (Some(delay), Some(memory), Some(mut console)) = (delay.as_mut(), memory, console()) else { exit(false) };
    // The program that started the emulator reads the console; if the console fails, nobody can be informed.
    let _ = writeln!(console, "firmware: waits for its machine at the other end of the serial line");
    let _ = writeln!(console, "firmware: cargo run --release -p system-tests --example in_the_loop starts both");
    let (ended, used) = stack::used_by(|| run(Uart::open(), delay, &mut Log::default(), memory));
    let _ = match &ended {
        Ok(()) => writeln!(console, "firmware: ended by the other end; stack {used} bytes"),
        Err(error) => writeln!(console, "firmware: {error}"),
    };
    exit(ended.is_ok())
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    eprintln!("the firmware runs on the target: --target thumbv7em-none-eabihf");
}
