//! Stores characters from the desktop as they arrive: a period takes longer than a character, and the peripheral keeps only one.

use core::cell::RefCell;

use cortex_m::interrupt::{Mutex, free};
use cortex_m::peripheral::NVIC;
use heapless::Deque;
use nb::Error::WouldBlock;
use stm32f4xx_hal::pac::{Interrupt, USART2, interrupt};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::serial::{Rx, RxListen};

/// Stands for a character that was lost or damaged; it is not a command.
const LOST: u8 = 0xff;

/// The line, and what has arrived.
struct Keys {
    line: Option<Rx<USART2>>,
    arrived: Deque<u8, 64>,
}

static KEYS: Mutex<RefCell<Keys>> = Mutex::new(RefCell::new(Keys { line: None, arrived: Deque::new() }));

/// Listens from now on.
pub(crate) fn listen(mut line: Rx<USART2>) {
    line.listen();
    free(|section| KEYS.borrow(section).borrow_mut().line = Some(line));
    #[expect(unsafe_code, reason = "an interrupt is let through")]
    // SAFETY: the handler below shares only what is behind the mutex, and no critical section relies on the mask.
    unsafe {
        NVIC::unmask(Interrupt::USART2);
    }
}

/// The oldest character that was not fetched yet.
pub(crate) fn next() -> Option<u8> {
    free(|section| KEYS.borrow(section).borrow_mut().arrived.pop_front())
}

#[interrupt]
fn USART2() {
    free(|section| {
        let mut keys = KEYS.borrow(section).borrow_mut();
        let Keys { line: Some(line), arrived } = &mut *keys else { return };
        let character = match line.read() {
            Ok(character) => character,
            Err(WouldBlock) => return,
            Err(nb::Error::Other(_)) => LOST,
        };
        if arrived.push_back(character).is_err() {
            // Without room, later characters count as lost too, until one is fetched.
            let _ = arrived.pop_back();
            let _ = arrived.push_back(LOST);
        }
    });
}
