//! Which link the balances point to: their residuals are compared with the simple shapes that a lack in each link would give them.
//!
//! A lack is a flow that the ports pass beyond the model's, oil that a chamber takes up, a force on the rod, a travel of the spool
//! that was not measured, or an error of the position. Physics determines how each enters the balances: an error of the position
//! enters all of them, a force only the momentum. Where no pressures are recorded, flows and forces move the rod as they do while
//! the pressures are constant: δv·(D + A²/Ga + aA²/Gb) = δF + A·δQa/Ga + aA·δQb/Gb, with Ga, Gb the change of flow of
//! the open ports per pressure. What wrong base parameters would explain is removed first.

use nalgebra::{DMatrix, DVector};

use simulation::signal::slope::slopes;
use simulation::signal::window::Window;

use super::balances::{Balance, Coefficients, Observed, Residual};
use crate::catalogue::Subsystem;

/// Something that the drive does and the model lacks, as one value per row.
#[derive(Clone, Debug)]
pub(super) enum Lack {
    /// Flow into A and out of B beyond the model's, m³/s.
    Flow(Vec<f64>, Vec<f64>),
    /// Oil that the chambers hold beyond the model's, m³.
    Stored(Vec<f64>, Vec<f64>),
    /// Force on the rod, positive extends, N.
    Force(Vec<f64>),
    /// Measured less true position, m.
    Position(Vec<f64>),
}

/// One recording's balances, with all that is needed to compute how a lack would change them.
#[derive(Clone, Debug)]
pub(super) struct Account {
    /// The states.
    pub observed: Observed,
    /// Windows.
    pub windows: Vec<Window>,
    /// Residuals of the balances, the same number for every window.
    pub residuals: Vec<Residual>,
}

impl Account {
    /// Number of balances per window.
    #[must_use]
    pub(super) fn per_window(&self) -> usize {
        self.residuals.len() / self.windows.len().max(1)
    }

    /// The residual that a lack would cause in each balance, in standard deviations.
    #[must_use]
    pub(super) fn left_by(&self, lack: &Lack, by: &Coefficients) -> Vec<f64> {
        let (area_a, area_b) = by.area;
        let motion = if self.observed.has_pressures { Vec::new() } else { self.motion(lack, by) };
        self.residuals
            .iter()
            .enumerate()
            .map(|(index, residual)| {
                let window = &self.windows[index / self.per_window()];
                let value = match (residual.balance, lack) {
                    (Balance::ChamberA, Lack::Flow(a, _)) => window.sum(a),
                    (Balance::ChamberB, Lack::Flow(_, b)) => -window.sum(b),
                    (Balance::ChamberA, Lack::Stored(a, _)) => -window.change(a),
                    (Balance::ChamberB, Lack::Stored(_, b)) => -window.change(b),
                    (Balance::ChamberA, Lack::Position(error)) => area_a * window.change(error),
                    (Balance::ChamberB, Lack::Position(error)) => -area_b * window.change(error),
                    (Balance::Force, Lack::Force(force)) => window.sum(force),
                    (Balance::Force, Lack::Position(error)) => {
                        by.mass * window.curvature(error) + by.damping * window.change(error)
                    }
                    (Balance::Motion, Lack::Position(error)) => window.change(error),
                    (Balance::Motion, _) => window.sum(&motion),
                    _ => 0.0,
                };
                value / residual.sigma
            })
            .collect()
    }

    /// Velocity that a lack adds, at every row.
    fn motion(&self, lack: &Lack, by: &Coefficients) -> Vec<f64> {
        let observed = &self.observed;
        let (area_a, area_b) = by.area;
        // The flow of a closed port does not change with pressure; this small share of an open port's value keeps the quotients finite.
        let most = observed.flows.iter().map(|flow| flow.yield_per_pa.0 + flow.yield_per_pa.1).fold(0.0, f64::max);
        let least = 1e-4 * most.max(f64::MIN_POSITIVE);
        let (filled_a, filled_b) = match lack {
            Lack::Stored(a, b) => (slopes(&observed.time_s, a, 1), slopes(&observed.time_s, b, 1)),
            _ => (Vec::new(), Vec::new()),
        };
        observed.each(|row| {
            let (ga, gb) = observed.flows[row].yield_per_pa;
            let (ga, gb) = (ga.max(least), gb.max(least));
            let (flow_a, flow_b, force) = match lack {
                Lack::Flow(a, b) => (a[row], b[row], 0.0),
                Lack::Stored(..) => (-filled_a[row], filled_b[row], 0.0),
                Lack::Force(force) => (0.0, 0.0, force[row]),
                Lack::Position(_) => (0.0, 0.0, 0.0),
            };
            (force + area_a * flow_a / ga + area_b * flow_b / gb)
                / (by.damping + area_a * area_a / ga + area_b * area_b / gb)
        })
    }
}

/// A shape that a lack in one link may have.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    /// The link.
    pub subsystem: Subsystem,
    /// The residuals that it would cause, over all recordings.
    pub left: DVector<f64>,
}

/// What the balances say for each link.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Evidence {
    /// Log-likelihood gained by the best one or two shapes of each link, less their penalty; the largest first.
    pub links: Vec<(Subsystem, f64)>,
    /// Root mean square of each balance, in standard deviations, without what wrong base parameters explain.
    pub over_noise: Vec<(Balance, f64)>,
    /// All that is above the noise, as a log-likelihood.
    pub total: f64,
}

/// Weighs the patterns against the residuals. `wrong` holds the residuals that a usual error of each base parameter would cause,
/// `balances` the balance that each residual belongs to.
#[must_use]
pub(super) fn weigh(
    left: &DVector<f64>,
    balances: &[Balance],
    wrong: &[DVector<f64>],
    patterns: &[Pattern],
) -> Evidence {
    let rest = Rest::of(left, wrong);
    let rows = left.len() as f64;
    let penalty = 0.5 * libm::log(rows.max(2.0));
    // The noise is known: a sum of squares below one per row cannot be distinguished from it.
    let gain = |square: f64| 0.5 * rows * libm::log(rest.square.max(rows) / square.max(rows));
    let projected: Vec<DVector<f64>> = patterns.iter().map(|pattern| rest.without_wrong(&pattern.left)).collect();
    let mut links: Vec<(Subsystem, f64)> = Vec::new();
    for subsystem in [Subsystem::Valve, Subsystem::Flow, Subsystem::Chambers, Subsystem::Mechanics, Subsystem::Sensing]
    {
        let of: Vec<(&DVector<f64>, &DVector<f64>)> = patterns
            .iter()
            .zip(&projected)
            .filter(|(pattern, _)| pattern.subsystem == subsystem)
            .map(|(pattern, projected)| (&pattern.left, projected))
            .collect();
        let mut best = 0.0_f64;
        for (index, one) in of.iter().enumerate() {
            best = best.max(gain(rest.after(&[*one])) - penalty);
            for other in &of[index + 1..] {
                best = best.max(gain(rest.after(&[*one, *other])) - 2.0 * penalty);
            }
        }
        links.push((subsystem, best));
    }
    links.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut over_noise: Vec<(Balance, f64, f64)> = Vec::new();
    for (balance, value) in balances.iter().zip(rest.left.iter()) {
        match over_noise.iter_mut().find(|(known, ..)| known == balance) {
            Some((_, square, count)) => {
                *square += value * value;
                *count += 1.0;
            }
            None => over_noise.push((*balance, value * value, 1.0)),
        }
    }
    let over_noise =
        over_noise.into_iter().map(|(balance, square, count)| (balance, (square / count).sqrt())).collect();
    Evidence { links, over_noise, total: gain(rows) }
}

/// The residuals without what wrong base parameters explain, each within its usual error.
struct Rest {
    wrong: DMatrix<f64>,
    solved: nalgebra::Cholesky<f64, nalgebra::Dyn>,
    left: DVector<f64>,
    square: f64,
}

impl Rest {
    fn of(left: &DVector<f64>, wrong: &[DVector<f64>]) -> Self {
        let wrong = if wrong.is_empty() { DMatrix::zeros(left.len(), 1) } else { DMatrix::from_columns(wrong) };
        let count = wrong.ncols();
        let normal = wrong.tr_mul(&wrong) + DMatrix::identity(count, count);
        let solved = normal.cholesky().expect("a sum of squares and the identity are positive definite");
        let mut rest = Self { wrong, solved, left: left.clone(), square: 0.0 };
        rest.left = rest.without_wrong(left);
        rest.square = left.dot(&rest.left);
        rest
    }

    fn without_wrong(&self, values: &DVector<f64>) -> DVector<f64> {
        values - &self.wrong * self.solved.solve(&self.wrong.tr_mul(values))
    }

    /// Sum of squares that is left after one or two patterns (each given as it is and projected) are fitted in any amount.
    fn after(&self, patterns: &[(&DVector<f64>, &DVector<f64>)]) -> f64 {
        match *patterns {
            [(one, without)] => {
                let size = one.dot(without);
                if size > 0.0 { self.square - self.left.dot(one).powi(2) / size } else { self.square }
            }
            [(one, one_without), (other, other_without)] => {
                let (a, b, c) = (one.dot(one_without), one.dot(other_without), other.dot(other_without));
                let (p, q) = (self.left.dot(one), self.left.dot(other));
                let determinant = a * c - b * b;
                if determinant <= 1e-6 * a * c {
                    return self.after(&patterns[..1]);
                }
                self.square - (c * p * p - 2.0 * b * p * q + a * q * q) / determinant
            }
            _ => self.square,
        }
    }
}
