//! An image of a baked drive alone: all that a controller needs to run the model beside its inputs and outputs.
//!
//! It has the drive of `FIRMWARE_BAKED`, or of `firmware/baked.rs`, and is not to be run: its command never comes.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
#[allow(dead_code, unreachable_pub, reason = "an exported file is for anybody, and not all of it is needed")]
mod exported {
    include!(concat!(env!("OUT_DIR"), "/baked.rs"));
}

#[cfg(all(target_arch = "arm", target_os = "none"))]
#[cortex_m_rt::entry]
fn main() -> ! {
    use core::hint::black_box;

    use model_core::drive::{Baked, BakedDrive, DriveInput, DriveState, Load};
    use model_core::flow::PumpDrive;
    use model_core::machine::Source;
    use model_core::number::Number;
    use model_core::ports::ChamberState;
    use panic_semihosting as _;

    type Word = <exported::Exported as Baked>::Number;

    let drive = BakedDrive::<exported::Exported>::new();
    let half = Word::ONE.halved();
    let pressures = ChamberState { a: half, b: half };
    let mut state: DriveState<Word, { exported::DELAY_LINE }> = drive.at_rest(Word::ZERO, pressures, half.as_travel());
    loop {
        let given = black_box(Word::ZERO);
        let input = match exported::SOURCE {
            Source::Valve => DriveInput::Command(given),
            Source::Pump => DriveInput::Pump(PumpDrive { speed: given, direction: black_box(1) }),
            Source::Force => DriveInput::Force { from: given, to: given },
        };
        drive.step(&mut state, input, Load::NONE);
        black_box(drive.sensed(&state));
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    println!("nothing runs here: the image for thumbv7em-none-eabihf or thumbv7m-none-eabi is what counts");
}
