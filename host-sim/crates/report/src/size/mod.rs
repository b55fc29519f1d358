//! Sizes of effects in the units of the hall, beside their SI values: l/min at the supply pressure, per cent of full force, mm, ms.
//!
//! What is large depends on the drive: full force is area A times the supply pressure, full flow that of the open valve at the supply pressure, or of
//! the pump at 1500 rpm. Only what a source puts a bound to has a grade as well ([`Grade`]).

mod grade;
mod phrase;

use std::fmt;

use diagnosis::catalogue::{full_flow_m3_per_s, full_force_n};
use model_core::machine::{Machine, Parameter, Source};
use recording::display_unit::significant;

pub use grade::Grade;

/// Speed of a pump at which its delivery is counted, rev/s: that of a motor with four poles.
const PUMP_REV_PER_S: f64 = 25.0;

/// The size of an effect parameter's value.
#[derive(Clone, Debug, PartialEq)]
pub struct Size {
    /// How much, without sign: `870 N`.
    pub amount: String,
    /// Of what, where and in which direction: `, 4.0 % of full force`; it follows the amount as it is.
    pub of: String,
    /// What a drive of this size usually has, where a source says.
    pub grade: Option<Grade>,
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.amount, self.of)?;
        self.grade.map_or(Ok(()), |grade| write!(f, ": {grade}"))
    }
}

impl Size {
    /// What is said of it within a tolerance: not graded as a finding is.
    #[must_use]
    pub fn within_tolerance(&self) -> String {
        match self.grade {
            None | Some(Grade::Usual) => self.to_string(),
            Some(_) => format!("{}{}: more than usual, within the tolerance", self.amount, self.of),
        }
    }
}

/// The size of a value of an effect parameter in this drive; `None` for a base parameter and for the correction table.
#[must_use]
pub fn size(machine: &Machine<f64>, parameter: Parameter, value: f64) -> Option<Size> {
    parameter.effect()?;
    let (amount, of) = phrase::phrase(&Drive { machine }, parameter, value)?;
    Some(Size { amount, of, grade: Grade::of(&Drive { machine }, parameter, value) })
}

/// The magnitude from which on a cylinder is worn or jammed, by the sources of [`Grade`]; `None` where no source has a bound.
#[must_use]
pub fn worn(machine: &Machine<f64>, parameter: Parameter) -> Option<f64> {
    grade::worn(&Drive { machine }, parameter)
}

/// What sizes are counted in.
struct Drive<'a> {
    machine: &'a Machine<f64>,
}

impl Drive<'_> {
    fn get(&self, parameter: Parameter) -> f64 {
        self.machine.get(parameter)
    }

    fn supply_pa(&self) -> f64 {
        self.get(Parameter::SupplyPressure)
    }

    fn full_flow_m3_per_s(&self) -> f64 {
        match self.machine.source {
            Source::Valve => full_flow_m3_per_s(self.machine),
            Source::Pump => PUMP_REV_PER_S * self.get(Parameter::PumpDisplacement),
            // Nothing flows.
            Source::Force => f64::INFINITY,
        }
    }

    /// A force as a share of the oil's full force; `None` where no oil moves the mass.
    fn of_full_force(&self, force_n: f64) -> Option<f64> {
        (self.machine.source != Source::Force).then(|| force_n.abs() / full_force_n(self.machine))
    }

    /// A flow as a share of full flow.
    fn of_full_flow(&self, flow_m3_per_s: f64) -> f64 {
        flow_m3_per_s.abs() / self.full_flow_m3_per_s()
    }
}

/// A share as a percentage without sign.
fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share.abs(), 2))
}

#[cfg(test)]
mod tests;
