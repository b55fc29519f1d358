//! What a step of the model costs on the emulated target: instructions, memory, stack
//! (`cargo run --release -p mps2 --bin budget --target thumbv7em-none-eabihf`, or `thumbv7m-none-eabi`).
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod on_target {
    use core::fmt::{self, Write};

    use model_core::drive::{Drive, DriveInput, Load, PaperDrive};
    use model_core::machine::{Machine, MachineError, Tick};
    use model_core::number::{Number, PerUnit};
    use model_core::ports::ChamberState;
    use mps2::Counter;
    use mps2::cost::{State, deepest, instructions};
    use mps2::trial::{DELAY, Input, Moment, every_effect, forms, press, steps_of};
    use panic_semihosting as _;

    /// Ticks of a random input.
    const RANDOM_TICKS: usize = 4000;
    /// Commands that are given to the build, in V.
    const GIVEN: &[(&str, &[f32])] = &include!(concat!(env!("OUT_DIR"), "/commands.rs"));

    pub(crate) enum BudgetError {
        Machine(MachineError),
        /// The paper's model cannot be made.
        HasEffects,
        Written,
    }

    impl From<MachineError> for BudgetError {
        fn from(error: MachineError) -> Self {
            BudgetError::Machine(error)
        }
    }

    impl From<fmt::Error> for BudgetError {
        fn from(_: fmt::Error) -> Self {
            BudgetError::Written
        }
    }

    #[inline(never)]
    fn paper_step(drive: &PaperDrive<PerUnit>, state: &mut State, moment: &Moment) {
        if let DriveInput::Command(command) = moment.drive_input {
            drive.step(state, command, moment.load);
        }
    }

    #[inline(never)]
    fn step(drive: &Drive<PerUnit>, state: &mut State, moment: &Moment) {
        drive.step(state, moment.drive_input, moment.load);
    }

    fn at_rest(machine: &Machine<f64>) -> Result<(Drive<PerUnit>, State), MachineError> {
        let drive = Drive::<PerUnit>::new::<DELAY>(machine, Tick::OneMillisecond)?;
        let pressures = ChamberState { a: PerUnit::saturated(0.3), b: PerUnit::saturated(0.5) };
        let state = drive.at_rest(PerUnit::ZERO, pressures, PerUnit::travel(0.5));
        Ok((drive, state))
    }

    fn in_volts(volts: f32) -> Moment {
        Moment::command(PerUnit::saturated(f64::from(volts) / 10.0))
    }

    fn commands_only(moment: Moment) -> Moment {
        Moment { load: Load::NONE, oil_temperature: None, ..moment }
    }

    pub(crate) fn report(counter: &mut Counter, out: &mut impl Write) -> Result<(), BudgetError> {
        let random = || Input::Random.moments().take(RANDOM_TICKS);
        let mut row = |name: &str, (mean, worst): (u32, u32)| writeln!(out, "instructions {mean:>6} {worst:>6} {name}");
        let steps = [2, 4, 6, 8, 10].into_iter().flat_map(steps_of);
        let (full, rest) = at_rest(&press())?;
        let paper = full.without_effects().ok_or(BudgetError::HasEffects)?;
        row("paper's model, steps", instructions(counter, paper_step, (&paper, rest), steps))?;
        row("paper's model, random", instructions(counter, paper_step, (&paper, rest), random().map(commands_only)))?;
        row("paper's model, random under load", instructions(counter, paper_step, (&paper, rest), random()))?;
        for (name, volts) in GIVEN {
            let moments = volts.iter().copied().map(in_volts);
            row(name, instructions(counter, paper_step, (&paper, rest), moments))?;
        }
        row("none of the effects, random under load", instructions(counter, step, (&full, rest), random()))?;
        let (every, all_rest) = at_rest(&every_effect(&press()))?;
        row("every effect, random under load", instructions(counter, step, (&every, all_rest), random()))?;
        for form in forms() {
            let (drive, state) = at_rest(&press().with(form.values))?;
            row(form.name, instructions(counter, step, (&drive, state), random()))?;
        }

        let moment = Moment { drive_input: DriveInput::Command(PerUnit::ONE), load: Load::NONE, oil_temperature: None };
        let used = deepest(paper_step, (&paper, rest), &moment);
        writeln!(out, "stack {used:>6} paper's model")?;
        let used = deepest(step, (&every, all_rest), &moment);
        writeln!(out, "stack {used:>6} every effect")?;
        writeln!(out, "ram {:>6} coefficients, paper's model", size_of::<PaperDrive<PerUnit>>())?;
        writeln!(out, "ram {:>6} coefficients, every effect", size_of::<Drive<PerUnit>>())?;
        let lines = 2 * DELAY * size_of::<PerUnit>();
        writeln!(out, "ram {:>6} state beside its delay lines", size_of::<State>() - lines)?;
        writeln!(out, "ram {lines:>6} delay lines of {DELAY} ticks")?;
        Ok(())
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let counter = cortex_m::Peripherals::take().map(|peripherals| Counter::start(peripherals.SYST));
        let (Some(mut counter), Some(mut console)) = (counter, mps2::console()) else { mps2::exit(false) };
        let done = report(&mut counter, &mut console);
        if let Err(BudgetError::Machine(error)) = &done {
            let _ = writeln!(console, "{error}");
        }
        mps2::exit(done.is_ok())
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    println!("only the target counts: cargo run --release -p mps2 --bin budget --target thumbv7em-none-eabihf");
}
