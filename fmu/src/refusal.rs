//! Why a call was refused; the message appears in the tool's log, after the name of the function.

use model_core::machine::MachineError;
use model_export::fmu::{ContentsError, Variable};
use simulation::OtherArithmetic;
use simulation::number::cpu::Unsuited;

use crate::Mode;

/// Why a call was refused.
#[derive(Debug, thiserror::Error)]
pub enum Refusal {
    /// The library was built for another processor.
    #[error(transparent)]
    Processor(#[from] Unsuited),
    /// The model description does not belong to this library.
    #[error("the model description has the token {found:?}; expected {expected:?}: export the FMU again")]
    Token {
        /// The token that the tool read in the description.
        found: String,
        /// The token of this library and machine file.
        expected: String,
    },
    /// A text that is not UTF-8, or a null pointer.
    #[error("{what} is not text; expected UTF-8 that ends with a zero byte")]
    NoText {
        /// The argument.
        what: &'static str,
    },
    /// An instance for something else than co-simulation.
    #[error("an instance of kind {found}; expected {expected}, for co-simulation")]
    Kind {
        /// The kind that the tool asks for.
        found: i32,
        /// The kind for co-simulation.
        expected: i32,
    },
    /// A place of the resources that is no folder of this computer.
    #[error("the resources at {found:?}; expected a URI that begins with file:/// and names a folder of this computer")]
    Location {
        /// The place that the tool gives.
        found: String,
    },
    /// A null pointer where a result is to be written, or a state is to be read.
    #[error("no place to write, or no state; expected a pointer that is not null")]
    NoPlace,
    /// The FMU's resources hold no drive.
    #[error(transparent)]
    Contents(#[from] ContentsError),
    /// The machine's values do not make a drive.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// No variable has this number.
    #[error("value reference {reference}: no such variable; expected one of the model description")]
    Unknown {
        /// The number.
        reference: u32,
    },
    /// The numbers of variables and of values differ.
    #[error("{references} value references and {values} values; expected as many of each")]
    Lengths {
        /// Number of variables.
        references: usize,
        /// Number of values.
        values: usize,
    },
    /// An output is set, although the drive computes it.
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
        /// The mode in which it was set.
        mode: Mode,
    },
    /// An input is set to a value that is not finite.
    #[error("{} = {value}: expected a finite number", .variable.name())]
    NotFinite {
        /// The variable.
        variable: Variable,
        /// The value.
        value: f64,
    },
    /// A start value beyond what the model description allows.
    #[error("{} = {value}: expected {min} to {max}", .variable.name())]
    OutOfRange {
        /// The variable.
        variable: Variable,
        /// The value.
        value: f64,
        /// The smallest that is allowed.
        min: f64,
        /// The largest.
        max: f64,
    },
    /// The call is not allowed in this mode.
    #[error("called in mode {mode:?}; expected it in mode {expected:?}")]
    Mode {
        /// The mode in which it was called.
        mode: Mode,
        /// The mode in which it is allowed.
        expected: Mode,
    },
    /// A communication step that is not a whole number of the model's ticks.
    #[error("a communication step of {step_s} s; expected a whole number of ticks of {tick_s} s, at least one")]
    Step {
        /// The step.
        step_s: f64,
        /// The model's tick.
        tick_s: f64,
    },
    /// A step that begins at another time than the last one ended.
    #[error("a step from {from_s} s; expected it from {reached_s} s, where the last one ended")]
    NotThere {
        /// The time at which the tool begins the step.
        from_s: f64,
        /// The time that the drive has reached.
        reached_s: f64,
    },
    /// A start time that is not finite.
    #[error("a start time of {start_s} s; expected a finite number")]
    StartTime {
        /// The time.
        start_s: f64,
    },
    /// Bytes that cannot be read as a state.
    #[error("the serialized state: {0}; expected one of this version of this FMU")]
    State(#[from] postcard::Error),
    /// A state of another FMU or version.
    #[error("the serialized state is of {found:?}; expected one of {expected:?}")]
    ForeignState {
        /// The token in the state.
        found: String,
        /// The token of this FMU.
        expected: String,
    },
    /// A state of another drive, or of the same with another tick or number type.
    #[error("the state is one of another drive; expected one of an instance of this FMU")]
    OtherDrive,
    /// A state of the other number type.
    #[error("the state is of another number type; expected one of an instance of this FMU")]
    OtherArithmetic(#[from] OtherArithmetic),
    /// Too few or too many bytes for a state.
    #[error("{found} bytes for a state; expected {expected}")]
    StateSize {
        /// The number of bytes that the tool provides.
        found: usize,
        /// The number of bytes that the state needs.
        expected: usize,
    },
    /// A function that this FMU does not support.
    #[error("not in this FMU; expected what its model description says it can do")]
    NotHere,
}
