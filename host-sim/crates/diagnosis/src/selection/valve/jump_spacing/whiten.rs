//! The residual of a model, made white by an autoregression of its own: its smooth parts, whichever form error they come from, then have little
//! weight.

use nalgebra::{DMatrix, DVector};

use simulation::signal::noise::median;
use simulation::signal::window::{rows_in, running_sums};

use super::BLOCK_S;
use super::track::Track;

/// How far back the autoregression looks, s.
const MEMORY_S: f64 = 0.04;

/// The variance of normal noise, from the median of its squares.
pub(crate) fn usual(mut squares: Vec<f64>) -> f64 {
    const MEDIAN: f64 = 0.4549;
    median(&mut squares) / MEDIAN
}

/// A series in which each row that stands out is replaced by the median of seven around it: a spike would ring on in the filter.
pub(crate) fn without_spikes(series: &[f64]) -> Vec<f64> {
    /// Rows to each side.
    const AROUND: usize = 3;
    let level =
        |row: usize| median(&mut series[row.saturating_sub(AROUND)..(row + AROUND + 1).min(series.len())].to_vec());
    let levels: Vec<f64> = (0..series.len()).map(level).collect();
    let apart: Vec<f64> = series.iter().zip(&levels).map(|(value, level)| (value - level).abs()).collect();
    let limit = 6.0 * usual(apart.iter().map(|apart| apart * apart).collect()).sqrt();
    let kept = |((value, level), apart): ((&f64, &f64), &f64)| if *apart > limit { *level } else { *value };
    series.iter().zip(&levels).zip(&apart).map(kept).collect()
}

/// Makes the residuals white, by one autoregression of all recordings. Returns its filter, with the coefficient of the row itself first. `None` where
/// there are too few rows.
pub(crate) fn whitened(tracks: &mut [Track]) -> Option<Vec<f64>> {
    /// Least and most rows that the autoregression looks back.
    const ORDERS: (usize, usize) = (8, 40);
    /// Rounds in which rows with large residuals lose their weight.
    const ROUNDS: usize = 3;
    /// Greatest weight of a row: that of noise with this share of the usual variance.
    const LEAST_VARIANCE: f64 = 0.3;
    /// A squared row counts at most as this many times the median.
    const MOST_SQUARE: f64 = 25.0;
    /// A white row is limited to this many standard deviations.
    const CUT: f64 = 6.0;
    let rows = tracks.iter().map(Track::rows).min()?;
    if rows < 4 * ORDERS.1 {
        return None;
    }
    let order = rows_in(&tracks[0].time_s, MEMORY_S).clamp(ORDERS.0, ORDERS.1);
    let around = rows_in(&tracks[0].time_s, 0.5 * BLOCK_S);
    let noise = tracks.iter().map(|track| track.noise_m.powi(2)).sum::<f64>() / tracks.len() as f64;
    let mut weights: Vec<Vec<f64>> = tracks.iter().map(|track| vec![1.0; track.rows()]).collect();
    let mut memory = vec![1.0];
    for _ in 0..ROUNDS {
        memory = autoregression(tracks, &weights, order, noise)?;
        for (track, weights) in tracks.iter().zip(&mut weights) {
            let left = filtered(&track.missed_m, &memory);
            let squares: Vec<f64> = left.iter().map(|value| value * value).collect();
            let usual = usual(squares.clone());
            let most = MOST_SQUARE * median(&mut squares.clone());
            let sums = running_sums(squares.iter().map(|square| square.min(most)));
            for (row, weight) in weights.iter_mut().enumerate() {
                let (from, to) = (row.saturating_sub(around), (row + around + 1).min(squares.len()));
                let here = (sums[to] - sums[from]) / (to - from) as f64;
                *weight = 1.0 / here.max(LEAST_VARIANCE * usual).max(f64::MIN_POSITIVE);
            }
        }
        let (sum, count) =
            weights.iter().flatten().fold((0.0, 0.0), |(sum, count), weight| (sum + weight, count + 1.0));
        for weight in weights.iter_mut().flatten() {
            *weight *= count / sum;
        }
    }
    for track in tracks {
        let mut white = filtered(&track.missed_m, &memory);
        let limit = CUT * usual(white.iter().map(|value| value * value).collect()).sqrt();
        for value in &mut white {
            *value = value.clamp(-limit, limit);
        }
        // The first rows have too few rows before them.
        white[..=order].fill(0.0);
        track.missed_m = white;
    }
    Some(memory)
}

/// The filter that leaves the smallest residual, by weighted least squares; a ridge from the sensor's noise keeps it from fitting what is hidden in
/// that noise.
fn autoregression(tracks: &[Track], weights: &[Vec<f64>], order: usize, noise: f64) -> Option<Vec<f64>> {
    const RIDGE: f64 = 1e-3;
    let mut normal = DMatrix::<f64>::zeros(order, order);
    let mut target = DVector::<f64>::zeros(order);
    let mut weighed = 0.0;
    for (track, weights) in tracks.iter().zip(weights) {
        for (window, &weight) in track.missed_m.windows(order + 1).zip(&weights[order..]) {
            let before = DVector::from_iterator(order, window[..order].iter().rev().copied());
            normal.syger(weight, &before, &before, 1.0);
            target.axpy(weight * window[order], &before, 1.0);
            weighed += weight;
        }
    }
    let ridge = RIDGE * weighed * noise + 1e-9 * normal.trace() / order as f64;
    normal += DMatrix::identity(order, order) * ridge;
    let solution = normal.cholesky()?.solve(&target);
    Some(std::iter::once(1.0).chain(solution.iter().map(|share| -share)).collect())
}

/// A series through a filter of its present and past rows.
pub(crate) fn filtered<T>(series: &[T], memory: &[f64]) -> Vec<T>
where
    T: Copy + std::ops::Mul<f64, Output = T> + std::iter::Sum,
{
    let at =
        |row: usize| memory.iter().take(row + 1).enumerate().map(|(back, share)| series[row - back] * *share).sum();
    (0..series.len()).map(at).collect()
}
