//! Interrupts by name and number, and the vectors that call their handlers; `device.x` gives a name without a handler the default one.
#![expect(unsafe_code, reason = "vectors are at a place of their own, and lead to functions that are found by name")]

use cortex_m::interrupt::InterruptNumber;

/// A handler.
type Vector = unsafe extern "C" fn();

/// Vectors of the boards.
const VECTORS: usize = 32;

unsafe extern "C" {
    fn DefaultHandler();
}

macro_rules! interrupts {
    ($($name:ident $meaning:literal),*) => {
        /// An interrupt. Its number is its place in the list.
        #[expect(non_camel_case_types, reason = "named as device crates name them")]
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u16)]
        pub enum Interrupt {
            $(#[doc = $meaning] $name),*
        }

        unsafe extern "C" {
            $(fn $name();)*
        }

        const fn vectors() -> [Vector; VECTORS] {
            let mut vectors: [Vector; VECTORS] = [DefaultHandler; VECTORS];
            $(vectors[Interrupt::$name as usize] = $name;)*
            vectors
        }
    };
}

interrupts!(
    UART0_RX "UART 0 has received.",
    UART0_TX "UART 0 has sent.",
    UART1_RX "UART 1 has received.",
    UART1_TX "UART 1 has sent.",
    UART2_RX "UART 2 has received.",
    UART2_TX "UART 2 has sent.",
    GPIO0 "A pin of port 0.",
    GPIO1 "A pin of port 1.",
    TIMER0 "Timer 0 has elapsed.",
    TIMER1 "Timer 1 has elapsed.",
    DUAL_TIMER "The dual timer has elapsed.",
    SPI "An SPI bus.",
    UART_OVERFLOW "A UART has lost a byte."
);

/// Where start-up code expects them.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
static __INTERRUPTS: [Vector; VECTORS] = vectors();

// SAFETY: the number is the place of the interrupt in the boards' list, and stays so.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}
