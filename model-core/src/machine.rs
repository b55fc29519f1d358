//! A drive's SI parameters.

use crate::parameter::{Fallback, Parameter};

/// Where the oil comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// A proportional valve on a constant supply: the paper's drive.
    Valve,
    /// A pump whose flow a directional valve leads into A or B; the other port returns to tank.
    Pump,
}

/// SI parameters of one drive, over a real number type (`f64`, or a dual number for derivatives).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine<R> {
    /// Where the oil comes from.
    pub source: Source,
    values: [R; Parameter::COUNT],
}

impl Machine<f64> {
    /// A machine with every default; required parameters are NaN until they are set.
    #[must_use]
    pub fn with_defaults(source: Source) -> Self {
        let mut machine = Self { source, values: [f64::NAN; Parameter::COUNT] };
        for &parameter in Parameter::ALL {
            if let Fallback::Value(value) = parameter.description().default {
                machine.set(parameter, value);
            }
        }
        machine
    }
}

impl<R: Copy> Machine<R> {
    /// The value of a parameter, in its SI unit.
    #[must_use]
    #[expect(clippy::indexing_slicing, reason = "values has one entry for each variant")]
    pub fn get(&self, parameter: Parameter) -> R {
        self.values[parameter as usize]
    }

    /// Sets a parameter, in its SI unit.
    #[expect(clippy::indexing_slicing, reason = "values has one entry for each variant")]
    pub fn set(&mut self, parameter: Parameter, value: R) {
        self.values[parameter as usize] = value;
    }

    /// The same machine over another number type.
    #[must_use]
    pub fn map<S>(&self, convert: impl Fn(R) -> S) -> Machine<S> {
        Machine { source: self.source, values: self.values.map(convert) }
    }
}
