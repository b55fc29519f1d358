//! Does the machine follow?
//!
//! The machine is the virtual test bed, which shares no equation with the model, seen through the paper's sensors. A tuned PI
//! controller and model-following control get the same set points, limits and readings.
//!
//! `cargo test --release -p system-tests --test closed_loop -- --nocapture` prints all of it; with `RENEW=1` it writes `table.txt` anew.

mod following;
#[cfg(unix)]
mod on_target;
#[cfg(unix)]
#[path = "../../firmware/tests/rig/parts.rs"]
#[expect(dead_code, reason = "the firmware's own tests break more of them")]
mod parts;
mod pi;
#[cfg(unix)]
mod processor;
mod rig;
mod table;
mod tracking;
