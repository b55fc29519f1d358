//! What was found, for programs ([`json`]), for the terminal ([`terminal`]) and for people ([`html`]). Every output is a view
//! of one [`Diagnosis`](diagnosis::Diagnosis).

pub mod evidence;
pub mod html;
pub mod inspect;
pub mod json;
pub mod plan;
pub mod plot;
pub mod statics;
pub mod terminal;
