//! Parameters of a drive from recordings, and how well a model follows a recording.
//!
//! The data flow: a recording becomes a [`Prepared`](experiment::Prepared) case (drive input, judged signals, the noise of each), a
//! machine and its cases become residuals in standard deviations of that noise, and [`fit::fit()`] finds the parameters that
//! minimise these. Start there, or at [`compare::compare()`] for a comparison without a fit. [`static_curve`] reads measured
//! characteristics. Nothing here knows an effect by name or accepts an effect: `diagnosis` does that.
#![forbid(unsafe_code)]
// Results are returned: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]
// No mathematics of the platform: its last bit differs from one to the next (clippy.toml).
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod along;
pub mod clock;
pub mod compare;
pub mod effort;
mod error;
pub mod experiment;
pub mod fit;
pub mod input_noise;
pub mod parallel;
pub mod static_curve;
pub mod stop;
pub mod visible;
pub mod yardstick;
