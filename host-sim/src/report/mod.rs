//! What was found, for programs ([`json`]), for the terminal ([`terminal`]) and for people ([`html`]). Every output is a view
//! of one [`Diagnosis`](crate::diagnose::Diagnosis).

mod exhibits_json;
pub mod html;
pub mod inspect;
pub mod json;
pub mod plan;
pub mod statics;
pub mod terminal;
