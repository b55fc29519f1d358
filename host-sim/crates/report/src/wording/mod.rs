//! What the crates below found, in sentences: they return values, and the words are made here, once for the terminal, JSON and the page.
//! Each is a clause without full stop.

mod cause;
mod change;
mod comparison;
mod doubt;
mod far_value;
mod finding;
mod location;
mod outside;
mod recordings;
mod simulated;
mod still_moving;
mod structure;
mod tests_to_make;
mod tolerance;
mod unfinished;
mod unit;
mod watch;
mod worse_held_out;

pub use cause::{CAUSES, Cause, cause};
pub use change::{TRADED, change, doubt_of_then, found, most_changed, other_oil, unchanged, whose};
pub use comparison::{obstacle, sentences, unjudged};
pub use doubt::{doubt, mend_first};
pub(crate) use far_value::moved;
pub use far_value::{far_value, far_values};
pub use finding::{advice, claimed, correction_table, correlation, jumps};
pub use location::{error_shape, region, spool_habit};
pub use outside::{outside_cause, outside_explains, outside_kind};
pub(crate) use recordings::about;
pub use recordings::{marks, range_end, recording_advice, taken_as_absolute, unseen, unsettled};
pub use simulated::{linkage_ends, sensor_ends, starts_anywhere, starts_in_play};
pub use still_moving::still_moving;
pub use structure::{shown, structure, structure_shown, yardstick};
pub use tests_to_make::{look_alikes, separated_by};
pub use tolerance::{WITHIN, at_limit, tolerated_thing, used_up};
pub use unfinished::{best_so_far, left_out, limit_reached, not_tried, slow, spent};
pub use unit::{notes, own_notes, unit_doubt, unit_notes};
pub use watch::{share, watched};
pub use worse_held_out::fit_is_worse;

/// A clause with a capital letter, as a sentence begins.
#[must_use]
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
