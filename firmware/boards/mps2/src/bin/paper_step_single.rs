//! An image that only runs the step of the paper's model in single precision: what it contains is that step's flash.
//!
//! It is not to be run; the drive and its state are never created.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
#[cortex_m_rt::entry]
fn main() -> ! {
    use core::hint::black_box;

    use model_core::drive::{DriveState, Load, PaperDrive};
    use model_core::number::Single;
    use mps2::trial::DELAY;
    use panic_semihosting as _;

    let mut model: Option<(PaperDrive<Single>, DriveState<Single, DELAY>, Single)> = black_box(None);
    loop {
        if let Some((drive, state, command)) = black_box(&mut model) {
            drive.step(state, *command, Load::NONE);
        }
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    println!("nothing runs here: the image for thumbv7em-none-eabihf or thumbv7m-none-eabi is what counts");
}
