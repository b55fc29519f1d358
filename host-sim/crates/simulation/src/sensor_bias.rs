//! From a sensor's reading to the true value behind it.

use model_core::machine::{Machine, Parameter};
use model_core::number::{Real, Scalar};

/// Gain error and offset of a sensor.
type SensorError = (Parameter, Parameter);
pub(crate) const PRESSURE_A: SensorError = (Parameter::PressureAFactor, Parameter::PressureAOffset);
pub(crate) const PRESSURE_B: SensorError = (Parameter::PressureBFactor, Parameter::PressureBOffset);
pub(crate) const SPOOL: SensorError = (Parameter::SpoolFactor, Parameter::SpoolOffset);

/// The true value behind a sensor's reading: (reading − offset)/(1 + factor).
pub(crate) fn behind<R: Real>(machine: &Machine<R>, (factor, offset): SensorError, reading: R) -> R {
    (reading - machine.get(offset)) / (R::ONE + machine.get(factor))
}

/// The spool behind a reading.
pub(crate) fn true_spool<N: Scalar>(machine: &Machine<N::Real>, reading: N) -> N {
    let (factor, offset) = SPOOL;
    if machine.get(factor).is_nil() && machine.get(offset).is_nil() {
        return reading;
    }
    within(behind(machine, SPOOL, reading.to_real()))
}

/// A signal; a value beyond its range becomes the end of the range.
pub(crate) fn within<N: Scalar>(value: N::Real) -> N {
    N::signal(value).unwrap_or_else(|| N::saturated(value.value()))
}
