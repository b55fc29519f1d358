//! Axes: ranges with a margin around the data, ticks at round numbers, labels with as many digits as the step has.

/// A linear axis from data to pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axis {
    low: f64,
    high: f64,
    from_px: f64,
    to_px: f64,
}

impl Axis {
    /// From `low` at `from_px` to `high` at `to_px`.
    pub(crate) fn exact((low, high): (f64, f64), from_px: i32, to_px: i32) -> Self {
        let (low, high) = widened(low, high);
        Self { low, high, from_px: f64::from(from_px), to_px: f64::from(to_px) }
    }

    /// As [`Self::exact`], with a margin above and below.
    pub(crate) fn airy((low, high): (f64, f64), from_px: i32, to_px: i32) -> Self {
        let (low, high) = widened(low, high);
        let air = 0.07 * (high - low);
        Self::exact((low - air, high + air), from_px, to_px)
    }

    /// The pixel of a value; values outside are drawn at the edge.
    pub(crate) fn pixel(&self, value: f64) -> i32 {
        let share = ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        #[expect(clippy::cast_possible_truncation, reason = "between two pixels")]
        let pixel = (self.from_px + share * (self.to_px - self.from_px)).round() as i32;
        pixel
    }

    /// The same axis with finer pixels.
    pub(crate) fn scaled(&self, factor: i32) -> Self {
        let factor = f64::from(factor);
        Self { from_px: self.from_px * factor, to_px: self.to_px * factor, ..*self }
    }

    /// Round values on the axis, about this many, with their labels.
    pub(crate) fn ticks(&self, about: f64) -> Vec<(f64, String)> {
        let rough = (self.high - self.low) / about;
        let unit = libm::pow(10.0_f64, libm::log10(rough).floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * unit);
        let coarse = steps.iter().position(|step| *step >= rough * 0.999).unwrap_or(steps.len() - 1);
        // With a single number, an axis shows no scale.
        let enough = |step: f64| (self.high / step).floor() - (self.low / step).ceil() >= 1.0;
        let step = steps[..=coarse].iter().rev().copied().find(|step| enough(*step)).unwrap_or(0.5 * unit);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0..12")]
        let decimals = (-libm::log10(step * 1.001).floor()).clamp(0.0, 12.0) as usize;
        let first = (self.low / step).ceil();
        (0..40)
            .map(|index| (first + f64::from(index)) * step)
            .take_while(|value| *value <= self.high + 1e-9 * step)
            .map(|value| {
                // no "-0"
                let value = if value.abs() < 1e-9 * step { 0.0 } else { value };
                (value, format!("{value:.decimals$}").replace('-', "−"))
            })
            .collect()
    }
}

/// The range, widened if it is empty.
fn widened(low: f64, high: f64) -> (f64, f64) {
    let least = (low.abs().max(high.abs()) * 1e-9).max(1e-9);
    if high - low >= least {
        (low, high)
    } else {
        let half = (0.05 * low.abs()).max(0.5 * least).max(if low == 0.0 { 1.0 } else { 0.0 });
        (low - half, high + half)
    }
}

/// The smallest and largest finite value, or 0 and 1.
pub(crate) fn extent<'a>(values: impl Iterator<Item = &'a f64>) -> (f64, f64) {
    let finite = values.filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)));
    if low <= high { (low, high) } else { (0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64) -> Vec<String> {
        Axis::exact((low, high), 0, 100).ticks(5.0).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round_and_their_labels_differ() {
        assert_eq!(labels(-0.3, 1.7), ["0.0", "0.5", "1.0", "1.5"]);
        assert_eq!(labels(-2500.0, 2500.0), ["−2000", "−1000", "0", "1000", "2000"]);
        assert_eq!(labels(148.97, 149.03), ["148.98", "149.00", "149.02"]);
        assert_eq!(labels(0.0, 1e-6).len(), 6);
        let few: Vec<String> =
            Axis::exact((-1180.0, 1600.0), 0, 100).ticks(2.8).into_iter().map(|(_, label)| label).collect();
        assert_eq!(few, ["−1000", "0", "1000"]);
        let lone = Axis::exact((-1.9, 1.9), 0, 100).ticks(2.0).len();
        assert!(lone >= 2, "{lone}");
    }

    #[test]
    fn a_constant_series_has_an_axis() {
        for value in [0.0, 5.0, -1e9, 1e-12] {
            let axis = Axis::airy((value, value), 100, 0);
            assert_eq!(axis.pixel(value), 50, "{value}");
            assert!(!axis.ticks(4.0).is_empty(), "{value}");
        }
    }
}
