//! Instructions and estimated cycles of a function on a Cortex-M4F or a Cortex-M3, from an execution trace of QEMU.
//!
//! QEMU runs an image one instruction at a time and writes each program counter ([`traced`]). What lies between the entry of the function and
//! its return is a tick. The image says which instruction stands at an address ([`decoded`]); Arm's technical reference manuals say how long it
//! takes, in three readings where they leave something open ([`timing`]); the pairing of neighbours is in [`path`]. Flash without wait
//! states. Nothing of this was measured on silicon.
//!
//! It takes any image: an ELF file, the names of the functions to count and the name of the function that calls them.

mod classes;
pub mod decoded;
pub mod path;
pub mod timing;
pub mod traced;

pub use path::Cost;
pub use timing::Reading;

/// Mean and worst of several ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// Mean.
    pub mean: Cost,
    /// The largest of each figure, which need not be of one tick.
    pub worst: Cost,
}

impl Costs {
    /// Of these ticks; `None` where there are none.
    #[must_use]
    pub fn of(ticks: &[Cost]) -> Option<Self> {
        let count = ticks.len() as f64;
        let (&first, rest) = ticks.split_first()?;
        let (sum, worst) = rest.iter().fold((first, first), |(sum, worst), tick| {
            (sum.with(tick, |one, other| one + other), worst.with(tick, f64::max))
        });
        Some(Self { mean: sum.with(&sum, |one, _| one / count), worst })
    }
}
