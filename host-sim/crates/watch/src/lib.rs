//! Does a drive still follow its model as it did while it was healthy?
//!
//! A recording is simulated with the drive's own machine file, in the controller's arithmetic, and the difference is monitored by the controller's own
//! monitor ([`firmware::monitor`]): the average of the innovation's square over that of a healthy drive, against a limit that follows from how often a false
//! alarm may come. A recording takes milliseconds, so it is asked of thousands a night; what has changed in a drive that left its band, `diagnosis` says.
//!
//! Start at [`healthy`], which finds the [`Band`](machine_file::Band) from recordings of a healthy drive, and at [`watch()`], which judges another by it.
#![forbid(unsafe_code)]
// Results are returned: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]
// No mathematics of the platform: its last bit differs from one to the next (clippy.toml).
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod band;
mod error;
mod innovation;
mod watched;

pub use band::healthy;
pub use error::WatchError;
pub use firmware::monitor::{Link, MonitoredSignal};
pub use watched::{FALSE_ALARMS, Left, Seen, Watched, watch};
