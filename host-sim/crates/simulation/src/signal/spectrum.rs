//! The strongest line in the spectrum of a series, apart from its trend.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

/// A spectral line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralLine {
    /// Frequency, Hz.
    pub hz: f64,
    /// Amplitude, in the unit of the series.
    pub amplitude: f64,
    /// Its power over the median power of the spectrum around it.
    pub above: f64,
}

/// Bins on each side of a bin from which its background is taken.
const AROUND: usize = 25;
/// Bins next to a line that belong to it with Hann's window.
const OF_LINE: usize = 2;

/// The line that exceeds its background most between `least_hz` and half the sampling rate; `None` for a series too short to show one.
///
/// Samples are assumed to be evenly spaced. The window is Hann's.
#[must_use]
pub fn strongest_line(values: &[f64], interval_s: f64, least_hz: f64) -> Option<SpectralLine> {
    let count = values.len();
    if count < 4 * AROUND {
        return None;
    }
    let mean = values.iter().sum::<f64>() / count as f64;
    let mut buffer: Vec<Complex<f64>> = values
        .iter()
        .enumerate()
        .map(|(row, value)| {
            let weight = 0.5 * (1.0 - libm::cos(std::f64::consts::TAU * row as f64 / count as f64));
            Complex::new((value - mean) * weight, 0.0)
        })
        .collect();
    FftPlanner::new().plan_fft_forward(count).process(&mut buffer);
    let power: Vec<f64> = buffer[..count / 2].iter().map(Complex::norm_sqr).collect();
    let per_bin_hz = 1.0 / (interval_s * count as f64);
    let mut best: Option<SpectralLine> = None;
    for (bin, &here) in power.iter().enumerate().skip(1) {
        let hz = bin as f64 * per_bin_hz;
        let neighbours = &power[bin.saturating_sub(1)..(bin + 2).min(power.len())];
        if hz < least_hz || neighbours.iter().any(|other| *other > here) {
            continue;
        }
        let mut around: Vec<f64> = (bin.saturating_sub(AROUND)..(bin + AROUND + 1).min(power.len()))
            .filter(|other| other.abs_diff(bin) > OF_LINE)
            .map(|other| power[other])
            .collect();
        around.sort_by(f64::total_cmp);
        let background = around[around.len() / 2].max(f64::MIN_POSITIVE);
        let above = here / background;
        if best.is_none_or(|best| above > best.above) {
            // Hann's window halves the amplitude once more.
            best = Some(SpectralLine { hz, amplitude: 4.0 * here.sqrt() / count as f64, above });
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_in_noise_is_found_with_its_amplitude() {
        let mut seed = 1_u32;
        let mut noise = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
        };
        let values: Vec<f64> =
            (0..4000).map(|row| 3.0 * (std::f64::consts::TAU * 85.0 * f64::from(row) * 1e-3).sin() + noise()).collect();
        let line = strongest_line(&values, 1e-3, 10.0).unwrap();
        assert!((line.hz - 85.0).abs() < 0.3, "{line:?}");
        assert!((line.amplitude / 3.0 - 1.0).abs() < 0.05, "{line:?}");
        assert!(line.above > 1e4, "{line:?}");
    }

    #[test]
    fn noise_has_no_line_far_above_the_rest() {
        let mut seed = 7_u32;
        let values: Vec<f64> = (0..4000)
            .map(|_| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(seed >> 8) / f64::from(1 << 24)
            })
            .collect();
        assert!(strongest_line(&values, 1e-3, 10.0).unwrap().above < 30.0);
    }
}
