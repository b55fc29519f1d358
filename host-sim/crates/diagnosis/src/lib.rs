//! TODO.

mod before_after;
pub mod catalogue;
pub mod correction_table;
mod decision;
mod diagnose;
mod finding;
pub mod localisation;
pub mod selection;
#[cfg(test)]
mod test_scene;

pub use before_after::{Fits, Shown};
pub use diagnose::{DiagnoseError, Diagnosis, Progress, Verdict, diagnose, ordinary, steps};
pub use finding::Finding;
