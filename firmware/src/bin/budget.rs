//! What a step of the model costs on the emulated target: instructions, memory, stack
//! (`cargo run --release -p firmware --bin budget --target thumbv7em-none-eabihf`, or `thumbv7m-none-eabi`).
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod on_target {
    use core::fmt::{self, Write};
    use core::hint::black_box;

    use firmware::board::mps2::{self, Counter, INSTRUCTIONS_PER_COUNT};
    use firmware::board::stack;
    use firmware::trial::{DELAY, EFFECTS, Input, Moment, every_effect, press, steps_of};
    use model_core::chambers::ChamberState;
    use model_core::drive::{Drive, DriveState, Entry, Load};
    use model_core::fixed_point::PerUnit;
    use model_core::machine::{Machine, MachineError, Tick};
    use model_core::number::Number;
    use panic_semihosting as _;

    /// Ticks of a random input.
    const RANDOM_TICKS: usize = 4000;
    /// Ticks counted at once for the mean.
    const BATCH: u32 = 100;

    type State = DriveState<PerUnit, DELAY>;

    pub(crate) enum BudgetError {
        Machine(MachineError),
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
    fn step(drive: &Drive<PerUnit>, state: &mut State, moment: &Moment) {
        drive.step(state, moment.entry, moment.load);
    }

    /// What the loop around a step costs by itself.
    #[inline(never)]
    fn nothing(drive: &Drive<PerUnit>, state: &mut State, moment: &Moment) {
        black_box((drive, state, moment));
    }

    fn count(
        counter: &mut Counter,
        work: fn(&Drive<PerUnit>, &mut State, &Moment),
        model: (&Drive<PerUnit>, &mut State),
        moments: &[Moment],
    ) -> u32 {
        let (drive, state) = model;
        let work = black_box(work);
        counter.counts(|| moments.iter().for_each(|moment| work(drive, state, moment)))
    }

    fn at_rest(machine: &Machine<f64>) -> Result<(Drive<PerUnit>, State), MachineError> {
        let drive = Drive::<PerUnit>::new::<DELAY>(machine, Tick::OneMillisecond)?;
        let pressures = ChamberState { a: PerUnit::saturated(0.3), b: PerUnit::saturated(0.5) };
        let state = drive.at_rest(PerUnit::ZERO, pressures, PerUnit::travel(0.5));
        Ok((drive, state))
    }

    /// Mean and worst instructions of a step, the worst to 40.
    fn instructions(
        counter: &mut Counter,
        machine: &Machine<f64>,
        moments: impl Iterator<Item = Moment>,
    ) -> Result<(u32, u32), MachineError> {
        let (drive, mut state) = at_rest(machine)?;
        let mut beside = state;
        let (mut sum, mut ticks, mut worst) = (0, 0, 0);
        let rest = Moment { entry: Entry::Command(PerUnit::ZERO), load: Load::NONE, oil_temperature: None };
        let mut batch = [rest; BATCH as usize];
        let mut filled = 0;
        for moment in moments {
            batch[filled] = moment;
            filled += 1;
            if filled == batch.len() {
                filled = 0;
                let mut again = state;
                sum += count(counter, step, (&drive, &mut state), &batch);
                sum -= count(counter, nothing, (&drive, &mut beside), &batch);
                ticks += BATCH;
                for moment in &batch {
                    let one = core::slice::from_ref(moment);
                    let counts = count(counter, step, (&drive, &mut again), one);
                    worst = worst.max(counts - count(counter, nothing, (&drive, &mut beside), one));
                }
            }
        }
        Ok((sum * INSTRUCTIONS_PER_COUNT / ticks, worst * INSTRUCTIONS_PER_COUNT))
    }

    fn commands_only(moment: Moment) -> Moment {
        Moment { load: Load::NONE, oil_temperature: None, ..moment }
    }

    pub(crate) fn report(counter: &mut Counter, out: &mut impl Write) -> Result<(), BudgetError> {
        let random = || Input::Random.moments().take(RANDOM_TICKS);
        let all = every_effect(&press());
        let mut row = |name: &str, (mean, worst): (u32, u32)| writeln!(out, "instructions {mean:>6} {worst:>6} {name}");
        let steps = [2, 4, 6, 8, 10].into_iter().flat_map(steps_of);
        row("paper's model, steps", instructions(counter, &press(), steps)?)?;
        row("paper's model, random", instructions(counter, &press(), random().map(commands_only))?)?;
        row("paper's model, random under load", instructions(counter, &press(), random())?)?;
        row("every effect, random under load", instructions(counter, &all, random())?)?;
        for effect in EFFECTS {
            row(effect.name, instructions(counter, &press().with(effect.values), random())?)?;
        }

        for (name, machine) in [("paper's model", press()), ("every effect", all)] {
            let (drive, mut state) = at_rest(&machine)?;
            let moment = Moment { entry: Entry::Command(PerUnit::ONE), load: Load::NONE, oil_temperature: None };
            let mut used = 0;
            for _ in 0..BATCH {
                let ((), stack) = stack::used_by(|| step(&drive, &mut state, &moment));
                used = used.max(stack);
            }
            writeln!(out, "stack {used:>6} {name}")?;
        }
        writeln!(out, "ram {:>6} coefficients", size_of::<Drive<PerUnit>>())?;
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
    println!("only the target counts: cargo run --release -p firmware --bin budget --target thumbv7em-none-eabihf");
}
