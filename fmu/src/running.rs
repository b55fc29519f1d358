//! The drive in the number type that the FMU was exported with.

use model_core::machine::MachineError;
use model_core::number::PerUnit;
use model_export::fmu::Contents;
use recording::Signal;
use simulation::{Arithmetic, Inputs, Live, Start};

use crate::Refusal;
use crate::snapshot::Kept;

/// A drive that runs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Running {
    Fixed(Box<Live<PerUnit>>),
    Float(Box<Live<f64>>),
}

impl Running {
    /// The drive at rest, the command held for long.
    pub(crate) fn new(contents: &Contents, inputs: &Inputs, position_m: f64) -> Result<Self, MachineError> {
        let start = Start { command_v: inputs.command_v, pressures_pa: None, position_m };
        let tick = contents.settings.tick;
        Ok(match contents.settings.arithmetic {
            Arithmetic::Fixed => Running::Fixed(Box::new(Live::new(&contents.machine, tick, &start)?)),
            Arithmetic::Float => Running::Float(Box::new(Live::new(&contents.machine, tick, &start)?)),
        })
    }

    pub(crate) fn step(&mut self, inputs: &Inputs) {
        match self {
            Running::Fixed(live) => live.step(inputs),
            Running::Float(live) => live.step(inputs),
        }
    }

    pub(crate) fn signal(&self, signal: Signal, inputs: &Inputs) -> Option<f64> {
        match self {
            Running::Fixed(live) => live.signal(signal, inputs),
            Running::Float(live) => live.signal(signal, inputs),
        }
    }

    pub(crate) fn kept(&self) -> Kept {
        match self {
            Running::Fixed(live) => Kept::Fixed(Box::new(*live.state())),
            Running::Float(live) => Kept::Float(Box::new(*live.state())),
        }
    }

    pub(crate) fn restore(&mut self, kept: &Kept) -> Result<(), Refusal> {
        match (self, kept) {
            (Running::Fixed(live), Kept::Fixed(state)) => live.restore(state),
            (Running::Float(live), Kept::Float(state)) => live.restore(state),
            _ => return Err(Refusal::OtherArithmetic),
        }
        Ok(())
    }
}
