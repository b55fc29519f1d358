//! The choice of effects: screening, refits of candidate models, forward selection on the training recordings, and the veto of the held-out ones.
//! Start at [`forward`]; every threshold is in [`decision_rule`].

pub mod candidate;
mod confirmation;
pub mod decision_rule;
mod effect_parameter;
pub mod excerpt;
mod extended;
pub mod forward;
mod full_length;
mod inflated_noise;
pub mod likelihood;
mod misfit_ranking;
mod outcome;
mod round;
pub mod screen;
pub(crate) mod search;
pub(crate) mod searched;
mod stick_slip;
mod valve;
pub(crate) mod veto;

pub use candidate::{Candidate, Chosen, Question};
pub use confirmation::{Confirmation, confirm};
pub use extended::extended;
pub use full_length::lengthened;
pub(crate) use likelihood::Gained;
pub use outcome::{JumpEvidence, JumpsFound, Selection, Trial};
pub(crate) use round::explains_enough;
pub use searched::{Searched, Stage};
pub use valve::jump_spacing::JumpSpacing;
