//! What the system tests share: the drives, the core and the oracle on the same commands, and machines drawn at random.

pub mod any_effects;
pub mod any_machine;
#[path = "../../host-sim/tests/at_hand/mod.rs"]
pub mod at_hand;
pub mod drives;
pub mod emulator;
pub mod simulate;
pub mod snapshot;
