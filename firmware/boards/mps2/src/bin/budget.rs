//! What a step of the model costs on the emulated target: instructions, memory, stack
//! (`cargo run --release -p mps2 --bin budget --target thumbv7em-none-eabihf`, or `thumbv7m-none-eabi`).
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod on_target {
    use core::fmt::{self, Write};

    use model_core::drive::{Drive, DriveInput, Load, PaperDrive};
    use model_core::machine::{Machine, MachineError, Tick};
    #[cfg(target_abi = "eabihf")]
    use model_core::number::Single;
    use model_core::number::{Number, PerUnit};
    use model_core::ports::ChamberState;
    use mps2::Counter;
    use mps2::cost::{State, deepest, instructions};
    use mps2::trial::{DELAY, Input, Moment, SETS, Traced, every_effect, forms, press, steps_of};
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
    fn paper_step<N: Traced>(drive: &PaperDrive<N>, state: &mut State<N>, moment: &Moment<N>) {
        if let DriveInput::Command(command) = moment.drive_input {
            drive.step(state, command, moment.load);
        }
    }

    #[inline(never)]
    fn step<N: Traced>(drive: &Drive<N>, state: &mut State<N>, moment: &Moment<N>) {
        drive.step(state, moment.drive_input, moment.load);
    }

    fn at_rest<N: Traced>(machine: &Machine<f64>) -> Result<(Drive<N>, State<N>), MachineError> {
        let drive = Drive::<N>::new::<DELAY>(machine, Tick::OneMillisecond)?;
        let pressures = ChamberState { a: N::saturated(0.3), b: N::saturated(0.5) };
        let state = drive.at_rest(N::ZERO, pressures, N::travel(0.5));
        Ok((drive, state))
    }

    fn in_volts(volts: f32) -> Moment {
        Moment::command(PerUnit::saturated(f64::from(volts) / 10.0))
    }

    fn commands_only(moment: Moment) -> Moment {
        Moment { load: Load::NONE, oil_temperature: None, ..moment }
    }

    /// The figures of one number type.
    fn report_of<N: Traced>(counter: &mut Counter, out: &mut impl Write) -> Result<(), BudgetError> {
        let prefix = N::PREFIX;
        let random = || Input::Random.moments().take(RANDOM_TICKS);
        let mut row =
            |name: &str, (mean, worst): (u32, u32)| writeln!(out, "instructions {mean:>6} {worst:>6} {prefix}{name}");
        let steps = [2, 4, 6, 8, 10].into_iter().flat_map(steps_of);
        let (full, rest) = at_rest::<N>(&press())?;
        let paper = full.without_effects().ok_or(BudgetError::HasEffects)?;
        row("paper's model, steps", instructions(counter, paper_step, (&paper, rest), steps))?;
        row("paper's model, random", instructions(counter, paper_step, (&paper, rest), random().map(commands_only)))?;
        row("paper's model, random under load", instructions(counter, paper_step, (&paper, rest), random()))?;
        for (name, volts) in GIVEN {
            let moments = volts.iter().copied().map(in_volts);
            row(name, instructions(counter, paper_step, (&paper, rest), moments))?;
        }
        row("none of the effects, random under load", instructions(counter, step, (&full, rest), random()))?;
        for set in SETS {
            let (drive, state) = at_rest::<N>(&set.on(&press()))?;
            row(set.name, instructions(counter, step, (&drive, state), random()))?;
        }
        let (every, all_rest) = at_rest::<N>(&every_effect(&press()))?;
        row("every effect, random under load", instructions(counter, step, (&every, all_rest), random()))?;
        for form in forms() {
            let (drive, state) = at_rest::<N>(&press().with(form.values))?;
            row(form.name, instructions(counter, step, (&drive, state), random()))?;
        }

        let moment = Moment::command(N::ONE);
        let used = deepest(paper_step, (&paper, rest), &moment);
        writeln!(out, "stack {used:>6} {prefix}paper's model")?;
        let used = deepest(step, (&every, all_rest), &moment);
        writeln!(out, "stack {used:>6} {prefix}every effect")?;
        writeln!(out, "ram {:>6} coefficients, {prefix}paper's model", size_of::<PaperDrive<N>>())?;
        writeln!(out, "ram {:>6} coefficients, {prefix}every effect", size_of::<Drive<N>>())?;
        let lines = 2 * DELAY * size_of::<N>();
        writeln!(out, "ram {:>6} {prefix}state beside its delay lines", size_of::<State<N>>() - lines)?;
        writeln!(out, "ram {lines:>6} {prefix}delay lines of {DELAY} ticks")?;
        Ok(())
    }

    pub(crate) fn report(counter: &mut Counter, out: &mut impl Write) -> Result<(), BudgetError> {
        report_of::<PerUnit>(counter, out)?;
        // Single precision where there is an FPU.
        #[cfg(target_abi = "eabihf")]
        report_of::<Single>(counter, out)?;
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
