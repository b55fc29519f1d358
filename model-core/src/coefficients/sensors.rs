//! Coefficients of the sensors.

use super::Builder;
use crate::machine::{MachineError, Parameter as P};
use crate::number::{Number, Real};
use crate::sensing::sensors::{Delay, Lag, Reading, Sensors};

impl<R: Real> Builder<'_, R> {
    pub(super) fn sensors<N: Number<Real = R>>(&self, line: usize) -> Result<Sensors<N>, MachineError> {
        let pressure = R::constant(self.bases.pressure_pa);
        Ok(Sensors {
            half_play: if self.get(P::BacklashPlay).is_nil() {
                None
            } else {
                let half = R::constant(0.5) * self.get(P::BacklashPlay) / self.get(P::Stroke);
                Some(self.signal("play over the stroke", P::BacklashPlay, half)?)
            },
            lag: self.lag()?,
            delay: if self.get(P::PositionDelay).is_nil() {
                None
            } else {
                let (ticks, rest) = self.delay(P::PositionDelay, line)?;
                Some(Delay { ticks, rest: self.signal("rest of the delay", P::PositionDelay, rest)? })
            },
            position: if self.get(P::PositionFactor).is_nil() {
                None
            } else {
                let factor = R::ONE + self.get(P::PositionFactor);
                Some(self.gain::<N>("reading of the position", P::PositionFactor, factor)?)
            },
            pressure_a: self.reading(P::PressureAFactor, P::PressureAOffset, pressure)?,
            pressure_b: self.reading(P::PressureBFactor, P::PressureBOffset, pressure)?,
            spool: self.reading(P::SpoolFactor, P::SpoolOffset, R::ONE)?,
            unity: self.gain::<N>("one", P::Stroke, R::ONE)?,
        })
    }

    fn lag<N: Number<Real = R>>(&self) -> Result<Option<Lag<N>>, MachineError> {
        let lag = self.get(P::PositionLag);
        if lag.is_nil() {
            return Ok(None);
        }
        let decay = self.decay(lag);
        let behind = lag / R::constant(self.tick_s) * (R::ONE - decay);
        Ok(Some(Lag {
            decay: self.gain::<N>("decay of the position's lag", P::PositionLag, decay)?,
            behind: self.gain::<N>("travel of a tick behind the position's lag", P::PositionLag, behind)?,
        }))
    }

    fn reading<N: Number<Real = R>>(&self, factor: P, offset: P, base: R) -> Result<Option<Reading<N>>, MachineError> {
        if self.get(factor).is_nil() && self.get(offset).is_nil() {
            return Ok(None);
        }
        Ok(Some(Reading {
            factor: self.gain::<N>("reading of a sensor", factor, R::ONE + self.get(factor))?,
            offset: self.signal("offset of a sensor", offset, self.get(offset) / base)?,
        }))
    }
}
