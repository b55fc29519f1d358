//! The firmware on a Raspberry Pi Pico 2: clocks, two SPI buses, the period's timer, the watchdog, the valve's relay, the line to the desktop.
//!
//! `README.md` beside this crate describes the wiring. Everything except pins and peripherals is in the library.
#![no_std]
#![no_main]

use core::cell::RefCell;

use cortex_m::asm;
use cortex_m_stack as stack;
use defmt::Display2Format;
use defmt_rtt as _;
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin, PinState};
use embedded_hal::pwm::SetDutyCycle;
use embedded_hal::spi::{MODE_0, MODE_1};
use embedded_hal_bus::spi::{ExclusiveDevice, RefCellDevice};
use firmware::app::press::{BY_HAND, TICK_NS, values};
use firmware::app::{Desk, Ring, wired_read_back};
use firmware::period::{Answer, Timing, Watchdog};
use firmware::supervision::Defmt;
use nb::Error::WouldBlock;
use panic_probe as _;
use rp235x_hal::block::ImageDef;
use rp235x_hal::clocks::init_clocks_and_plls;
use rp235x_hal::fugit::{ExtU32, MicrosDurationU64, RateExtU32};
use rp235x_hal::gpio::{FunctionPwm, FunctionSpi, FunctionUart, Pins};
use rp235x_hal::pac::Peripherals;
use rp235x_hal::pwm::Slices;
use rp235x_hal::uart::{DataBits, StopBits, UartConfig, UartPeripheral};
use rp235x_hal::{Clock, Sio, Spi, Timer, entry, watchdog};

/// The crystal of the board, Hz.
const CRYSTAL_HZ: u32 = 12_000_000;
/// The oscillator that the processor starts by, MHz: 11 and some; the watchdog counts by it until the crystal runs.
const START_MHZ: u16 = 12;
/// Baud of the line to the desktop.
const BAUD: u32 = 460_800;
/// Time without a healthy period after which the watchdog restarts the controller, ms.
const WATCHDOG_MS: u32 = 10;
/// The same while the parts are set up, ms: a part that is missing at the start restarts the controller, again and again.
const START_MS: u32 = 500;
/// From power to a steady reference of the ADS8688, ms: 15, and some more.
const POWER_UP_MS: u32 = 20;
/// Of the counter's filter clock: 150 MHz / 75 = 2 MHz.
const FILTER_CLOCK_TOP: u16 = 74;
/// Stands for a character that was lost or damaged; it is not a command.
const LOST: u8 = 0xff;

/// What the boot ROM starts: an image for the Arm cores.
#[expect(unsafe_code, reason = "the boot ROM finds the image by the section of this")]
#[unsafe(link_section = ".start_block")]
#[used]
static IMAGE: ImageDef = ImageDef::secure_exe();

#[entry]
fn main() -> ! {
    let memory = cortex_m::singleton!(: Option<Ring> = None);
    if let (Some(board), Some(memory)) = (Peripherals::take(), memory) {
        run(board, memory);
    }
    // Without a station nothing is commanded, the relay stays open, and the log has said why. The watchdog tries again: a part's supply may come late.
    loop {
        asm::nop();
    }
}

/// Wires the board and runs its periods; returns only if it cannot begin, and then the watchdog restarts the controller.
fn run(mut board: Peripherals, memory: &'static mut Option<Ring>) {
    // Before anything that may wait.
    let mut watchdog = watchdog::Watchdog::new(board.WATCHDOG);
    watchdog.enable_tick_generation(START_MHZ);
    watchdog.start(START_MS.millis());
    stack::guard();
    let resets = &mut board.RESETS;
    // 150 MHz for the processor and its peripherals.
    let clocks =
        init_clocks_and_plls(CRYSTAL_HZ, board.XOSC, board.CLOCKS, board.PLL_SYS, board.PLL_USB, resets, &mut watchdog);
    let Ok(clocks) = clocks else { return defmt::error!("no clock by the crystal of {} Hz", CRYSTAL_HZ) };
    let peripheral_hz = clocks.peripheral_clock.freq();
    let mut timer = Timer::new_timer0(board.TIMER0, resets, &clocks);
    let pins = Pins::new(board.IO_BANK0, board.PADS_BANK0, Sio::new(board.SIO).gpio_bank0, resets);

    let mut relay = pins.gpio6.into_push_pull_output_in_state(PinState::Low);
    // High while there may be oil: a broken wire cuts it off too.
    let mut shut_off = pins.gpio7.into_push_pull_output_in_state(PinState::Low);
    let mut lamp = pins.gpio25.into_push_pull_output_in_state(PinState::Low);
    let mut button = pins.gpio15.into_pull_up_input();

    // ADS8688 and AD5754: mode 1, at most 10.5 MHz.
    let to = pins.gpio19.into_function::<FunctionSpi>();
    let from = pins.gpio16.into_function::<FunctionSpi>();
    let clock = pins.gpio18.into_function::<FunctionSpi>();
    let bus = Spi::<_, _, _, 8>::new(board.SPI0, (to, from, clock));
    let bus = RefCell::new(bus.init(resets, peripheral_hz, 10_500.kHz(), MODE_1));
    let select = pins.gpio17.into_push_pull_output_in_state(PinState::High);
    let Ok(inputs) = RefCellDevice::new(&bus, select, timer);
    let select = pins.gpio20.into_push_pull_output_in_state(PinState::High);
    let Ok(output) = RefCellDevice::new(&bus, select, timer);

    // LS7366R: mode 0, at most 2.6 MHz; its filter's clock from a pulse width modulator.
    let to = pins.gpio11.into_function::<FunctionSpi>();
    let from = pins.gpio12.into_function::<FunctionSpi>();
    let clock = pins.gpio10.into_function::<FunctionSpi>();
    let counter = Spi::<_, _, _, 8>::new(board.SPI1, (to, from, clock));
    let counter = counter.init(resets, peripheral_hz, 2_625.kHz(), MODE_0);
    let select = pins.gpio13.into_push_pull_output_in_state(PinState::High);
    let Ok(counter) = ExclusiveDevice::new(counter, select, timer);
    let mut filter_clock = Slices::new(board.PWM, resets).pwm7;
    filter_clock.set_top(FILTER_CLOCK_TOP);
    filter_clock.channel_a.output_to(pins.gpio14.into_function::<FunctionPwm>());
    let Ok(()) = filter_clock.channel_a.set_duty_cycle_percent(50);
    filter_clock.enable();

    let ends = (pins.gpio0.into_function::<FunctionUart>(), pins.gpio1.into_function::<FunctionUart>());
    let line = UartPeripheral::new(board.UART0, ends, resets);
    let line = line.enable(UartConfig::new(BAUD.Hz(), DataBits::Eight, None, StopBits::One), peripheral_hz);
    let Ok(line) = line else { return defmt::error!("no line at {} baud", BAUD) };

    timer.delay_ms(POWER_UP_MS);
    let mut desk = match wired_read_back(inputs, counter, output, &mut timer, memory) {
        Ok(station) => Desk::new(station, BY_HAND),
        Err(error) => return defmt::error!("{}", Display2Format(&error)),
    };

    watchdog.start(WATCHDOG_MS.millis());
    defmt::info!("{} begins, a period of {} ns", values::NAME, TICK_NS);

    let tick = MicrosDurationU64::micros(u64::from(TICK_NS / 1000));
    let mut due = timer.get_counter() + tick;
    let (mut timing, mut longest_us) = (Timing::Kept, 0);
    loop {
        while timer.get_counter() < due {
            // The peripheral keeps 32 characters: more than arrive in a period.
            let mut character = [0];
            let typed = match line.read_raw(&mut character) {
                Ok(1..) => Some(character[0]),
                Ok(0) | Err(WouldBlock) => None,
                Err(nb::Error::Other(_)) => Some(LOST),
            };
            if let Some(Err(error)) = typed.map(|key| desk.key(key)) {
                defmt::warn!("{}", error);
            }
            if line.uart_is_writable()
                && let Some(byte) = desk.byte()
            {
                // The register was found empty, so it takes the byte.
                let _ = line.write_raw(&[byte]);
            }
        }
        let begun = timer.get_counter();
        if button.is_low().unwrap_or(true) {
            desk.stop();
        }
        let report = desk.step(timing, &mut Defmt);
        if let Some(refused) = report.answer.filter(|answer| *answer != Answer::Taken) {
            defmt::warn!("refused: {}", refused);
        }
        if report.watchdog == Watchdog::Feed {
            watchdog.feed();
        }
        let Ok(()) = relay.set_state(PinState::from(report.energised));
        let Ok(()) = shut_off.set_state(PinState::from(!report.shut_off));
        let Ok(()) = lamp.set_state(PinState::from(report.mode.is_running()));

        let now = timer.get_counter();
        due += tick;
        // The next period was due before this one ended: it begins at once, and is told of the overrun.
        timing = if now >= due { Timing::Overrun } else { Timing::Kept };
        if timing == Timing::Overrun {
            due = now;
        }
        let took_us = (now - begun).to_micros();
        if took_us > longest_us {
            longest_us = took_us;
            defmt::debug!("longest period so far: {} us", longest_us);
        }
    }
}
