//! What the whole control period costs on the emulated target
//! (`cargo run --release -p mps2 --bin budget_whole --target thumbv7em-none-eabihf`, or `thumbv7m-none-eabi`).
//!
//! In a separate image from the budget of the model's step, because other callers of the step change how the compiler optimises it.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod period;

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod on_target {
    use core::fmt::{self, Write};

    use firmware::app::{Ring, StationError};
    use model_core::machine::MachineError;
    use mps2::Counter;
    use panic_semihosting as _;

    use crate::period;

    #[derive(Debug, thiserror::Error)]
    pub(crate) enum BudgetError {
        #[error(transparent)]
        Machine(#[from] MachineError),
        #[error(transparent)]
        Station(#[from] StationError),
        #[error(transparent)]
        Scene(#[from] period::SceneError),
        #[error("the console failed")]
        Written(#[from] fmt::Error),
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let counter = cortex_m::Peripherals::take().map(|peripherals| Counter::start(peripherals.SYST));
        let memory = cortex_m::singleton!(: Option<Ring> = None);
        let (Some(mut counter), Some(memory), Some(mut console)) = (counter, memory, mps2::console()) else {
            mps2::exit(false)
        };
        let done = period::report(&mut counter, memory, &mut console);
        if let Err(error) = &done {
            let _ = writeln!(console, "{error}");
        }
        mps2::exit(done.is_ok())
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    println!("only the target counts: cargo run --release -p mps2 --bin budget_whole --target thumbv7em-none-eabihf");
}
