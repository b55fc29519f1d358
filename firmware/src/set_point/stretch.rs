//! A leg of a course in the period's number format: a set point takes a few multiplications.

use model_core::control::SetPoint;
use model_core::number::{Number, PerUnit};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Jump,
    Line,
    Smooth,
}

/// A leg in the period's number format.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    pub(super) shape: Shape,
    pub(super) from: PerUnit,
    pub(super) way: PerUnit,
    /// Mean velocity.
    pub(super) velocity: PerUnit,
    pub(super) ticks: u32,
    /// 2⁶⁰ / ticks
    pub(super) inverse: u64,
}

impl Stretch {
    /// The set point after so many ticks of the leg.
    pub(super) fn at(&self, tick: u32) -> SetPoint {
        let rest = PerUnit::ZERO;
        let (share, rate) = match self.shape {
            Shape::Jump => (PerUnit::ONE, rest),
            Shape::Line => (self.share(tick), PerUnit::ONE),
            Shape::Smooth => smooth(self.share(tick)),
        };
        SetPoint { position: self.from + self.way.times(share), velocity: self.velocity.times(rate) }
    }

    /// Share of the time that has passed, 0..1.
    fn share(&self, tick: u32) -> PerUnit {
        let bits = u64::from(tick).saturating_mul(self.inverse) >> 32;
        PerUnit::from_bits(i32::try_from(bits).unwrap_or(i32::MAX))
    }
}

/// Position and velocity of a smooth leg, relative to its way and to its mean velocity.
fn smooth(share: PerUnit) -> (PerUnit, PerUnit) {
    // Half of 10 − 15·s + 6·s², which is at most 5.
    let half = FIVE - SEVEN_AND_A_HALF.times(share) + THREE.times(share).times(share);
    let way = share.times(share).times(share).times(half);
    // 4·s·(1 − s), which is at most 1.
    let hump = share.times(PerUnit::ONE - share).times(FOUR);
    (way + way, hump.times(hump).times(PEAK))
}

const fn counted(eighths: i32) -> PerUnit {
    PerUnit::from_bits(eighths << 25)
}
const THREE: PerUnit = counted(24);
const FOUR: PerUnit = counted(32);
const FIVE: PerUnit = counted(40);
const SEVEN_AND_A_HALF: PerUnit = counted(60);
const PEAK: PerUnit = counted(15);
