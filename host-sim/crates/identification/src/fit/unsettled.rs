//! What was still moving where a search ended before it converged.

use model_core::machine::Parameter;

use super::Fit;
use super::normal_equations::NormalEquations;

/// The value that was still moving most, in standard deviations of its prior.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unsettled {
    /// Which.
    pub parameter: Parameter,
    /// Where the search stopped, SI.
    pub value: f64,
    /// Where a full step from there would lead, SI, by the derivatives at the end.
    pub towards: f64,
    /// Why it had not come to rest.
    pub why: Unrest,
}

/// Why a value had not come to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unrest {
    /// It is at the end of its range, and pulls beyond.
    AtBound,
    /// Only its combination with another is determined: the other one, and the coefficient of correlation.
    With(Parameter, f64),
    /// The residuals change otherwise than their derivatives say: something bends it that the model lacks.
    Bent,
}

impl Fit {
    /// The value that was still moving most; none where the search converged. `inflation` is how many times more rows there are than independent
    /// samples.
    #[must_use]
    pub fn unsettled(&self, inflation: f64) -> Option<Unsettled> {
        if self.converged || self.normal_equations.is_empty() {
            return None;
        }
        let (matrix, gradient, _) = NormalEquations::assembled(&self.normal_equations, &self.all_coordinates());
        let step = -matrix.cholesky()?.solve(&gradient);
        // At the end of a tolerance the coordinate runs on while the value rests.
        let moves = |slot: usize| {
            let (free, at) = (self.free[slot], self.coordinates[slot]);
            let by =
                (free.value(at + step[slot]) - free.value(at)).abs() / free.slope(0.0).abs().max(f64::MIN_POSITIVE);
            if free.at_bound(at) { step[slot].abs() } else { by }
        };
        let most = (0..self.free.len()).max_by(|&one, &other| moves(one).total_cmp(&moves(other)))?;
        let (free, at) = (self.free[most], self.coordinates[most]);
        let pair =
            self.correlations(inflation).into_iter().find(|pair| [pair.one, pair.other].contains(&free.parameter));
        let why = match pair {
            _ if free.at_bound(at) => Unrest::AtBound,
            Some(pair) if pair.one == free.parameter => Unrest::With(pair.other, pair.coefficient),
            Some(pair) => Unrest::With(pair.one, pair.coefficient),
            None => Unrest::Bent,
        };
        Some(Unsettled { parameter: free.parameter, value: free.value(at), towards: free.value(at + step[most]), why })
    }
}

#[cfg(test)]
mod tests {
    use model_core::machine::Parameter as P;

    use super::*;
    use crate::fit::{Freedom, test_fit};

    /// A fit that did not converge.
    fn ended(at: [f64; 3], slopes: [f64; 3]) -> Fit {
        test_fit::ended(at, slopes, false)
    }

    #[test]
    fn of_two_values_that_are_determined_only_together_the_one_that_moves_is_named_with_the_other() {
        let found = ended([0.0; 3], [50.0, -45.0, 0.0]).unsettled(1.0).unwrap();
        // The inverse of [[100, 99], [99, 100]] is [[100, -99], [-99, 100]]/199.
        assert!((found.towards - (0.05 - 9455.0 / 199.0 * 0.005)).abs() < 1e-9, "{found:?}");
        let Unrest::With(P::FlowCoefficient, coefficient) = found.why else { panic!("{found:?}") };
        assert!((coefficient + 0.99).abs() < 1e-12);
    }

    #[test]
    fn a_value_by_itself_is_bent_and_one_at_its_end_pulls_beyond() {
        let found = ended([0.0; 3], [0.0, 0.0, -200.0]).unsettled(1.0).unwrap();
        assert_eq!((found.parameter, found.value, found.why), (P::ViscousFriction, 1e4, Unrest::Bent));
        assert!((found.towards - 12e3).abs() < 1e-6, "{found:?}");
        let most = (P::ViscousFriction.description().max - 1e4) / 1e3 + 1.0;
        assert_eq!(ended([0.0, 0.0, most], [0.0, 0.0, -1e3 * most]).unsettled(1.0).unwrap().why, Unrest::AtBound);
    }

    #[test]
    fn a_tolerance_that_is_used_up_rests_however_far_its_coordinate_runs() {
        let mut fit = ended([0.0, 0.0, 8.0], [1.0, -0.9, -3000.0]);
        fit.free[2].freedom = Freedom::Within { most: 1e4, is_signed: false };
        assert_eq!(fit.unsettled(1.0).unwrap().parameter, P::ValveGain);
    }

    #[test]
    fn of_a_fit_that_converged_nothing_moves() {
        assert_eq!(Fit { converged: true, ..ended([0.0; 3], [50.0, -50.0, 0.0]) }.unsettled(1.0), None);
    }
}
