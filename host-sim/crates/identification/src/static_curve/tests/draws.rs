//! Curves drawn at random, with a fixed seed: characteristic, play, lag and noise.

use recording::StaticTable;

/// `SplitMix64`.
pub(super) struct Random(pub(super) u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    /// Evenly in 0 … 1.
    pub(super) fn even(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One of these.
    pub(super) fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[usize::try_from(self.bits() % choices.len() as u64).unwrap()]
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.even()
    }

    /// Gaussian, standard deviation 1.
    pub(super) fn normal(&mut self) -> f64 {
        (-2.0 * self.even().max(1e-12).ln()).sqrt() * (std::f64::consts::TAU * self.even()).cos()
    }
}

/// How a curve is swept over −10 … 10, and what the bench adds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bench {
    pub(super) rows: usize,
    /// Time of a way up and down, s.
    pub(super) period_s: f64,
    /// Time constant of the meter, s.
    pub(super) lag_s: f64,
    /// Play of the valve, input unit.
    pub(super) play: f64,
    /// Standard deviation of the meter's noise.
    pub(super) noise: f64,
    /// Correlation of the noise from row to row.
    pub(super) alike: f64,
}

impl Bench {
    /// From 250 to 4000 rows, up to 5 % of noise of a curve of height 1.
    pub(super) fn drawn(random: &mut Random) -> Self {
        let rows = random.of(&[250, 500, 1000, 2000, 4000]);
        let alike = if random.even() < 0.5 { 0.0 } else { random.between(0.0, 0.9) };
        Self { rows, period_s: 100.0, lag_s: 0.0, play: 0.0, noise: random.between(0.0, 0.05), alike }
    }

    /// One way up and down.
    pub(super) fn sweep(self, random: &mut Random, curve: impl Fn(f64) -> f64) -> StaticTable {
        let tick_s = self.period_s / self.rows as f64;
        let input: Vec<f64> =
            (0..self.rows).map(|row| 10.0 - 20.0 * (2.0 * row as f64 / (self.rows - 1) as f64 - 1.0).abs()).collect();
        let (mut spool, mut read, mut noise) = (input[0] + 0.5 * self.play, f64::NAN, self.noise * random.normal());
        let output = input.iter().map(|&value| {
            spool = spool.clamp(value - 0.5 * self.play, value + 0.5 * self.play);
            let true_output = curve(spool);
            let follows = if self.lag_s > 0.0 { 1.0 - (-tick_s / self.lag_s).exp() } else { 1.0 };
            read = if read.is_nan() { true_output } else { read + follows * (true_output - read) };
            noise = self.alike * noise + (1.0 - self.alike * self.alike).sqrt() * self.noise * random.normal();
            read + noise
        });
        let output = output.collect();
        StaticTable::new("sweep.csv", vec![("I [mA]".to_owned(), input), ("Q [l/min]".to_owned(), output)])
    }
}
