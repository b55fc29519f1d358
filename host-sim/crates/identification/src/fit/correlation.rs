//! Parameters that the recordings determine only together: pairs whose estimates are correlated.

use model_core::machine::Parameter;

use super::Fit;
use super::normal_equations::NormalEquations;

/// Estimates that are correlated more strongly than this are reported. The uncertainty of each is then 1/√(1 − 0.9²) =
/// 2.3 times what it would be if the other were known.
pub const CORRELATED: f64 = 0.9;

/// Two fitted parameters of which the recordings and the priors determine one combination less well than the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correlation {
    /// The first, in the order in which they were fitted.
    pub one: Parameter,
    /// The second.
    pub other: Parameter,
    /// Correlation coefficient, −1 to 1; below 0, more of the first means less of the second.
    pub coefficient: f64,
}

impl Fit {
    /// Pairs of fitted parameters that are correlated beyond [`CORRELATED`], the closest first. A value at the end of its range is not
    /// fitted. `inflation` is how many times more rows there are than independent samples.
    #[must_use]
    pub fn correlations(&self, inflation: f64) -> Vec<Correlation> {
        let Some(covariance) = NormalEquations::covariance(&self.normal_equations, inflation) else {
            return Vec::new();
        };
        let fitted = |slot: &usize| !self.free[*slot].at_bound(self.coordinates[*slot]);
        let slots: Vec<usize> = (0..self.free.len()).filter(fitted).collect();
        let pairs =
            slots.iter().enumerate().flat_map(|(at, &one)| slots[at + 1..].iter().map(move |&other| (one, other)));
        // A value grows with its coordinate, so both correlations have the same sign.
        let of = |(one, other): (usize, usize)| Correlation {
            one: self.free[one].parameter,
            other: self.free[other].parameter,
            coefficient: covariance[(one, other)] / (covariance[(one, one)] * covariance[(other, other)]).sqrt(),
        };
        let mut found: Vec<Correlation> = pairs.map(of).filter(|pair| pair.coefficient.abs() > CORRELATED).collect();
        found.sort_by(|a, b| b.coefficient.abs().total_cmp(&a.coefficient.abs()));
        found
    }
}

#[cfg(test)]
mod tests {
    use model_core::machine::Parameter as P;

    use super::*;
    use crate::fit::test_fit;

    fn fit(gain_at: f64) -> Fit {
        test_fit::ended([gain_at, 0.0, 0.0], [0.0; 3], true)
    }

    #[test]
    fn two_values_of_which_only_the_sum_is_determined_are_correlated_and_one_determined_alone_is_not() {
        let found = fit(0.0).correlations(1.0);
        // The inverse of [[100, 99], [99, 100]] has the correlation −99/100.
        let [pair] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!((pair.one, pair.other), (P::ValveGain, P::FlowCoefficient));
        assert!((pair.coefficient + 0.99).abs() < 1e-12, "{pair:?}");
        // If the rows repeat the same information a hundred times, the priors dominate, and they have no correlation.
        assert!(fit(0.0).correlations(100.0).is_empty());
    }

    #[test]
    fn a_value_at_the_end_of_its_range_is_correlated_with_none() {
        let beyond = (P::ValveGain.description().max - 0.05) / 0.005 + 1.0;
        assert!(fit(beyond).correlations(1.0).is_empty());
    }
}
