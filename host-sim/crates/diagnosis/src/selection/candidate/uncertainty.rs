//! How well the values of a candidate model are known: standard deviations from the curvature of the loss or, where it has no usable derivative, from
//! its profile.

use identification::fit::{Correlation, Estimate, FitError, Sensitivity, Uncertainty, Unsettled, inflation, loss};
use model_core::machine::Parameter;

use super::refit::NARROWEST;
use super::{Candidate, Question, effect_parameters};
use crate::selection::screen::with;

/// Steps to either side of an effect parameter without a usable derivative, each twice the last: from the smallest step of its search to 1.28 times
/// its value.
const STEPS: i32 = 8;

impl Candidate {
    /// Fitted values of all free parameters, and of the effect parameters that were found without a derivative.
    pub fn estimates(&self, question: &Question<'_>) -> Result<Vec<Estimate>, FitError> {
        let mut estimates = self.fit.estimates(self.inflation());
        if self.jumps.is_empty() {
            return Ok(estimates);
        }
        let sensitivity = Sensitivity::at(&self.fit, question.training)?;
        for &(parameter, value) in &self.jumps {
            let std = match &sensitivity {
                Some(sensitivity) => self.by_profile(question, sensitivity, parameter, value)?,
                None => None,
            };
            let std = std.unwrap_or(f64::NAN);
            estimates.push(Estimate { parameter, before: 0.0, value, std, at_bound: false });
        }
        Ok(estimates)
    }

    /// Pairs of free values whose estimates are correlated; effect parameters without a usable derivative are not covered.
    #[must_use]
    pub fn correlations(&self) -> Vec<Correlation> {
        self.fit.correlations(self.inflation())
    }

    /// The value that was still moving where its refit ended, if that did not converge.
    #[must_use]
    pub fn unsettled(&self) -> Option<Unsettled> {
        self.fit.unsettled(self.inflation())
    }

    /// The joint uncertainty of its fitted values.
    #[must_use]
    pub fn uncertainty(&self) -> Uncertainty {
        self.fit.uncertainty(self.inflation())
    }

    fn inflation(&self) -> f64 {
        if self.is_inflated { 1.0 } else { inflation(&self.residuals, self.counts) }
    }

    /// Standard deviation of an effect parameter without a usable derivative: half the interval outside of which the log-likelihood, with all free
    /// values refitted, is lower by more than ½, combined with the uncertainty from the step of its search. Only independent rows count, each with
    /// the remaining misfit as its noise. `None` where the likelihood does not fall so far on either side.
    fn by_profile(
        &self,
        question: &Question<'_>,
        sensitivity: &Sensitivity<'_>,
        parameter: Parameter,
        value: f64,
    ) -> Result<Option<f64>, FitError> {
        let gain = |value: f64| -> Result<f64, FitError> {
            let there = sensitivity.simulated(&with(&self.fit.machine, &[(parameter, value)]))?;
            Ok(sensitivity.settle(&sensitivity.change(&there)).gain)
        };
        let (square, rows) = self
            .residuals
            .iter()
            .flatten()
            .fold((0.0, 0.0), |sum, series| (sum.0 + loss(series), sum.1 + series.len() as f64));
        let unit = (square / f64::max(rows, 1.0)).max(1.0) * inflation(&self.residuals, self.counts);
        let description = parameter.description();
        let usual = effect_parameters(&self.effects)
            .into_iter()
            .find(|effect_parameter| effect_parameter.parameter == parameter);
        // A value near 0 is moved by steps relative to the low end of its usual range.
        let step =
            NARROWEST * value.max(usual.map_or(0.0, |effect_parameter| effect_parameter.range(question.scene).0));
        let here = gain(value)?;
        let mut sides = Vec::new();
        for sign in [-1.0, 1.0] {
            let mut profile = vec![(0.0, 0.0)];
            for index in 0..STEPS {
                let there = value + sign * step * 2.0_f64.powi(index);
                // A value that gives no valid drive, such as a floor below vacuum, is left out.
                if (description.min..=description.max).contains(&there)
                    && let Ok(found) = gain(there)
                {
                    profile.push(((there - value).abs(), (here - found) / unit));
                }
            }
            sides.extend(end_of_likely(&profile));
        }
        // Between two steps of its search the value may be anywhere.
        let unsearched = step / 12.0_f64.sqrt();
        Ok((!sides.is_empty()).then(|| libm::hypot(unsearched, sides.iter().sum::<f64>() / sides.len() as f64)))
    }
}

/// The distance beyond which the log-likelihood stays lower by more than ½, interpolated linearly between the points of a profile (distance, loss of
/// log-likelihood).
fn end_of_likely(profile: &[(f64, f64)]) -> Option<f64> {
    let last = profile.iter().rposition(|(_, lost)| *lost <= 0.5)?;
    let (&(from, less), &(to, more)) = (profile.get(last)?, profile.get(last + 1)?);
    Some(from + (to - from) * (0.5 - less) / (more - less))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_profile_ends_where_the_likelihood_has_fallen_by_a_half_for_good() {
        let parabola: Vec<(f64, f64)> = (0..6).map(f64::from).map(|at| (at, 0.5 * (at / 2.5).powi(2))).collect();
        let end = end_of_likely(&parabola).unwrap();
        assert!((end - 2.5).abs() < 0.05, "{end}");
        // Beyond a region of low likelihood the value is likely again.
        assert_eq!(end_of_likely(&[(0.0, 0.0), (1.0, 3.0), (2.0, 0.25), (4.0, 0.75)]), Some(3.0));
        assert_eq!(end_of_likely(&[(0.0, 0.0), (1.0, 0.2), (2.0, 0.3)]), None);
    }
}
