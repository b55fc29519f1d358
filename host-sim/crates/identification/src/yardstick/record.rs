//! What a linear model needs of a recording: a signal at some of its rows, and what drives it, summed over time.

use recording::Signal;
use simulation::RunningSum;

use super::shape::{Shape, State};
use crate::experiment::Prepared;

/// Points at which a sum over time is kept: enough for delays of a thousandth of a recording.
const MOST_POINTS: usize = 20_000;

/// One signal of a recording, at evenly chosen rows.
#[derive(Clone, Debug)]
pub(super) struct Record {
    /// The chosen rows.
    pub(super) rows: Vec<usize>,
    /// Their times, s after the first row.
    pub(super) time_s: Vec<f64>,
    /// What was recorded in them.
    pub(super) recorded: Vec<f64>,
    /// Whether each is judged: 1 or 0.
    pub(super) weight: Vec<f64>,
    tick_s: f64,
    /// What drives it.
    pub(super) inputs: Vec<RunningSum>,
}

impl Record {
    /// Every so many rows of a recording; `None` where it does not judge the signal.
    pub(super) fn of(case: &Prepared, signal: Signal, every: usize) -> Option<Self> {
        let channel = case.channels.iter().find(|channel| channel.signal == signal)?;
        let tick_s = case.stimulus.tick.seconds();
        let ticks: Vec<f64> = case.stimulus.row_ticks().collect();
        let rows: Vec<usize> = (0..ticks.len().min(case.rows())).step_by(every.max(1)).collect();
        Some(Self {
            time_s: rows.iter().map(|&row| tick_s * ticks[row]).collect(),
            recorded: rows.iter().map(|&row| channel.recorded[row]).collect(),
            weight: rows.iter().map(|&row| f64::from(u8::from(!channel.failed[row]))).collect(),
            rows,
            tick_s,
            inputs: case.stimulus.running_sums(MOST_POINTS),
        })
    }

    /// From the first chosen row to the last, s.
    pub(super) fn duration_s(&self) -> f64 {
        self.time_s.last().zip(self.time_s.first()).map_or(0.0, |(last, first)| last - first)
    }

    /// How many of the chosen rows are judged.
    pub(super) fn judged_rows(&self) -> usize {
        self.judged().count()
    }

    /// Whether what was recorded in them varies.
    pub(super) fn varies(&self) -> bool {
        let mut judged = self.judged();
        judged.next().is_some_and(|first| judged.any(|value| value.to_bits() != first.to_bits()))
    }

    fn judged(&self) -> impl Iterator<Item = f64> + '_ {
        self.recorded.iter().zip(&self.weight).filter(|(_, weight)| **weight > 0.0).map(|(value, _)| *value)
    }

    /// The means of an input between the chosen rows, this much earlier.
    fn means(&self, input: &RunningSum, delay_s: f64) -> Vec<f64> {
        let at = |time_s: f64| (time_s - delay_s) / self.tick_s;
        self.time_s.windows(2).map(|pair| input.mean(at(pair[0]), at(pair[1]))).collect()
    }

    /// The outputs of a shape in the chosen rows: of each input from rest, of a constant input of 1, of a first value of 1, and of a first rate of 1.
    pub(super) fn columns(&self, shape: &Shape, delay_s: f64, inputs: usize) -> Vec<Vec<f64>> {
        let driven: Vec<Vec<f64>> = self.inputs.iter().take(inputs).map(|input| self.means(input, delay_s)).collect();
        let mut states = vec![State::default(); inputs + 3];
        states[inputs + 1].value = 1.0;
        states[inputs + 2].rate = 1.0;
        let mut columns: Vec<Vec<f64>> = states.iter().map(|state| Vec::from_iter([state.value])).collect();
        let mut known = (f64::NAN, shape.step(0.0));
        for (row, pair) in self.time_s.windows(2).enumerate() {
            let time_s = pair[1] - pair[0];
            // Even rows share a step.
            if (time_s - known.0).abs() > 1e-6 * time_s || known.0.is_nan() {
                known = (time_s, shape.step(time_s));
            }
            for (index, (state, column)) in states.iter_mut().zip(&mut columns).enumerate() {
                let input = match index {
                    _ if index < inputs => driven[index][row],
                    _ if index == inputs => 1.0,
                    _ => 0.0,
                };
                *state = known.1.from(*state, input);
                column.push(state.value);
            }
        }
        columns
    }
}
