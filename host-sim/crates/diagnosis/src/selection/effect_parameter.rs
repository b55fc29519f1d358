//! How an effect parameter moves in a search: its prior, its neutral value, and the points of its range that are tried.

use identification::fit::{Free, Freedom};

use crate::catalogue::{EffectParameter, Kind, Scene};
use crate::since::KNOWN_TIMES;

impl EffectParameter {
    /// How a fit moves this parameter: a broad prior over its usual range. How an effect acts that may have changed is known from then: what wears is its
    /// amount.
    #[must_use]
    pub fn free(&self, scene: &Scene<'_>) -> Free {
        // The usual range, widened threefold, is ±2 standard deviations.
        let logarithm = |(low, high): (f64, f64), vanishes: bool| Freedom::Logarithm {
            centre: (low * high).sqrt(),
            spread: (libm::log(high / low) + 2.0 * libm::log(3.0_f64)) / 4.0,
            vanishes,
        };
        let freedom = match self.kind {
            Kind::Amount(range) | Kind::Firm(range) | Kind::Jump(range) => logarithm(range(scene), true),
            Kind::Shape(range, _) => match (scene.shape_then(self), logarithm(range(scene), false)) {
                (Some(centre), Freedom::Logarithm { spread, .. }) => {
                    Freedom::Logarithm { centre, spread: spread / KNOWN_TIMES, vanishes: false }
                }
                (_, broad) => broad,
            },
            Kind::Signed(size) => Freedom::Signed { sigma: size(scene) },
            Kind::Place(range, _) | Kind::Floor(range, _) | Kind::Setting(range, _) => {
                let (low, high) = range(scene);
                Freedom::Around { nominal: f64::midpoint(low, high), sigma: 0.5 * (high - low) }
            }
        };
        Free { parameter: self.parameter, freedom }
    }

    /// Whether it says how much of the effect there is.
    pub fn is_amount(&self) -> bool {
        matches!(self.kind, Kind::Amount(_) | Kind::Firm(_) | Kind::Jump(_) | Kind::Signed(_))
    }

    /// Whether it may have either sign.
    pub(crate) fn is_signed(&self) -> bool {
        matches!(self.kind, Kind::Signed(_))
    }

    /// The value at which the effect is absent; `None` for a parameter that describes only how the effect acts.
    #[must_use]
    pub fn neutral(&self) -> Option<f64> {
        match self.kind {
            Kind::Amount(_) | Kind::Firm(_) | Kind::Jump(_) | Kind::Signed(_) => Some(0.0),
            Kind::Floor(..) | Kind::Setting(..) => Some(self.parameter.description().min),
            Kind::Shape(..) | Kind::Place(..) => None,
        }
    }

    /// Whether it has no usable derivative, so that a fit does not move it.
    #[must_use]
    pub fn is_jump(&self) -> bool {
        matches!(self.kind, Kind::Jump(_) | Kind::Floor(..))
    }

    /// The amount at which its direction is simulated.
    pub fn unit(&self, scene: &Scene<'_>) -> f64 {
        match self.kind {
            Kind::Amount(range) | Kind::Firm(range) | Kind::Jump(range) | Kind::Shape(range, _) => {
                let (low, high) = range(scene);
                (low * high).sqrt()
            }
            Kind::Signed(size) => 0.3 * size(scene),
            Kind::Place(range, _) => range(scene).1,
            Kind::Floor(range, _) | Kind::Setting(range, _) => range(scene).0.abs(),
        }
    }

    /// Its usual range in the unit of its parameter; symmetric about 0 for a value of either sign.
    #[must_use]
    pub fn range(&self, scene: &Scene<'_>) -> (f64, f64) {
        match self.kind {
            Kind::Amount(range)
            | Kind::Firm(range)
            | Kind::Jump(range)
            | Kind::Shape(range, _)
            | Kind::Place(range, _)
            | Kind::Floor(range, _)
            | Kind::Setting(range, _) => range(scene),
            Kind::Signed(size) => (-size(scene), size(scene)),
        }
    }

    /// Points of the range of a shape or a place to try.
    pub(crate) fn tries(&self, scene: &Scene<'_>) -> Vec<f64> {
        match self.kind {
            Kind::Shape(range, count) => {
                let (low, high) = range(scene);
                (0..count).map(|index| low * libm::pow(high / low, (index as f64 + 0.5) / count as f64)).collect()
            }
            Kind::Place(range, shares) | Kind::Floor(range, shares) | Kind::Setting(range, shares) => {
                let (low, high) = range(scene);
                shares.iter().map(|share| low + (high - low) * share).collect()
            }
            _ => Vec::new(),
        }
    }
}
