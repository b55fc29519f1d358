//! Steps of the model one after the other, for a trace that weighs each instruction in cycles (`tests/on_target/cycles.rs`).
//!
//! What is counted lies between the entry of `paper_step` or `step` and the return to `run`. The commands are those of the build
//! (`FIRMWARE_COMMANDS`). For each row it prints its ticks and its name.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod on_target {
    use core::fmt::{self, Write};

    use model_core::drive::{Drive, DriveInput, DriveState, Load, PaperDrive};
    use model_core::machine::{Machine, MachineError, Tick};
    use model_core::number::{Number, PerUnit};
    use model_core::ports::ChamberState;
    use mps2::trial::{DELAY, every_effect, forms, press};
    use panic_semihosting as _;

    /// Commands that are given to the build, in V.
    const GIVEN: &[(&str, &[f32])] = &include!(concat!(env!("OUT_DIR"), "/commands.rs"));
    /// Ticks of a drive with effects, of which each takes thousands of instructions: three commands.
    const TICKS: usize = 600;
    /// Five effects that drives often have.
    const FIVE: [&str; 5] =
        ["valve-hysteresis", "dead-zone-asymmetry", "internal-leakage", "hose-compliance", "coulomb-friction"];

    type State = DriveState<PerUnit, DELAY>;

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
    fn paper_step(drive: &PaperDrive<PerUnit>, state: &mut State, command: PerUnit) {
        drive.step(state, command, Load::NONE);
    }

    #[inline(never)]
    fn step(drive: &Drive<PerUnit>, state: &mut State, command: PerUnit) {
        drive.step(state, DriveInput::Command(command), Load::NONE);
    }

    /// All commands under a step: the caller that a trace asks for.
    #[inline(never)]
    fn run<D>(step: fn(&D, &mut State, PerUnit), drive: &D, state: &mut State, commands: &[f32]) {
        for &volts in commands {
            step(drive, state, PerUnit::saturated(f64::from(volts) / 10.0));
        }
    }

    fn at_rest(machine: &Machine<f64>) -> Result<(Drive<PerUnit>, State), MachineError> {
        let drive = Drive::<PerUnit>::new::<DELAY>(machine, Tick::OneMillisecond)?;
        let pressures = ChamberState { a: PerUnit::saturated(0.3), b: PerUnit::saturated(0.5) };
        let state = drive.at_rest(PerUnit::ZERO, pressures, PerUnit::travel(0.5));
        Ok((drive, state))
    }

    fn with(names: &[&str]) -> Machine<f64> {
        let wanted = forms().filter(|form| names.contains(&form.name));
        wanted.fold(press(), |machine, form| machine.with(form.values))
    }

    fn rows(out: &mut impl Write) -> Result<(), CyclesError> {
        for &(_, commands) in GIVEN {
            let (drive, mut state) = at_rest(&press())?;
            let paper = drive.without_effects().ok_or(CyclesError::HasEffects)?;
            run(paper_step, &paper, &mut state, commands);
            writeln!(out, "row {} paper's model", commands.len())?;

            let commands = commands.get(..TICKS).unwrap_or(commands);
            for (name, machine) in [
                ("one effect, internal-leakage", with(&["internal-leakage"])),
                ("one effect, supply-droop", with(&["supply-droop"])),
                ("five effects", with(&FIVE)),
                ("every effect", every_effect(&press())),
            ] {
                let (drive, mut state) = at_rest(&machine)?;
                run(step, &drive, &mut state, commands);
                writeln!(out, "row {} {name}", commands.len())?;
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
