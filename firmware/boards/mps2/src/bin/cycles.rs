//! Steps of the model one after the other, for a trace that weighs each instruction in cycles (`tests/on_target/cycles.rs`).
//!
//! What is counted lies between the entry of `paper_step` or `step` and the return to `run`. The commands are those of the build
//! (`FIRMWARE_COMMANDS`). For each row it prints its ticks and its name. Drives in single precision are counted where the processor has an FPU.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod on_target {
    use core::fmt::{self, Write};

    use model_core::drive::{Drive, DriveInput, DriveState, Load, PaperDrive};
    use model_core::machine::{Machine, MachineError, Tick};
    use model_core::number::{PerUnit, Single};
    use mps2::commanded::{TICKS, pressures, run};
    use mps2::trial::{DELAY, SETS, Traced, every_effect, forms, press};
    use panic_semihosting as _;

    /// Commands that are given to the build, in V.
    const GIVEN: &[(&str, &[f32])] = &include!(concat!(env!("OUT_DIR"), "/commands.rs"));
    /// Effects that are counted alone.
    const ONE: [&str; 2] = ["supply-droop", "internal-leakage"];

    enum CyclesError {
        Machine(MachineError),
        /// The paper's model cannot be made.
        HasEffects,
        Written,
    }

    impl From<MachineError> for CyclesError {
        fn from(error: MachineError) -> Self {
            CyclesError::Machine(error)
        }
    }

    impl From<fmt::Error> for CyclesError {
        fn from(_: fmt::Error) -> Self {
            CyclesError::Written
        }
    }

    #[inline(never)]
    fn paper_step<N: Traced>(drive: &PaperDrive<N>, state: &mut DriveState<N, DELAY>, command: N) {
        drive.step(state, command, Load::NONE);
    }

    #[inline(never)]
    fn step<N: Traced>(drive: &Drive<N>, state: &mut DriveState<N, DELAY>, command: N) {
        drive.step(state, DriveInput::Command(command), Load::NONE);
    }

    fn at_rest<N: Traced>(machine: &Machine<f64>) -> Result<(Drive<N>, DriveState<N, DELAY>), MachineError> {
        let drive = Drive::<N>::new::<DELAY>(machine, Tick::OneMillisecond)?;
        let state = drive.at_rest(N::ZERO, pressures(), N::travel(0.5));
        Ok((drive, state))
    }

    /// Drives that are built on the target.
    fn built<N: Traced>(commands: &[f32], out: &mut impl Write) -> Result<(), CyclesError> {
        let prefix = N::PREFIX;
        let (drive, state) = at_rest::<N>(&press())?;
        let paper = drive.without_effects().ok_or(CyclesError::HasEffects)?;
        run(paper_step, &paper, state, commands);
        writeln!(out, "row {} {prefix}paper's model", commands.len())?;

        let commands = commands.get(..TICKS).unwrap_or(commands);
        let plain = press();
        let one = forms().filter(|form| ONE.contains(&form.name)).map(|form| (form.name, plain.with(form.values)));
        let several = SETS.iter().map(|set| (set.name, set.on(&plain)));
        for (name, machine) in one.chain(several).chain([("every effect", every_effect(&plain))]) {
            let (drive, state) = at_rest::<N>(&machine)?;
            run(step, &drive, state, commands);
            let alone = if ONE.contains(&name) { "one effect, " } else { "" };
            writeln!(out, "row {} {prefix}{alone}{name}", commands.len())?;
        }
        Ok(())
    }

    fn rows(out: &mut impl Write) -> Result<(), CyclesError> {
        for &(_, commands) in GIVEN {
            built::<PerUnit>(commands, out)?;
            if cfg!(target_abi = "eabihf") {
                built::<Single>(commands, out)?;
            }
        }
        Ok(())
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let Some(mut console) = mps2::console() else { mps2::exit(false) };
        let done = rows(&mut console);
        if let Err(CyclesError::Machine(error)) = &done {
            let _ = writeln!(console, "{error}");
        }
        mps2::exit(done.is_ok())
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    println!("only the target counts: cargo test --release -p system-tests --test on_target cycles");
}
