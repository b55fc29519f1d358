//! TODO.

mod arithmetic;
mod derivatives;
pub mod figures_of_merit;
mod grid;
mod in_chunks;
mod in_lanes;
mod initial_state;
pub mod number;
mod outflow;
mod recorded_start;
mod run;
pub mod sensor_fault;
pub mod signal;
mod stepper;
mod stimulus;

pub use arithmetic::Arithmetic;
pub use derivatives::{By, Derivatives, Derived, MOST_PARAMETERS};
pub use in_chunks::{Advance, Onward};
pub use in_lanes::{Run, run_abreast};
pub use initial_state::StartOffset;
pub use recorded_start::Start;
pub use run::{DELAY_LINE, SignalsOfRow, Trajectory, computed_below, rows_f64, simulate_f64, simulate_fixed};
pub use stepper::{Inputs, Kept, Live, OtherArithmetic};
pub use stimulus::coarse::Coarser;
pub use stimulus::{EntryPoint, SimulateError, Stimulus, first_entry, natural_tick};
