//! A diagnosis and its evidence, a comparison and a refit, for programs.

mod comparison;
pub mod diagnosis;
mod evidence;
mod refit;
mod structure;
mod watch;

pub use comparison::{comparison, comparisons};
pub use diagnosis::document;
pub use refit::refit;
pub use watch::watch;
