//! Properties of every drive, every state and every input.
//!
//! The seeds are fixed, so that every run gives the same result; a case that once failed is repeated by its seed, or is a test of its
//! own. More cases, thirty times as many with another seed:
//!
//! ```text
//! CASES_TIMES=30 CASES_SEED=1 cargo test -p system-tests --test properties
//! ```

mod agreement;
mod axis;
mod balance;
mod data_sheets;
mod derivatives;
mod effects;
mod extremes;
mod friction;
mod in_lanes;
mod physics;
mod ports;
mod repeat;
mod settling;
mod single;
mod smooth;
mod symmetry;
mod ticks;
mod time;

use proptest::test_runner::{Config, RngSeed, TestRunner};

/// This number of cases from a fixed seed; `CASES_TIMES` as many, and from the seed `CASES_SEED`, where these are set.
fn cases(cases: u32) -> Config {
    let set = |name: &str| {
        std::env::var(name).ok().map(|text| text.parse::<u32>().unwrap_or_else(|_| panic!("{name}={text}")))
    };
    let seed = set("CASES_SEED").unwrap_or(20_200);
    let cases = cases * set("CASES_TIMES").unwrap_or(1);
    Config {
        cases,
        // Of ten machines with any effects, some do not fit the format.
        max_global_rejects: 10 * cases,
        rng_seed: RngSeed::Fixed(seed.into()),
        ..Config::default()
    }
}

/// Runs this number of cases of a law that is judged by all of them together; a case that fails alone is kept beside the others of `file`.
fn runner(number: u32, file: &'static str) -> TestRunner {
    TestRunner::new(Config { source_file: Some(file), ..cases(number) })
}
