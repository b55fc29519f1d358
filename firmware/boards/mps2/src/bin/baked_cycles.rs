//! Steps of baked drives one after the other, as `cycles` has them of drives that are built: in an image of their own, since what a step inlines depends on
//! who else calls it. The drives are those of `FIRMWARE_BAKED_TRIALS`, the commands those of `FIRMWARE_COMMANDS`.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod on_target {
    use core::fmt::{self, Write};

    use model_core::drive::{Baked, BakedDrive, DriveInput, DriveState, Load};
    use model_core::number::Number;
    use mps2::commanded::{TICKS, pressures, run};
    use mps2::trial::{DELAY, Traced};
    use panic_semihosting as _;

    /// Commands that are given to the build, in V.
    const GIVEN: &[(&str, &[f32])] = &include!(concat!(env!("OUT_DIR"), "/commands.rs"));

    #[inline(never)]
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "as any other model's step")]
    fn step<B: Baked<Number: Traced>>(
        drive: &BakedDrive<B>,
        state: &mut DriveState<B::Number, DELAY>,
        command: B::Number,
    ) {
        drive.step(state, DriveInput::Command(command), Load::NONE);
    }

    fn row<B: Baked<Number: Traced>>(name: &str, commands: &[f32], out: &mut impl Write) -> fmt::Result {
        let drive = BakedDrive::<B>::new();
        let state = drive.at_rest(B::Number::ZERO, pressures(), B::Number::travel(0.5));
        let commands = if name == "paper's model" { commands } else { commands.get(..TICKS).unwrap_or(commands) };
        run(step::<B>, &drive, state, commands);
        writeln!(out, "row {} {}baked, {name}", commands.len(), B::Number::PREFIX)
    }

    macro_rules! drives {
        ($($drive:ident $name:literal: $(($_input:ident, $_case:literal))*;)*) => {
            fn rows(out: &mut impl Write) -> fmt::Result {
                for &(_, commands) in GIVEN {
                    $(row::<$drive::Exported>($name, commands, out)?;)*
                }
                Ok(())
            }
        };
    }

    include!(concat!(env!("OUT_DIR"), "/baked_trials.rs"));

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let Some(mut console) = mps2::console() else { mps2::exit(false) };
        mps2::exit(rows(&mut console).is_ok())
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    println!("only the target counts: cargo test --release -p system-tests --test on_target cycles");
}
