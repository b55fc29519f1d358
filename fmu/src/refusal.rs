//! Why a call could not be done; the tool's log shows it.

use model_core::machine::MachineError;
use model_export::fmu::{ContentsError, Variable};
use simulation::OtherArithmetic;
use simulation::number::cpu::Unsuited;

use crate::Mode;

/// Why a call could not be done.
#[derive(Debug, thiserror::Error)]
pub enum Refusal {
    /// The library was built for another processor.
    #[error(transparent)]
    Processor(#[from] Unsuited),
    /// The description is not this library's.
    #[error("the model description has the token {found:?}; expected {expected:?}: export the FMU again")]
    Token {
        /// What the tool read there.
        found: String,
        /// What this library and the machine file would have.
        expected: String,
    },
    /// A text that is not UTF-8, or not there.
    #[error("{what} is not text; expected UTF-8 that ends with a zero byte")]
    NoText {
        /// Which argument.
        what: &'static str,
    },
    /// A place to write that is not there.
    #[error("{call}: no place to write; expected a pointer that is not null")]
    NoPlace {
        /// The function.
        call: &'static str,
    },
    /// The FMU's resources hold no drive.
    #[error(transparent)]
    Contents(#[from] ContentsError),
    /// The machine does not become a drive.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// No variable has this number.
    #[error("value reference {reference}: no such variable; expected one of the model description")]
    Unknown {
        /// The number.
        reference: u32,
    },
    /// As many numbers as variables are needed.
    #[error("{references} value references and {values} values; expected as many of each")]
    Lengths {
        /// Variables.
        references: usize,
        /// Values.
        values: usize,
    },
    /// What the drive computes cannot be set.
    #[error("{}: the drive computes it; expected an input or a parameter", .variable.name())]
    Computed {
        /// The variable.
        variable: Variable,
    },
    /// A parameter is set while the simulation runs.
    #[error("{}: set in mode {mode:?}; expected it before the simulation begins", .variable.name())]
    TooLate {
        /// The variable.
        variable: Variable,
        /// When it was set.
        mode: Mode,
    },
    /// An input that is no number.
    #[error("{} = {value}: expected a finite number", .variable.name())]
    NotFinite {
        /// The variable.
        variable: Variable,
        /// What it was set to.
        value: f64,
    },
    /// The call does not belong here.
    #[error("{call} in mode {mode:?}; expected it in mode {expected:?}")]
    Mode {
        /// The function.
        call: &'static str,
        /// When it was called.
        mode: Mode,
        /// When it may be.
        expected: Mode,
    },
    /// A step that the model's ticks do not fill.
    #[error("a communication step of {step_s} s; expected a whole number of ticks of {tick_s} s, at least one")]
    Step {
        /// The step.
        step_s: f64,
        /// The model's tick.
        tick_s: f64,
    },
    /// A step from another time than that which was reached.
    #[error("a step from {from_s} s; expected it from {reached_s} s, where the last one ended")]
    NotThere {
        /// Where the tool is.
        from_s: f64,
        /// Where the drive is.
        reached_s: f64,
    },
    /// A time that is no number.
    #[error("a start time of {start_s} s; expected a finite number")]
    StartTime {
        /// The time.
        start_s: f64,
    },
    /// Bytes that are no state.
    #[error("the serialized state: {0}; expected one of this version of this FMU")]
    State(#[from] postcard::Error),
    /// A state of something else.
    #[error("the serialized state is of {found:?}; expected one of {expected:?}")]
    ForeignState {
        /// What it was written by.
        found: String,
        /// What could be read.
        expected: String,
    },
    /// A state of the other number type.
    #[error("the state is of another number type; expected one of an instance of this FMU")]
    OtherArithmetic(#[from] OtherArithmetic),
    /// Too few or too many bytes for a state.
    #[error("{found} bytes for a state; expected {expected}")]
    StateSize {
        /// What the tool holds ready.
        found: usize,
        /// What the state takes.
        expected: usize,
    },
    /// Nothing that this FMU has.
    #[error("{call}: not in this FMU; expected what its model description says it can do")]
    NotHere {
        /// The function.
        call: &'static str,
    },
}
