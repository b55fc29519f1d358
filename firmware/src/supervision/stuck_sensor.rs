//! A sensor that stands still while the model says that it must move.
//!
//! A working sensor changes by a count sooner or later, if only by noise. A sensor is stuck if its count stays the same although the model
//! has moved by a stated travel since the count last changed, and if this lasts for a stated number of periods: its converter hangs, its
//! coupling broke, or the part that it measures is jammed.

use model_core::number::{Number, PerUnit};

/// How long a sensor may stand still: configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// How far the model must have moved since the count last changed, per unit.
    pub travel: PerUnit,
    /// For how many successive periods.
    pub periods: u16,
}

/// How long a sensor has stood still.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stillness {
    /// The count, and the model's value when the count last changed.
    since: Option<(i64, PerUnit)>,
    /// Periods since the model moved by the travel.
    periods: u16,
}

impl Stillness {
    /// Nothing seen yet.
    pub const NEW: Self = Self { since: None, periods: 0 };

    /// How far the model, which is here now, has moved since the count last changed.
    #[must_use]
    pub fn moved(&self, model: PerUnit) -> PerUnit {
        self.since.map_or(PerUnit::ZERO, |(_, then)| (model - then).magnitude())
    }

    /// Takes a period's count and model value; returns whether the sensor is stuck.
    pub fn step(&mut self, patience: &Patience, count: i64, model: PerUnit) -> bool {
        match self.since {
            Some((last, then)) if last == count => {
                let moved = (model - then).magnitude() >= patience.travel;
                self.periods = if moved { self.periods.saturating_add(1) } else { 0 };
            }
            _ => *self = Self { since: Some((count, model)), periods: 0 },
        }
        self.periods > 0 && self.periods >= patience.periods
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_is_stuck_after_its_periods_and_not_before() {
        let patience = Patience { travel: PerUnit::saturated(0.01), periods: 3 };
        let mut still = Stillness::NEW;
        let at = |percent: i32| PerUnit::saturated(f64::from(percent) / 100.0);
        // The model moves by 1 % per period.
        let stuck: [bool; 5] =
            core::array::from_fn(|period| still.step(&patience, 7, at(i32::try_from(period).unwrap())));
        assert_eq!(stuck, [false, false, false, true, true]);
        assert!(!still.step(&patience, 8, at(5)), "one count is enough");
        // A model that stays within the travel raises no fault.
        for _ in 0..100 {
            assert!(!still.step(&patience, 8, PerUnit::saturated(0.055)));
        }
    }
}
