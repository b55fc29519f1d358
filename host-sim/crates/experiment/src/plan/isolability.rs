//! Which effects would be seen, and which would be confused with which: by the decision rule of the diagnosis.

use nalgebra::{DMatrix, DVector};

use diagnosis::selection::decision_rule::{BEYOND_PENALTY, PLAN_RIVAL_LEAVES, PLAN_TELLS_BY};

use super::directions::{Directions, Way};

/// Each effect at its usual size, compared with every other.
#[derive(Clone, Debug, PartialEq)]
pub struct Isolability {
    /// Change that each effect causes in the sensors, in standard deviations of their noise (root of the sum of squares),
    /// after a refit of the base parameters.
    pub seen: Vec<f64>,
    /// Whether that is enough to accept it.
    pub accepted: Vec<bool>,
    /// For each effect that is present and each other effect: the difference that the other's best form leaves, in standard deviations.
    pub left: Vec<Vec<f64>>,
    /// Whether this difference distinguishes the two. Every effect counts as distinguished from itself.
    pub separated: Vec<Vec<bool>>,
}

/// Products of everything that remains after a refit of the base parameters and the initial state.
pub(crate) fn settled(products: &DMatrix<f64>, base_parameters: usize) -> DMatrix<f64> {
    let count = products.nrows() - base_parameters;
    let own =
        products.view((0, 0), (base_parameters, base_parameters)) + DMatrix::identity(base_parameters, base_parameters);
    let across = products.view((0, base_parameters), (base_parameters, count)).into_owned();
    let rest = products.view((base_parameters, base_parameters), (count, count)).into_owned();
    match own.cholesky() {
        Some(factor) => rest - across.tr_mul(&factor.solve(&across)),
        None => rest,
    }
}

/// Half the sum of squares that an effect with this many effect parameters has to gain with this many samples: its penalty, and what chance gives.
pub(crate) fn needed(effect_parameters: usize, samples: f64) -> f64 {
    0.5 * effect_parameters as f64 * libm::log(samples.max(2.0)) + BEYOND_PENALTY
}

impl Isolability {
    /// From products over the sensors at hand and the number of their samples.
    pub(crate) fn of(directions: &Directions, products: &DMatrix<f64>, samples: f64) -> Self {
        let settled = settled(products, directions.base_parameters);
        let at = |index: usize| index - directions.base_parameters;
        let effects = directions.effect_parameters.len();
        let usual = |effect: usize| at(directions.usual) + effect;
        let square = |effect: usize| settled[(usual(effect), usual(effect))].max(0.0);
        let left_by = |truth: usize, rival: usize| {
            let ways = directions.ways.iter().filter(|way| way.effect == rival);
            let left = ways.map(|way| (square(truth) - explained(&settled, way, at(way.first), usual(truth))).max(0.0));
            left.fold(square(truth), f64::min)
        };
        let accepted = |effect: usize| 0.5 * square(effect) > needed(directions.fewest(effect), samples);
        let separated = |truth: usize, rival: usize, left: f64| {
            // An extension of an effect is only named if it gains enough for its additional parameters.
            let takes_in =
                directions.effects[rival].extends.is_some_and(|of| of.plain == directions.effects[truth].name);
            let more = directions.fewest(rival) as f64 - directions.fewest(truth) as f64;
            let net = 0.5 * left + 0.5 * more * libm::log(samples.max(2.0));
            // Among rivals that follow equally well, one with more effect parameters is less likely; with equal numbers, the form decides.
            truth == rival
                || takes_in
                || (net > PLAN_TELLS_BY && (more > 0.0 || left > PLAN_RIVAL_LEAVES * square(truth)))
        };
        let left: Vec<Vec<f64>> =
            (0..effects).map(|truth| (0..effects).map(|rival| left_by(truth, rival)).collect()).collect();
        Self {
            seen: (0..effects).map(|effect| square(effect).sqrt()).collect(),
            accepted: (0..effects).map(accepted).collect(),
            separated: (0..effects)
                .map(|truth| (0..effects).map(|rival| separated(truth, rival, left[truth][rival])).collect())
                .collect(),
            left: left.into_iter().map(|row| row.into_iter().map(f64::sqrt).collect()).collect(),
        }
    }

    /// Effects that would be accepted at their usual size.
    pub fn accepted(&self) -> impl Iterator<Item = usize> + '_ {
        self.accepted.iter().enumerate().filter(|(_, accepted)| **accepted).map(|(effect, _)| effect)
    }

    /// Pairs (effect that is present, effect that it is confused with) of the accepted effects.
    pub fn confused(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.accepted().flat_map(|truth| self.rivals(truth).map(move |rival| (truth, rival)))
    }

    /// Effects that an effect would be confused with.
    pub fn rivals(&self, truth: usize) -> impl Iterator<Item = usize> + '_ {
        self.separated[truth].iter().enumerate().filter(|(_, separated)| !**separated).map(|(rival, _)| rival)
    }

    /// Value of an excitation: the number of accepted effects and distinguished pairs of them, and, where these are equal, by how much.
    pub(crate) fn worth(&self) -> (usize, f64) {
        self.accepted().fold((0, 0.0), |(count, far), truth| {
            let separated = self.separated[truth].iter().filter(|separated| **separated).count();
            let by: f64 = self.left[truth].iter().map(|left| libm::log1p(*left)).sum();
            (count + separated, far + by)
        })
    }
}

/// Part of an effect that the best amounts of one way explain, as a sum of squares.
fn explained(settled: &DMatrix<f64>, way: &Way, first: usize, truth: usize) -> f64 {
    if way.jumps {
        return 2.0 * settled[(first, truth)] - settled[(first, first)];
    }
    // There are few amounts: every selection of them is tried, and the best admissible one counts.
    let mut best = 0.0_f64;
    for chosen in 1_u32..(1 << way.count) {
        let there: Vec<usize> = (0..way.count).filter(|amount| chosen & (1 << amount) != 0).collect();
        let right = DVector::from_iterator(there.len(), there.iter().map(|amount| settled[(first + amount, truth)]));
        let matrix = DMatrix::from_fn(there.len(), there.len(), |row, column| {
            let product = settled[(first + there[row], first + there[column])];
            // A direction that the base parameters can imitate explains nothing.
            if row == column { product * (1.0 + 1e-9) + 1e-6 } else { product }
        });
        let Some(amounts) = matrix.cholesky().map(|factor| factor.solve(&right)) else { continue };
        let admissible =
            there.iter().zip(amounts.iter()).all(|(index, amount)| !way.positive[*index] || *amount >= 0.0);
        if admissible {
            best = best.max(right.dot(&amounts));
        }
    }
    best
}
