//! Many drives, every night: which has changed, in what, how fast.
//!
//! The unit of work is one drive and one night ([`Night`]): the drive's machine file with what is known of it, and its new recordings. [`judge`] makes a
//! [`Row`] of it: the recordings are [watched](watch::watch()); of a drive that left its band a diagnosis says what has changed since; of the others the
//! amounts of their effects are fitted anew. Nights know nothing of each other, so they may be judged in any order, anywhere.
//!
//! [`nights`] finds them in a folder, [`Table`] keeps the rows in Parquet, and [`Pending`] brings both together: whenever it is killed, the next goes on
//! where it was.
#![forbid(unsafe_code)]
// Results are returned: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]

mod columns;
mod dataset;
mod night;
mod row;
mod run;
mod table;

pub use columns::{column_of, deviation_of};
pub use dataset::{Night, nights, nights_of};
pub use night::{How, Upto, judge, unusable};
pub use row::{Judgement, MISFITS, Row, Strength, Tally};
pub use run::{FleetError, Pending};
pub use table::{Table, TableError, of_parquet, rows, to_parquet};
