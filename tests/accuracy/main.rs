//! How far is the core from the true solution?
//!
//! The oracle is the virtual test bed's plant, solved to 1e-10: it shares no equation with the core. The allowed errors are
//! in `tolerances.rs` and nowhere else; the errors found are in `table.txt`.
//!
//! `cargo test -p system-tests --test accuracy -- --nocapture` prints all of it; with `RENEW=1` it writes `table.txt` anew.

mod effects;
mod hour;
mod loads;
mod order;
mod signals;
mod table;
mod ticks;
mod tolerances;
