//! The firmware on a NUCLEO-F446RE: clocks, one SPI bus per part, the period's timer, the watchdog, the valve's relay, the line to the desktop.
//!
//! `README.md` beside this crate describes the wiring. Everything except pins and peripherals is in the library.
#![no_std]
#![no_main]

mod keys;

use cortex_m::asm;
use cortex_m_rt::entry;
use cortex_m_stack as stack;
use defmt::Display2Format;
use defmt_rtt as _;
use embedded_hal::spi::{MODE_0, MODE_1};
use embedded_hal_bus::spi::ExclusiveDevice;
use firmware::app::press::{BY_HAND, TICK_NS, values};
use firmware::app::{Desk, Ring, wired_read_back};
use firmware::period::{Answer, Timing, Watchdog};
use firmware::supervision::Defmt;
use panic_probe as _;
use stm32f4xx_hal::dwt::DwtExt;
use stm32f4xx_hal::gpio::PinState;
use stm32f4xx_hal::pac::Peripherals;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use stm32f4xx_hal::serial::{Serial, TxISR};
use stm32f4xx_hal::watchdog::IndependentWatchdog;

/// Baud of the line through the ST-LINK.
const BAUD: u32 = 460_800;
/// Time without a healthy period after which the watchdog restarts the controller, ms; its own clock may be half slower or half faster.
const WATCHDOG_MS: u32 = 10;
/// The same while the parts are set up, ms: a part that is missing at the start restarts the controller, again and again.
const START_MS: u32 = 500;
/// From power to a steady reference of the ADS8688, ms: 15, and some more.
const POWER_UP_MS: u32 = 20;

#[entry]
fn main() -> ! {
    let memory = cortex_m::singleton!(: Option<Ring> = None);
    if let (Some(board), Some(core), Some(memory)) = (Peripherals::take(), cortex_m::Peripherals::take(), memory) {
        run(board, core, memory);
    }
    // Without a station nothing is commanded, the relay stays open, and the log has said why. The watchdog tries again: a part's supply may come late.
    loop {
        asm::nop();
    }
}

/// Wires the board and runs its periods; returns only if it cannot begin, and then the watchdog restarts the controller.
fn run(board: Peripherals, mut core: cortex_m::Peripherals, memory: &'static mut Option<Ring>) {
    // Before anything that may wait: its own clock needs no other.
    let mut watchdog = IndependentWatchdog::new(board.IWDG);
    watchdog.start(START_MS.millis());
    stack::guard(&mut core.MPU);
    // 8 MHz from the ST-LINK; 168 MHz without overdrive: 84 MHz for SPI1 and the timers, 42 MHz for SPI2, SPI3 and USART2.
    let mut rcc = board.RCC.freeze(Config::hse(8.MHz()).bypass_hse_oscillator().sysclk(168.MHz()));
    let dwt = core.DWT.constrain(core.DCB, &rcc.clocks);
    let mut delay = dwt.delay();
    let (a, b) = (board.GPIOA.split(&mut rcc), board.GPIOB.split(&mut rcc));
    let (c, d) = (board.GPIOC.split(&mut rcc), board.GPIOD.split(&mut rcc));

    let mut relay = c.pc8.into_push_pull_output_in_state(PinState::Low);
    // High while there may be oil: a broken wire cuts it off too.
    let mut shut_off = c.pc9.into_push_pull_output_in_state(PinState::Low);
    let mut lamp = a.pa5.into_push_pull_output_in_state(PinState::Low);
    let button = c.pc13.into_input();

    // ADS8688: mode 1, 42 MHz / 4 = 10.5 MHz.
    let pins = (Some(b.pb13), Some(b.pb14), Some(b.pb15));
    let inputs = board.SPI2.spi(pins, MODE_1, 10_500.kHz(), &mut rcc);
    let select = b.pb1.into_push_pull_output_in_state(PinState::High);
    let Ok(inputs) = ExclusiveDevice::new(inputs, select, dwt.delay());

    // AD5754: mode 1, 84 MHz / 8 = 10.5 MHz; PB3 and PB4 belong to JTAG after a reset.
    let pins = (Some(b.pb3.into_input()), Some(b.pb4.into_input()), Some(b.pb5));
    let output = board.SPI1.spi(pins, MODE_1, 10_500.kHz(), &mut rcc);
    let select = b.pb10.into_push_pull_output_in_state(PinState::High);
    let Ok(output) = ExclusiveDevice::new(output, select, dwt.delay());

    // LS7366R: mode 0, 42 MHz / 16 = 2.6 MHz; its filter's clock from a timer.
    let pins = (Some(c.pc10), Some(c.pc11), Some(c.pc12));
    let counter = board.SPI3.spi(pins, MODE_0, 2_625.kHz(), &mut rcc);
    let select = d.pd2.into_push_pull_output_in_state(PinState::High);
    let Ok(counter) = ExclusiveDevice::new(counter, select, dwt.delay());
    let (_, (filter_clock, ..)) = board.TIM3.pwm_hz(2.MHz(), &mut rcc);
    let mut filter_clock = filter_clock.with(c.pc6);
    filter_clock.set_duty(filter_clock.get_max_duty() / 2);
    filter_clock.enable();

    let line = Serial::new(board.USART2, (a.pa2, a.pa3), BAUD.bps(), &mut rcc);
    let Ok((mut line, typed)) = line.map(Serial::split) else { return defmt::error!("no line at {} baud", BAUD) };
    keys::listen(typed);

    delay.delay_ms(POWER_UP_MS);
    let mut desk = match wired_read_back(inputs, counter, output, &mut delay, memory) {
        Ok(station) => Desk::new(station, BY_HAND),
        Err(error) => return defmt::error!("{}", Display2Format(&error)),
    };

    let mut timer = board.TIM5.counter_us(&mut rcc);
    if timer.start((TICK_NS / 1000).micros()).is_err() {
        return defmt::error!("no period of {} ns", TICK_NS);
    }
    watchdog.start(WATCHDOG_MS.millis());
    defmt::info!("{} begins, a period of {} ns", values::NAME, TICK_NS);

    let (mut timing, mut longest_us) = (Timing::Kept, 0);
    loop {
        while timing == Timing::Kept && timer.wait().is_err() {
            if let Some(Err(error)) = keys::next().map(|key| desk.key(key)) {
                defmt::warn!("{}", error);
            }
            if line.is_tx_empty()
                && let Some(byte) = desk.byte()
            {
                // The register was found empty, so it takes the byte.
                let _ = line.write(byte);
            }
        }
        if button.is_low() {
            desk.stop();
        }
        let report = desk.step(timing, &mut Defmt);
        if let Some(refused) = report.answer.filter(|answer| *answer != Answer::Taken) {
            defmt::warn!("refused: {}", refused);
        }
        if report.watchdog == Watchdog::Feed {
            watchdog.feed();
        }
        relay.set_state(PinState::from(report.energised));
        shut_off.set_state(PinState::from(!report.shut_off));
        lamp.set_state(PinState::from(report.mode.is_running()));

        let took_us = timer.now().ticks();
        // The next period was due before this one ended: it begins at once, and is told of the overrun.
        timing = if timer.wait().is_ok() { Timing::Overrun } else { Timing::Kept };
        if took_us > longest_us {
            longest_us = took_us;
            defmt::debug!("longest period so far: {} us", longest_us);
        }
    }
}
