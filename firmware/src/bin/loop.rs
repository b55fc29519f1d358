//! Processor in the loop: the whole firmware on the emulated target, its parts and its machine at the other end of the serial line.
//!
//! `cargo run --release -p firmware --bin loop --target thumbv7em-none-eabihf` starts it; the other end is what
//! `cargo test --release -p system-tests --test closed_loop processor` plays.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
#[cortex_m_rt::entry]
fn main() -> ! {
    use core::fmt::Write;

    use cortex_m::delay::Delay;
    #[cfg(feature = "defmt")]
    use defmt_semihosting as _;
    use firmware::board::mps2::{CLOCK_HZ, Log, console, exit};
    use firmware::board::uart::Uart;
    use firmware::lockstep::run;
    use firmware::station::Ring;
    use panic_semihosting as _;

    let mut delay = cortex_m::Peripherals::take().map(|peripherals| Delay::new(peripherals.SYST, CLOCK_HZ));
    let memory = cortex_m::singleton!(: Option<Ring> = None);
    let (Some(delay), Some(memory)) = (delay.as_mut(), memory) else { exit(false) };
    let ended = run(Uart::open(), delay, &mut Log::default(), memory);
    if let (Err(error), Some(mut console)) = (&ended, console()) {
        // Whoever started the emulator reads it; without a console there is nobody to tell.
        let _ = writeln!(console, "error: {error}");
    }
    exit(ended.is_ok())
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    eprintln!("the firmware runs on the target: --target thumbv7em-none-eabihf");
}
