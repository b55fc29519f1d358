//! An image that only runs the whole control period: what it contains is the period's flash, and any panic that the period could reach.
//!
//! It is not to be run; the station and its request are never created.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod on_target {
    use core::hint::black_box;

    use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
    use firmware::app::Wired;
    use firmware::period::{Report, Request};
    use panic_semihosting as _;

    /// A bus about which the compiler knows nothing, and which contains nothing.
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
        report: Option<Report>,
    }

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let mut work: Option<Work> = black_box(None);
        loop {
            if let Some(Work { station, request, report }) = black_box(&mut work) {
                *report = Some(station.step(request, &mut ()));
            }
        }
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    println!("nothing runs here: the image for thumbv7em-none-eabihf or thumbv7m-none-eabi is what counts");
}
