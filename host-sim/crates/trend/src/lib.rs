//! What wears: how much there is of every effect over months, since when it changes, how fast, and when it reaches its limit.
//!
//! A [`Trend`] is the amount of one effect of one drive, night by night: pieces between change points ([`Piece`]), each a level or a straight
//! [`Line`]. [`wears`] makes one of every amount in the rows of a [fleet]'s table, with its limit, the most urgent first; [`page`] shows them.
#![forbid(unsafe_code)]
// Results are returned: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]
// No mathematics of the platform: its last bit differs from one to the next (clippy.toml).
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod line;
mod page;
mod pieces;
mod trend;
mod wear;
mod words;

pub use line::{Line, Point, Reach};
pub use page::page;
pub use pieces::Piece;
pub use trend::Trend;
pub use wear::{Given, Limit, LimitError, Limits, Urgency, Wear, WearError, Wears, date_of, wears};
pub use words::{headline, limit, name, now, state, to_limit};
