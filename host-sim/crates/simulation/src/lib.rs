//! The reference model run along a recording: in fixed point as on the target, in `f64`, with derivatives, or several drives at once.
//!
//! A recording and a machine become a [`Stimulus`] (what drives the model, tick by tick); a stimulus and a machine become a [`Trajectory`].
//! Start at [`simulate_fixed`] or [`simulate_f64`]; [`run_in_lanes`] runs up to four recordings in SIMD lanes, [`Derivatives`] adds the
//! derivatives with respect to parameters, [`Live`] steps a drive whose inputs its caller supplies. The equations are those of `model-core`,
//! run on other number types that stay inside this crate. Nothing is judged here: noise levels are in [`signal`], fits in `identification`.
#![forbid(unsafe_code)]
// Results are returned: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]
// No mathematics of the platform: its last bit differs from one to the next (clippy.toml).
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod arithmetic;
mod derivatives;
mod error;
pub mod figures_of_merit;
mod grid;
mod in_chunks;
mod in_lanes;
mod initial_state;
mod input_point;
pub mod number;
mod outflow;
mod recorded_start;
mod run;
mod sensor_bias;
pub mod sensor_fault;
pub mod signal;
mod start_in_motion;
mod stepper;
mod stimulus;
mod straight_line;
mod taken_up;
mod whitening;

pub use arithmetic::Arithmetic;
pub use derivatives::{By, Derivatives, Derived, MOST_PARAMETERS, OF_START};
pub use error::SimulateError;
pub use grid::{between_rows, is_sparse};
pub use in_chunks::{Advance, InChunks};
pub use in_lanes::{Run, run_in_lanes};
pub use initial_state::StartOffset;
pub use machine_file::DELAY_LINE;
pub use recorded_start::Start;
pub use run::{SignalsOfRow, Trajectory, computed_below, rows_f64, simulate_f64, simulate_fixed};
pub use start_in_motion::SpoolAtStart;
pub use stepper::{Inputs, Kept, Live, OtherArithmetic};
pub use stimulus::coarse::Coarser;
pub use stimulus::held::Shown;
pub use stimulus::{
    InputPoint, RunningSum, Stimulus, first_input_point, is_carried, is_driven_by_pressures, natural_tick, tick_for,
};
pub use taken_up::TakenUp;
pub use whitening::Whitening;
