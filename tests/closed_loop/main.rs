//! Does the machine follow?
//!
//! The machine is the virtual test bed, which shares no equation with the model, measured with the paper's sensors. A tuned PI
//! controller and model-following control get the same set points, limits and readings.
//!
//! `cargo test --release -p system-tests --test closed_loop -- --nocapture` prints all of it; with `RENEW=1` it writes `table.txt` anew.

#[cfg(unix)]
mod faults;
mod following;
#[cfg(unix)]
mod on_target;
mod pi;
mod plan;
#[cfg(unix)]
mod runaway;
mod table;
mod tracking;
