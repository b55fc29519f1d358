//! Which effects would be seen, and which would pass for which: by the decision rule of the diagnosis.

use nalgebra::{DMatrix, DVector};

use diagnosis::selection::decision_rule::{BEYOND_PENALTY, PLAN_RIVAL_LEAVES, PLAN_TELLS_BY};

use super::directions::{Directions, Way};

/// One effect, as it usually is, against every other.
#[derive(Clone, Debug, PartialEq)]
pub struct Isolability {
    /// How far each effect takes the sensors, in standard deviations of their noise (root of the sum of squares), once ordinary
    /// parameters have settled.
    pub seen: Vec<f64>,
    /// Whether that is enough to accept it.
    pub accepted: Vec<bool>,
    /// For each effect that is there, each other one: what the best of its forms leaves, in standard deviations.
    pub left: Vec<Vec<f64>>,
    /// Whether that tells the two apart. Every effect is told from itself.
    pub told: Vec<Vec<bool>>,
}

/// What is left of everything once the base parameters and the start have settled.
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

/// Half a sum of squares that an effect with so many effect parameters has to gain of so many samples: its penalty, and what comes by chance.
pub(crate) fn needed(effect_parameters: usize, samples: f64) -> f64 {
    0.5 * effect_parameters as f64 * samples.max(2.0).ln() + BEYOND_PENALTY
}

impl Isolability {
    /// By products over the sensors at hand and the number of their samples.
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
        let told = |truth: usize, rival: usize, left: f64| {
            // What takes the other in is only named where it earns what it has more.
            let takes_in =
                directions.effects[rival].extends.is_some_and(|of| of.plain == directions.effects[truth].name);
            let more = directions.fewest(rival) as f64 - directions.fewest(truth) as f64;
            let net = 0.5 * left + 0.5 * more * samples.max(2.0).ln();
            // One with more effect parameters that follows as well is the less likely for them; among equals, the form decides.
            truth == rival
                || takes_in
                || (net > PLAN_TELLS_BY && (more > 0.0 || left > PLAN_RIVAL_LEAVES * square(truth)))
        };
        let left: Vec<Vec<f64>> =
            (0..effects).map(|truth| (0..effects).map(|rival| left_by(truth, rival)).collect()).collect();
        Self {
            seen: (0..effects).map(|effect| square(effect).sqrt()).collect(),
            accepted: (0..effects).map(accepted).collect(),
            told: (0..effects)
                .map(|truth| (0..effects).map(|rival| told(truth, rival, left[truth][rival])).collect())
                .collect(),
            left: left.into_iter().map(|row| row.into_iter().map(f64::sqrt).collect()).collect(),
        }
    }

    /// Effects that would be accepted as they usually are.
    pub fn accepted(&self) -> impl Iterator<Item = usize> + '_ {
        self.accepted.iter().enumerate().filter(|(_, accepted)| **accepted).map(|(effect, _)| effect)
    }

    /// Pairs (what is there, what it would pass for) of those.
    pub fn confused(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.accepted().flat_map(|truth| self.rivals(truth).map(move |rival| (truth, rival)))
    }

    /// What an effect would pass for.
    pub fn rivals(&self, truth: usize) -> impl Iterator<Item = usize> + '_ {
        self.told[truth].iter().enumerate().filter(|(_, told)| !**told).map(|(rival, _)| rival)
    }

    /// How much is told: effects that are accepted and the pairs of them, and, where these are equal, by how far.
    pub(crate) fn worth(&self) -> (usize, f64) {
        self.accepted().fold((0, 0.0), |(count, far), truth| {
            let told = self.told[truth].iter().filter(|told| **told).count();
            let by: f64 = self.left[truth].iter().map(|left| left.ln_1p()).sum();
            (count + told, far + by)
        })
    }
}

/// What the best amounts of one way explain of an effect, as a sum of squares.
fn explained(settled: &DMatrix<f64>, way: &Way, first: usize, truth: usize) -> f64 {
    if way.jumps {
        return 2.0 * settled[(first, truth)] - settled[(first, first)];
    }
    // Few amounts: every choice of those that are there is tried, and the best admissible one counts.
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
