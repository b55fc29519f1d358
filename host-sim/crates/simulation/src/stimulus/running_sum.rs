//! What drives a model, summed over time: a linear model that steps from row to row needs the mean of its input between two times.

use super::{Input, Stimulus};

/// The sum over time of a signal that drives a model, with straight lines between its points.
#[derive(Clone, Debug, PartialEq)]
pub struct RunningSum {
    /// Ticks between two points.
    spacing: f64,
    /// At each point, in the signal's unit times ticks.
    sums: Vec<f64>,
    /// Values before the beginning and after the end.
    first: f64,
    last: f64,
}

impl RunningSum {
    /// Of one value a tick, kept at no more than so many points.
    fn of(means: impl Iterator<Item = f64> + Clone, ticks: usize, most: usize) -> Self {
        let every = ticks.div_ceil(most).max(1);
        let (mut sums, mut sum) = (vec![0.0], 0.0);
        for (tick, mean) in (1..).zip(means.clone()) {
            sum += mean;
            if tick % every == 0 {
                sums.push(sum);
            }
        }
        let first = means.clone().next().unwrap_or(0.0);
        Self { spacing: every as f64, sums, first, last: means.last().unwrap_or(0.0) }
    }

    /// The sum up to this time, in ticks since the beginning.
    fn until(&self, tick: f64) -> f64 {
        let place = tick / self.spacing;
        let end = self.sums.len() - 1;
        if place <= 0.0 {
            return tick * self.first;
        }
        if place >= end as f64 {
            return self.sums[end] + (tick - end as f64 * self.spacing) * self.last;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between the first and the last point"
        )]
        let point = place as usize;
        self.sums[point] + (place - point as f64) * (self.sums[point + 1] - self.sums[point])
    }

    /// The mean between two times, in ticks since the beginning; what is before it is the first value.
    #[must_use]
    pub fn mean(&self, from: f64, to: f64) -> f64 {
        if to > from { (self.until(to) - self.until(from)) / (to - from) } else { self.first }
    }
}

impl Stimulus {
    /// The signals that drive the model, each summed over time and kept at no more than so many points: the drive's own (a pump's speed with the sign of
    /// its directional valve) and, where one is recorded, the external force. They are in the signals' SI units.
    #[must_use]
    pub fn running_sums(&self, most: usize) -> Vec<RunningSum> {
        let between =
            |points: &[f64]| -> Vec<f64> { points.windows(2).map(|pair| f64::midpoint(pair[0], pair[1])).collect() };
        let summed = |means: &[f64]| RunningSum::of(means.iter().copied(), self.ticks, most);
        let own = match &self.input {
            Input::Command(held) => summed(held),
            Input::Pump(speed, direction) => {
                let signed = |(speed, direction): (&f64, &i8)| speed.abs() * f64::from(*direction);
                summed(&speed.iter().zip(direction).map(signed).collect::<Vec<_>>())
            }
            Input::Spool(points) | Input::Flow(points, _) | Input::Force(points) => summed(&between(points)),
        };
        let load = self.load_n.as_ref().filter(|_| !self.is_balanced()).map(|points| summed(&between(points)));
        std::iter::once(own).chain(load).collect()
    }

    /// Times of the rows, in ticks since the first.
    pub fn row_ticks(&self) -> impl Iterator<Item = f64> + '_ {
        self.rows.iter().map(|&(point, share)| point as f64 + share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_between_two_times_counts_each_tick_by_its_share() {
        let means: Vec<f64> = (0..10).map(f64::from).collect();
        let sum = RunningSum::of(means.iter().copied(), 10, 100);
        assert!((sum.mean(2.0, 4.0) - 2.5).abs() < 1e-12);
        assert!((sum.mean(2.5, 3.0) - 2.0).abs() < 1e-12);
        // Before the beginning and after the end it is what it was there.
        assert!((sum.mean(-4.0, -1.0) - 0.0).abs() < 1e-12 && (sum.mean(12.0, 15.0) - 9.0).abs() < 1e-12);
        let coarse = RunningSum::of(means.iter().copied(), 10, 5);
        assert!((coarse.mean(2.0, 6.0) - 3.5).abs() < 1e-12);
    }
}
