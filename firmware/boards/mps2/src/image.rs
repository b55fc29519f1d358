//! What binaries consist of that have nothing else: the step of a model, or what is printed.

/// The image of a step: of a drive of this type, in these numbers, with the input that this makes of a command. The drive and its state are never created.
#[macro_export]
macro_rules! image_of_a_step {
    ($drive:ident, $number:ident, $input:path) => {
        #[cfg(all(target_arch = "arm", target_os = "none"))]
        #[cortex_m_rt::entry]
        fn main() -> ! {
            use core::hint::black_box;

            use model_core::drive::{DriveState, Load, $drive};
            use model_core::number::$number;
            use mps2::trial::DELAY;
            use panic_semihosting as _;

            let mut model: Option<($drive<$number>, DriveState<$number, DELAY>, $number)> = black_box(None);
            loop {
                if let Some((drive, state, command)) = black_box(&mut model) {
                    drive.step(state, $input(*command), Load::NONE);
                }
            }
        }

        #[cfg(not(all(target_arch = "arm", target_os = "none")))]
        fn main() {
            println!("nothing runs here: the image for thumbv7em-none-eabihf or thumbv7m-none-eabi is what counts");
        }
    };
}

/// A program that writes a text, on a host or on the emulated target, and fails where that fails.
#[macro_export]
macro_rules! prints {
    ($written:ident) => {
        #[cfg(all(target_arch = "arm", target_os = "none"))]
        #[cortex_m_rt::entry]
        fn main() -> ! {
            use panic_semihosting as _;

            let well = mps2::console().is_some_and(|mut console| $written(&mut console).is_ok());
            mps2::exit(well)
        }

        #[cfg(not(all(target_arch = "arm", target_os = "none")))]
        fn main() -> Result<(), String> {
            let mut text = String::new();
            let done = $written(&mut text);
            print!("{text}");
            done.map_err(|error| format!("{error:?}"))
        }
    };
}
