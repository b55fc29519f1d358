//! What a step of a baked drive costs on the emulated target, as `budget` has it of drives that are built. The drives are those of `FIRMWARE_BAKED_TRIALS`,
//! or of `firmware/boards/mps2/baked_trials.rs`; the input is `budget`'s random one, with loads.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod on_target {
    use core::fmt::{self, Write};

    use model_core::drive::{Baked, BakedDrive, DriveInput, DriveState, Load};
    use model_core::number::Number;
    use model_core::ports::ChamberState;
    use mps2::Counter;
    use mps2::cost::{State, deepest, instructions};
    use mps2::trial::{Input, Moment, Traced};
    use panic_semihosting as _;

    /// Ticks of the random input.
    const RANDOM_TICKS: usize = 4000;

    /// Under a command: the compiler knows that nothing else comes.
    #[inline(never)]
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "as any other model's step")]
    fn step<B: Baked<Number: Traced>>(drive: &BakedDrive<B>, state: &mut State<B::Number>, moment: &Moment<B::Number>) {
        if let DriveInput::Command(command) = moment.drive_input {
            drive.step(state, DriveInput::Command(command), moment.load);
        }
    }

    fn cost<B: Baked<Number: Traced>, const LINE: usize>(
        name: &str,
        counter: &mut Counter,
        out: &mut dyn Write,
    ) -> fmt::Result {
        let drive = BakedDrive::<B>::new();
        let prefix = B::Number::PREFIX;
        let pressures = ChamberState { a: B::Number::saturated(0.3), b: B::Number::saturated(0.5) };
        let rest = drive.at_rest(B::Number::ZERO, pressures, B::Number::travel(0.5));
        let alone = |moment| Moment { load: Load::NONE, oil_temperature: None, ..moment };
        let random = || Input::Random.moments().take(RANDOM_TICKS);
        for (input, (mean, worst)) in [
            ("random", instructions(counter, step::<B>, (&drive, rest), random().map(alone))),
            ("under load", instructions(counter, step::<B>, (&drive, rest), random())),
        ] {
            writeln!(out, "instructions {mean:>6} {worst:>6} baked, {prefix}{name}, {input}")?;
        }
        let used = deepest(step::<B>, (&drive, rest), &Moment::command(B::Number::ONE));
        writeln!(out, "stack {used:>6} baked, {prefix}{name}")?;
        let state = size_of::<DriveState<B::Number, LINE>>() - 2 * LINE * size_of::<B::Number>();
        writeln!(out, "ram {:>6} baked, {prefix}{name}: state and stack", state + used)
    }

    macro_rules! drives {
        ($($drive:ident $name:literal: $(($_input:ident, $_case:literal))*;)*) => {
            fn costs(counter: &mut Counter, out: &mut dyn Write) -> fmt::Result {
                $(cost::<$drive::Exported, { $drive::DELAY_LINE }>($name, counter, out)?;)*
                Ok(())
            }
        };
    }

    include!(concat!(env!("OUT_DIR"), "/baked_trials.rs"));

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let counter = cortex_m::Peripherals::take().map(|peripherals| Counter::start(peripherals.SYST));
        let (Some(mut counter), Some(mut console)) = (counter, mps2::console()) else { mps2::exit(false) };
        mps2::exit(costs(&mut counter, &mut console).is_ok())
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    println!("only the target counts: cargo run --release -p mps2 --bin baked_budget --target thumbv7em-none-eabihf");
}
