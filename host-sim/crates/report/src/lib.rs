//! Results for programs ([`json`]), for the terminal ([`terminal`]) and as a page for people ([`html`]).
//!
//! Every output is a view of one [`Diagnosis`](diagnosis::Diagnosis), [`Comparison`](identification::compare::Comparison) or plan: the crates below
//! return values, and the texts are made here. Start at [`html`] for the page with its evidence ([`evidence`]), at [`plot`] for a single chart;
//! [`refused`] says why something could not be done.
//! Nothing here simulates again to decide something, and nothing prints: text is returned.
#![forbid(unsafe_code)]
// All text is returned: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]
// No mathematics of the platform: its last bit differs from one to the next (clippy.toml).
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod evidence;
pub mod html;
pub mod inspect;
pub mod json;
pub mod plan;
pub mod plot;
pub mod refused;
pub mod size;
pub mod statics;
pub mod terminal;
pub mod wording;
