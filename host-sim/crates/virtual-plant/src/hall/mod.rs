//! Drives as they stand in a hall, at random: of which only the data sheet is known.
//!
//! What a drive is lies within what its sheet can mean ([`Hall`]), and what it has beyond within its drawing; a part of it may be [worn](Worn). It is recorded for as
//! short as such recordings are, inside its stroke ([`runs`]).

mod drive;
mod installed;
mod nights;
mod recordings;
mod visibility;
mod worn;

pub use drive::Hall;
pub use nights::{OfHall, OneNight, Shop, Wear, of_hall};
pub use recordings::{Change, DURATION_S, RECORDINGS, Run, name, recorded, runs, stays_inside};
pub use visibility::{channel, shows};
pub use worn::{Worn, made, times};
