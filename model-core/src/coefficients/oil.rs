//! Coefficients of the oil's viscosity.

use super::Builder;
use crate::coefficients::bases::{TEMPERATURE_C, thinnest};
use crate::machine::{MachineError, Parameter as P};
use crate::number::{Number, Real};
use crate::oil::{SQUARINGS, THINNEST, Thinning, Viscosity, Warming};

/// Least exponent per tick for which the exponential is computed, instead of the first terms of its series.
const SLOW: f64 = 1e-4;

impl<R: Real> Builder<'_, R> {
    pub(super) fn viscosity<N: Number<Real = R>>(&self) -> Result<Option<Viscosity<N>>, MachineError> {
        let (warming, thinning) = (self.warming()?, self.thinning()?);
        if warming.is_none() && thinning.is_none() {
            return Ok(None);
        }
        let thinnest = thinnest(self.machine);
        Ok(Some(Viscosity {
            warming,
            thinning,
            thinnest: self.signal("least viscosity", P::ViscosityLoss, thinnest)?,
            per_thinnest: self.steep::<N>("inverse of the least viscosity", P::ViscosityLoss, R::ONE / thinnest)?,
        }))
    }

    fn warming<N: Number<Real = R>>(&self) -> Result<Option<Warming<N>>, MachineError> {
        let loss = self.get(P::ViscosityLoss);
        if loss.is_nil() {
            return Ok(None);
        }
        let folds = R::constant(self.tick_s) / self.get(P::WarmingTime);
        let done = if folds.value() < SLOW {
            folds * (R::ONE - folds * (R::constant(0.5) - folds / R::constant(6.0)))
        } else {
            R::ONE - (-folds).exp()
        };
        // As many digits as the format of a gain holds.
        let mut share = 1.0;
        while share > 1.0 / 4096.0 && done.value() < share {
            share *= 0.5;
        }
        let thins = loss.value() > 0.0;
        Ok(Some(Warming {
            rate: self.gain::<N>("warming in a tick", P::WarmingTime, done / R::constant(share))?,
            share: N::saturated(share),
            change: self.signal("loss of viscosity", P::ViscosityLoss, if thins { loss } else { -loss })?,
            thins,
        }))
    }

    fn thinning<N: Number<Real = R>>(&self) -> Result<Option<Thinning<N>>, MachineError> {
        let loss = self.get(P::ViscosityLossPerKelvin);
        if loss.is_nil() {
            return Ok(None);
        }
        let unit = R::constant(TEMPERATURE_C);
        let root = R::constant(1.0 / f64::from(1 << SQUARINGS));
        Ok(Some(Thinning {
            reference: self.signal(
                "reference temperature",
                P::ReferenceTemperature,
                self.get(P::ReferenceTemperature) / unit,
            )?,
            rate: self.gain::<N>("loss of viscosity", P::ViscosityLossPerKelvin, loss * unit * root)?,
            most: N::saturated(-libm::log(THINNEST) / f64::from(1 << SQUARINGS)),
            third: self.gain::<N>("a third", P::ViscosityLossPerKelvin, R::constant(1.0 / 3.0))?,
        }))
    }
}
