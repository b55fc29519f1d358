//! A diagnosis and its evidence, for programs.

pub mod diagnosis;
mod evidence;
mod structure;

pub use diagnosis::document;
