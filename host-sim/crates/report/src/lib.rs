//! What was found, for programs ([`json`]), for the terminal ([`terminal`]) and for people ([`html`]).
//!
//! Every output is a view of one [`Diagnosis`](diagnosis::Diagnosis), [`Comparison`](identification::compare::Comparison) or plan: the crates below
//! return values, and words are made here. Start at [`html`] for the page with its evidence ([`evidence`]), at [`plot`] for a single chart. Nothing here
//! simulates anew to decide something, and nothing prints: text is returned.
#![forbid(unsafe_code)]
// What there is to say is returned: nothing but the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]

pub mod evidence;
pub mod html;
pub mod inspect;
pub mod json;
pub mod plan;
pub mod plot;
pub mod statics;
pub mod terminal;
