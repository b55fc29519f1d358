//! Parameters of a drive from recordings, and how well a model follows a recording.
//!
//! The data's way: a recording becomes a [`Prepared`](experiment::Prepared) case (drive input, judged signals, the noise of each), a machine
//! and its cases become residuals in standard deviations of that noise, and [`fit::fit()`] finds the parameters that make these least. Start there, or at
//! [`compare::compare()`] for a comparison without a fit. [`static_curve`] reads measured characteristics. Nothing here knows an effect by name or accepts
//! one: that is `diagnosis`.
#![forbid(unsafe_code)]
// What there is to say is returned: nothing but the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]

pub mod clock;
pub mod compare;
mod error;
pub mod experiment;
pub mod fit;
pub mod input_noise;
pub mod parallel;
pub mod static_curve;
