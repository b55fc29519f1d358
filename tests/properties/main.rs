//! What holds for every drive, every state and every input.
//!
//! The seeds are fixed, so that a run says the same everywhere; a case that once failed is kept in `proptest-regressions`.

mod agreement;
mod derivatives;
mod effects;
mod extremes;
mod friction;
mod physics;
mod repeat;
mod settling;
mod symmetry;

use proptest::test_runner::{Config, RngSeed};

/// That many cases from a fixed seed.
fn cases(cases: u32) -> Config {
    Config { cases, rng_seed: RngSeed::Fixed(20_200), ..Config::default() }
}
