//! The traces of baked drives, as `parity` has those of drives that are built: on a host, or on the emulated target. The drives and their inputs are those
//! of `FIRMWARE_BAKED_TRIALS`, or of `firmware/boards/mps2/baked_trials.rs`.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

use core::fmt::{self, Write};

use model_core::drive::{Baked, BakedDrive, Drive};
use model_core::machine::{Machine, MachineError, Parameter, Source, Tick};
use mps2::trial::{DELAY, Input, Traced, run};

/// Why there is no trace.
#[derive(Clone, Copy, Debug, PartialEq)]
enum BakedError {
    /// The values do not become a drive.
    Machine(MachineError),
    /// The drive that they become has other coefficients than the baked one.
    Differs,
    Written,
}

impl From<fmt::Error> for BakedError {
    fn from(_: fmt::Error) -> Self {
        BakedError::Written
    }
}

/// The values that a drive was baked from.
type Values = (Source, &'static [(Parameter, f64)], Tick);

/// The traces of a drive under its inputs; before, its coefficients are built from the values.
#[inline(never)]
fn trace<B: Baked<Number: Traced>>(
    out: &mut dyn Write,
    (source, values, tick): Values,
    inputs: &[(&str, Input)],
) -> Result<(), BakedError> {
    let machine = Machine::with_defaults(source).with(values);
    let built = Drive::<B::Number>::new::<DELAY>(&machine, tick).map_err(BakedError::Machine)?;
    if built != *B::DRIVE {
        return Err(BakedError::Differs);
    }
    for &(name, input) in inputs {
        writeln!(out, "{name}")?;
        run(&BakedDrive::<B>::new(), input, |sample| writeln!(out, "{sample}"))?;
    }
    Ok(())
}

macro_rules! drives {
    ($($drive:ident $_name:literal: $(($input:ident, $case:literal))*;)*) => {
        fn traces(out: &mut dyn Write) -> Result<(), BakedError> {
            $(trace::<$drive::Exported>(
                out,
                ($drive::SOURCE, $drive::VALUES, $drive::TICK),
                &[$(($case, Input::$input)),*],
            )?;)*
            Ok(())
        }
    };
}

include!(concat!(env!("OUT_DIR"), "/baked_trials.rs"));

mps2::prints!(traces);
