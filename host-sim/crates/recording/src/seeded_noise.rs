//! Repeatable noise: a seed, one random stream for each channel, and the same numbers on every machine.

use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// A source of random numbers for one channel.
#[derive(Clone, Debug)]
pub struct Noise {
    generator: ChaCha8Rng,
}

impl Noise {
    /// `stream` makes the channels independent: adding or removing a channel does not change the others.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        Self { generator }
    }

    /// Uniformly distributed in [from, to).
    pub fn uniform(&mut self, from: f64, to: f64) -> f64 {
        const STEP: f64 = 1.0 / 9_007_199_254_740_992.0; // 2⁻⁵³
        from + (to - from) * ((self.generator.next_u64() >> 11) as f64 * STEP)
    }

    /// Log-uniformly distributed between two positive values.
    pub fn decades(&mut self, from: f64, to: f64) -> f64 {
        libm::exp(self.uniform(libm::log(from), libm::log(to)))
    }

    /// A number below `count`; `count` must not be 0.
    pub fn below(&mut self, count: usize) -> usize {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below count, not negative")]
        let drawn = self.uniform(0.0, count as f64) as usize;
        drawn.min(count - 1)
    }

    /// True with this probability.
    pub fn happens(&mut self, chance: f64) -> bool {
        self.uniform(0.0, 1.0) < chance
    }

    /// +1 or −1.
    pub fn sign(&mut self) -> f64 {
        if self.happens(0.5) { 1.0 } else { -1.0 }
    }

    /// Gaussian with mean 0 and the given standard deviation (Box and Muller).
    ///
    /// Uses `libm` rather than the platform's functions, whose last bit differs.
    pub fn gaussian(&mut self, deviation: f64) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.uniform(0.0, 1.0))).sqrt();
        deviation * radius * libm::cos(self.uniform(0.0, std::f64::consts::TAU))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaussian_noise_has_the_asked_deviation() {
        let mut noise = Noise::new(1, 0);
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..100_000 {
            let sample = noise.gaussian(3.0);
            sum += sample;
            squares += sample * sample;
        }
        assert!((sum / 1e5).abs() < 0.03);
        assert!(((squares / 1e5).sqrt() - 3.0).abs() < 0.03);
    }

    #[test]
    fn the_same_seed_repeats_and_streams_differ() {
        let draw = |seed, stream| Noise::new(seed, stream).gaussian(1.0).to_bits();
        assert_eq!(draw(7, 2), draw(7, 2));
        assert_ne!(draw(7, 2), draw(7, 3));
        assert_ne!(draw(7, 2), draw(8, 2));
    }
}
