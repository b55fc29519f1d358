//! An image whose only work is the whole control period: what is in it is the period's flash, and a panic that it could reach would be too.
//!
//! It is not to be run; the station and its request are nowhere made.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod on_target {
    use core::hint::black_box;

    use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
    use firmware::app::{Outcome, Wired};
    use firmware::period::Request;
    use panic_semihosting as _;

    /// A bus of which nothing is known, and which is nothing.
    struct Wire;

    impl ErrorType for Wire {
        type Error = ErrorKind;
    }

    impl SpiDevice for Wire {
        fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
            black_box(operations);
            black_box(Ok(()))
        }
    }

    struct Work {
        station: Wired<'static, Wire, Wire, Wire>,
        request: Request,
        outcome: Option<Outcome>,
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let mut work: Option<Work> = black_box(None);
        loop {
            if let Some(Work { station, request, outcome }) = black_box(&mut work) {
                *outcome = Some(station.step(request, &mut ()));
            }
        }
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    println!("nothing runs here: the image for thumbv7em-none-eabihf or thumbv7m-none-eabi is what counts");
}
