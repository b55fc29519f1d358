//! The trace of every trial, in fixed point and then in single precision: on a host, or on the emulated target
//! (`cargo run --release -p mps2 --bin parity --target thumbv7em-none-eabihf`, or `thumbv7m-none-eabi`). Both are the same.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

use core::fmt::Write;

use model_core::number::{PerUnit, Single};
use mps2::trial::{CaseError, cases};

fn traces(out: &mut impl Write) -> Result<(), CaseError> {
    cases().try_for_each(|case| case.trace::<PerUnit>(out))?;
    cases().try_for_each(|case| case.trace::<Single>(out))
}

#[cfg(all(target_arch = "arm", target_os = "none"))]
#[cortex_m_rt::entry]
fn main() -> ! {
    use panic_semihosting as _;

    let well = mps2::console().is_some_and(|mut console| traces(&mut console).is_ok());
    mps2::exit(well)
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() -> Result<(), String> {
    let mut text = String::new();
    let done = traces(&mut text);
    print!("{text}");
    done.map_err(|error| format!("{error:?}"))
}
