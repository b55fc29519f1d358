//! A diagnosis and its evidence, for programs.

pub mod diagnosis;
mod evidence;

pub use diagnosis::document;
