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

mps2::prints!(traces);
