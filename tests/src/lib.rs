//! What the system tests share: the drives, the core and the oracle on the same commands, machines drawn at random, the bench with the
//! virtual test bed, and the other end of the firmware's loop.

pub mod any_effects;
pub mod any_machine;
pub mod anything;
#[path = "../../host-sim/tests/at_hand/mod.rs"]
pub mod at_hand;
pub mod cycles;
pub mod drives;
pub mod emulator;
#[cfg(unix)]
pub mod in_the_loop;
pub mod page;
#[cfg(unix)]
#[path = "../../firmware/tests/rig/parts.rs"]
#[expect(dead_code, reason = "the firmware's own tests break more of them")]
mod parts;
pub mod peers_signal;
pub mod python;
pub mod rig;
pub mod simulate;
pub mod snapshot;
