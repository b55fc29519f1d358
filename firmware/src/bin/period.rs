//! An image whose only work is a control period: control, monitor and recorder, and every command. A panic that it could reach would be in it.
//!
//! It is not to be run; the station is nowhere made.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
#[cortex_m_rt::entry]
fn main() -> ! {
    use core::hint::black_box;

    use firmware::edge::{Cause, FromFn};
    use firmware::period::Request;
    use firmware::station::Station;
    use panic_semihosting as _;

    type Inputs = FromFn<fn(u8) -> Result<i32, Cause>, 5_120_000>;
    type Counter = FromFn<fn() -> Result<i32, Cause>>;
    type Output = FromFn<fn(i32) -> Result<(), Cause>, 20_000_000>;

    let mut station: Option<(Station<'static, Inputs, Counter, Output>, Request)> = black_box(None);
    loop {
        if let Some((station, request)) = black_box(&mut station) {
            black_box(station.step(request, &mut ()));
        }
    }
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    println!("nothing runs here: the image for thumbv7em-none-eabihf or thumbv7m-none-eabi is what counts");
}
