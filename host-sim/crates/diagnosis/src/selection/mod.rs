//! TODO.

pub mod candidate;
mod confirmation;
pub mod excerpt;
mod extended;
pub mod forward;
mod full_length;
mod inflated_noise;
pub mod likelihood;
mod misfit_ranking;
pub mod screen;
mod search;
mod valve;

pub use candidate::{Candidate, Chosen, Question};
pub use confirmation::{Confirmation, confirm};
pub use extended::extended;
pub use full_length::lengthened;
pub(crate) use likelihood::Gained;
pub use valve::unmeasured_spool::{Heard, Told};
