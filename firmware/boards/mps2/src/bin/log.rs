//! What the firmware logs on the target: the press's whole firmware runs over signals that are generated here; it logs by defmt.
//!
//! The rod stands at mid-stroke and follows; then its position drifts away from the model, the monitor gives its alarm, and
//! the command ramps to neutral; the rod drifts on. Then the wire of a pressure sensor opens, and the encoder jumps. `cargo run --release -p mps2 --bin log --features defmt --target
//! thumbv7em-none-eabihf | defmt-print -e <the image>` shows it.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

#[cfg(all(target_arch = "arm", target_os = "none"))]
mod played {
    use core::cell::Cell;
    use core::convert::Infallible;

    use firmware::app::press::{self, COUNTS_PER_M};
    use firmware::app::{Assembly, Ring, StationError};
    use firmware::io::FromFn;
    use firmware::period::{Devices, Place, Request, Timing};
    use firmware::set_point::SetPoint;
    use firmware::supervision::{Command, Defmt};
    use model_core::drive::Drive;
    use model_core::number::{Number, PerUnit};

    /// Microvolts of 2¹⁶ counts: 78.125 µV a count at the inputs, 305 µV at the output.
    const INPUT_UV: u32 = 5_120_000;
    const OUTPUT_UV: u32 = 20_000_000;
    /// Command, in 10 V, of a count of the output.
    const PER_COUNT: f64 = OUTPUT_UV as f64 * 1e-7 / 65_536.0;
    /// Counts of the inputs per volt.
    const PER_VOLT: i32 = 12_800;

    /// Periods in which something begins.
    const FOLLOW: u32 = 200;
    const DRIFT: u32 = 500;
    const OPEN: u32 = 4000;
    const JUMP: u32 = 4500;
    const END: u32 = 4800;

    /// What the sensors show in a period.
    #[derive(Clone, Copy, Default)]
    struct Signals {
        position: i32,
        pressure_a: i32,
        pressure_b: i32,
    }

    impl Signals {
        fn at(period: u32, middle: i32) -> Self {
            // One count every 8 periods, until the wire opens.
            let drift = (period.clamp(DRIFT, OPEN) - DRIFT) / 8;
            let jump = if period < JUMP { 0 } else { 10_000 };
            // 0.5 V means no pressure, 4.5 V means 10 MPa: 2.09 and 3.5 MPa, which balance on the press's areas.
            let pressure_a = if period < OPEN { PER_VOLT * 1336 / 1000 } else { 0 };
            Self { position: middle + drift.cast_signed() + jump, pressure_a, pressure_b: PER_VOLT * 19 / 10 }
        }
    }

    pub(crate) fn play(memory: &mut Option<Ring>) -> Result<(), StationError> {
        let assembly = Assembly::new(INPUT_UV, OUTPUT_UV)?;
        #[expect(clippy::cast_possible_truncation, reason = "half a stroke is some thousand counts")]
        let middle = (0.5 * assembly.bases().stroke_m * COUNTS_PER_M) as i32;
        let now = Cell::new(Signals::at(0, middle));
        // The valve is as the model says.
        let drive = Drive::<PerUnit>::new::<64>(&press::machine(), press::values::TICK)?;
        let neutral = PerUnit::saturated(f64::from(assembly.neutral()) * PER_COUNT);
        let (output, spool) = (Cell::new(neutral), Cell::new(PerUnit::ZERO));
        let mut valve = drive.valve().map(|valve| (valve, valve.at_rest::<64>(neutral)));
        let devices = Devices {
            inputs: FromFn::<_, INPUT_UV>(|channel| {
                Ok::<i32, Infallible>(match channel {
                    #[expect(clippy::cast_possible_truncation, reason = "some ten thousand counts")]
                    1 => (f64::from(10 * PER_VOLT) * spool.get().to_f64() / press::SPOOL_AT_10_V) as i32,
                    2 => now.get().pressure_a,
                    3 => now.get().pressure_b,
                    _ => 0,
                })
            }),
            position: FromFn::<_>(|| Ok::<i32, Infallible>(now.get().position)),
            output: FromFn::<_, OUTPUT_UV>(|count| {
                output.set(PerUnit::saturated(f64::from(count) * PER_COUNT));
                Ok::<(), Infallible>(())
            }),
        };
        let mut station = assembly.over(devices, Place::Known, memory)?;
        let set_point = SetPoint { position: PerUnit::saturated(0.5), velocity: PerUnit::ZERO };
        for period in 0..END {
            now.set(Signals::at(period, middle));
            if let Some((valve, state)) = &mut valve {
                spool.set(valve.step(state, output.get()).to);
            }
            let command = (period == FOLLOW).then_some(Command::Follow);
            station.step(&Request { set_point, command, timing: Timing::Kept }, &mut Defmt);
        }
        Ok(())
    }
}

#[cfg(all(target_arch = "arm", target_os = "none"))]
#[cortex_m_rt::entry]
fn main() -> ! {
    use defmt_semihosting as _;
    use firmware::app::Ring;
    use mps2::exit;
    use panic_semihosting as _;

    let Some(memory) = cortex_m::singleton!(: Option<Ring> = None) else { exit(false) };
    let ended = played::play(memory);
    if let Err(error) = &ended {
        defmt::error!("{}", defmt::Display2Format(error));
    }
    exit(ended.is_ok())
}

#[cfg(not(all(target_arch = "arm", target_os = "none")))]
fn main() {
    eprintln!("the firmware runs on the target: --target thumbv7em-none-eabihf");
}
