//! A baked drive as a task of RTIC: one step every millisecond, and its trace on the console from a task below.
//!
//! `cargo run --release` in this folder runs it in QEMU.
#![no_std]
#![no_main]

use panic_semihosting as _;

/// What `host-sim export --bake` wrote.
#[allow(dead_code, reason = "an exported file is for anybody, and not all of it is needed")]
mod params {
    include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../baked.rs"));
}

// The task is due once a millisecond: so long is the tick that was baked.
const _: () = assert!(matches!(params::TICK, model_core::machine::Tick::OneMillisecond));

#[rtic::app(device = mps2_device, peripherals = false, dispatchers = [UART1_RX, UART1_TX])]
mod app {
    use core::fmt::Write;

    use cortex_m_semihosting::{debug, hio};
    use model_core::drive::{BakedDrive, DriveInput, DriveState, Load};
    use model_core::number::{Number, PerUnit};
    use model_core::ports::ChamberState;
    use mps2_device::{CLOCK_HZ, Watchdog};
    use rtic_monotonics::systick::prelude::*;
    use rtic_sync::channel::{Receiver, Sender};
    use rtic_sync::make_channel;

    use crate::params;

    // The tick of the drive: 1 ms.
    systick_monotonic!(Mono, 1000);

    type State = DriveState<PerUnit, { params::DELAY_LINE }>;

    /// Ticks that are run, and of which one is printed.
    const TICKS: u32 = 600;
    const PRINTED: u32 = 50;
    /// Rows that the console may be behind.
    const ROOM: usize = 8;
    /// Time without a tick in time after which the watchdog acts: 10 ms.
    const WATCHDOG: u32 = CLOCK_HZ / 100;

    /// What the console prints.
    pub struct Row {
        tick: u32,
        state: State,
        overruns: u32,
    }

    #[shared]
    struct Shared {}

    #[local]
    struct Local {}

    #[init]
    fn init(context: init::Context) -> (Shared, Local) {
        Mono::start(context.core.SYST, CLOCK_HZ);
        let (rows, printed) = make_channel!(Row, ROOM);
        // Each is spawned once, so neither is refused.
        let _ = drive::spawn(rows, Watchdog::start(WATCHDOG));
        let _ = console::spawn(printed);
        (Shared {}, Local {})
    }

    /// The drive, above everything else that may wait.
    #[task(priority = 2)]
    async fn drive(_: drive::Context, mut rows: Sender<'static, Row, ROOM>, watchdog: Watchdog) {
        let drive = BakedDrive::<params::Exported>::new();
        let half = PerUnit::ONE.halved();
        let mut state: State = drive.at_rest(PerUnit::ZERO, ChamberState { a: half, b: half }, half.as_travel());
        let (mut due, mut overruns) = (Mono::now(), 0);
        for tick in 1..=TICKS {
            due += 1.millis();
            Mono::delay_until(due).await;
            // 5 V for 0.3 s, then -2.5 V: inputs are read here, and outputs written.
            let command = if tick <= TICKS / 2 { half } else { -half.halved() };
            drive.step(&mut state, DriveInput::Command(command), Load::NONE);
            // The next tick is due already.
            if Mono::now() > due {
                overruns += 1;
            } else {
                watchdog.feed();
            }
            if tick % PRINTED == 0 {
                // A console that is behind loses a row; the drive does not wait for it.
                let _ = rows.try_send(Row { tick, state, overruns });
            }
        }
    }

    /// Whatever may take longer than a tick.
    #[task(priority = 1)]
    async fn console(_: console::Context, mut rows: Receiver<'static, Row, ROOM>) {
        let Ok(mut console) = hio::hstdout() else { return debug::exit(debug::EXIT_FAILURE) };
        while let Ok(Row { tick, state, overruns }) = rows.recv().await {
            let DriveState { chambers, motion, .. } = &state;
            let words = [state.valve.spool(), chambers.a, chambers.b, motion.velocity].map(PerUnit::to_bits);
            let position = motion.position.to_bits();
            let _ = writeln!(console, "{tick} {words:?} {position}, overruns {overruns}");
        }
        // The drive has ended, and dropped its end.
        debug::exit(debug::EXIT_SUCCESS);
    }

    #[idle]
    fn idle(_: idle::Context) -> ! {
        loop {
            cortex_m::asm::wfi();
        }
    }
}
