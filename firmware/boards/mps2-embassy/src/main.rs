//! The press's control period as a task of Embassy: it awaits its buses, and its reports go to the console from a task below.
//!
//! `cargo run --release` in this folder runs it in QEMU. The parts and their machine are simulated in memory (`simulated_press::parts`).
#![no_std]
#![no_main]

mod bus;

use core::cell::RefCell;
use core::fmt::Write;

use cortex_m::peripheral::NVIC;
use embassy_executor::InterruptExecutor;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Delay, Duration, Instant, Timer};
use firmware::app::{StationError, press};
use firmware::io::ad5754;
use firmware::io::asynchronous::{Ad5754, Ads8688, Ls7366r};
use firmware::io::ls7366r::FilterClock;
use firmware::period::{Devices, Period, Place, Timing, Watchdog as Asked};
use mps2_device::{CLOCK_HZ, Interrupt, NVIC_PRIO_BITS, Watchdog, interrupt};
use panic_semihosting as _;
use simulated_press::parts::{Part, Parts, Plant, Wire};
use simulated_press::short_run::{PERIODS, Row, RunError, Script, home, rig};
use systick_timer::SystickDriver;

use crate::bus::Transfers;

/// The period.
const PERIOD: Duration = Duration::from_millis(1);
/// `SysTick` interrupts ten times a period and wakes what is due: a task begins up to 0.1 ms late. A HAL's time driver wakes it in time.
const RELOAD: u32 = CLOCK_HZ / 10_000 - 1;
/// Time without a healthy period after which the watchdog acts: 10 ms.
const WATCHDOG: u32 = CLOCK_HZ / 100;
/// The same while the coefficients are computed and the parts set up: 0.5 s.
const START: u32 = CLOCK_HZ / 2;
/// Timers that may wait at once.
const TIMERS: usize = 4;

embassy_time_driver::time_driver_impl!(static TIME: SystickDriver<TIMERS> = SystickDriver::new(CLOCK_HZ as u64, RELOAD));

#[cortex_m_rt::exception]
fn SysTick() {
    TIME.systick_interrupt();
}

/// Runs the control period: everything that must keep its time.
static CONTROL: InterruptExecutor = InterruptExecutor::new();
/// Runs what may wait.
static BELOW: InterruptExecutor = InterruptExecutor::new();

#[cortex_m_rt::interrupt]
unsafe fn UART1_RX() {
    // SAFETY: the only call, and the executor was started before its interrupt was unmasked.
    unsafe { CONTROL.on_interrupt() }
}

#[cortex_m_rt::interrupt]
unsafe fn UART1_TX() {
    // SAFETY: as above.
    unsafe { BELOW.on_interrupt() }
}

/// From the period to the console.
enum Message {
    Row(Row),
    Ended(Result<(), RunError>),
}

static MESSAGES: Channel<CriticalSectionRawMutex, Message, 8> = Channel::new();

#[embassy_executor::task]
async fn control(watchdog: Watchdog) {
    let ended = periods(&watchdog).await;
    MESSAGES.send(Message::Ended(ended)).await;
}

async fn periods(watchdog: &Watchdog) -> Result<(), RunError> {
    let (rig, control, bases) = rig()?;
    let mut script = Script::new(&bases)?;
    let mut plant = Plant::new(&press::machine()).map_err(StationError::from)?;
    let parts = RefCell::new(Parts::new());
    let bus = |part| Transfers(Wire { parts: &parts, part });

    let neutral = rig.calibration.output.count(rig.limits.neutral);
    let (channel, reference) = (ad5754::Channel::A, ad5754::Reference::External);
    let output = Ad5754::begin(bus(Part::Output), &mut Delay, channel, reference, neutral).await;
    let inputs = Ads8688::begin(bus(Part::Inputs), press::RANGES).await.map_err(|_| RunError::Part(Part::Inputs))?;
    let position = Ls7366r::begin(bus(Part::Counter), FilterClock::Undivided).await;
    let position = position.map_err(|_| RunError::Part(Part::Counter))?;
    let output = output.map_err(|_| RunError::Part(Part::Output))?;
    let begun = Period::begin_async(Devices { inputs, position, output }, rig, control, Place::Lost).await;
    let mut period = begun.map_err(|_| RunError::Part(Part::Output))?;
    plant.tick(&parts);
    period.home(home());

    watchdog.set(WATCHDOG);
    let (mut due, mut timing) = (Instant::now(), Timing::Kept);
    for number in 1..=PERIODS {
        due += PERIOD;
        // Where it is past already, it begins at once.
        if Instant::now() < due {
            Timer::at(due).await;
        }
        let report = period.step_async(&script.request(number, timing), &mut ()).await;
        // The next period is due already: it begins at once, and is told.
        timing = if Instant::now() < due + PERIOD { Timing::Kept } else { Timing::Overrun };
        if report.watchdog == Asked::Feed {
            watchdog.feed();
        }
        plant.tick(&parts);
        if let Some(row) = Row::of(number, &report) {
            // A console that is behind loses a row; the period does not wait for it.
            let _ = MESSAGES.try_send(Message::Row(row));
        }
    }
    Ok(())
}

#[embassy_executor::task]
async fn told() {
    let Some(mut console) = mps2::console() else { mps2::exit(false) };
    loop {
        let written = match MESSAGES.receive().await {
            Message::Row(row) => writeln!(console, "{row}"),
            Message::Ended(Ok(())) => mps2::exit(true),
            Message::Ended(Err(error)) => {
                let _ = writeln!(console, "{error}");
                mps2::exit(false)
            }
        };
        if written.is_err() {
            mps2::exit(false);
        }
    }
}

/// The register's value of a priority; 0 is the highest.
const fn priority(level: u8) -> u8 {
    level << (8 - NVIC_PRIO_BITS)
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let Some(mut core) = cortex_m::Peripherals::take() else { mps2::exit(false) };
    TIME.start(&mut core.SYST);
    // SAFETY: nothing is masked by priority. SysTick and the bus stay at 0, above both executors.
    unsafe {
        core.NVIC.set_priority(Interrupt::UART1_RX, priority(1));
        core.NVIC.set_priority(Interrupt::UART1_TX, priority(2));
        NVIC::unmask(Interrupt::TIMER1);
    }
    let (Ok(control), Ok(told)) = (control(Watchdog::start(START)), told()) else { mps2::exit(false) };
    CONTROL.start(Interrupt::UART1_RX).spawn(control);
    BELOW.start(Interrupt::UART1_TX).spawn(told);
    loop {
        cortex_m::asm::wfi();
    }
}
