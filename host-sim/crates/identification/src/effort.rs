//! What simulations cost, counted by their ticks and not by a clock: the same recordings cost the same on every machine, so that a search that ends by
//! its limit ends everywhere at the same place.
//!
//! A tick has a fixed price in processor time. It is about what one core of a present x86-64 server takes for it:
//! `cargo test --release -p identification --lib effort::tests::price -- --ignored --nocapture` measures it where it runs. A machine that is twice as slow
//! takes twice as long as a limit says. What is no simulation (linear algebra, statistics, reading and reports) is not counted: on a loaded
//! machine two diagnoses took 1.1 times the counted processor time, one of few long recordings took twice that.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::stop;

/// Price of a tick of a simulation, ns, beside others in SIMD lanes.
const PLAIN_NS: u64 = 75;
/// The same of a tick with derivatives, without them.
const DERIVED_NS: u64 = 100;
/// What each eight derivatives add.
const EIGHT_DERIVATIVES_NS: u64 = 220;

/// Cores that a limit in seconds is meant for.
const CORES: f64 = 2.0;

/// Work done for a recording and all that share its meter, and the limit of it.
#[derive(Clone, Debug)]
pub struct Effort {
    spent_ns: Arc<AtomicU64>,
    limit_ns: u64,
}

impl Default for Effort {
    /// Without a limit.
    fn default() -> Self {
        Self { spent_ns: Arc::default(), limit_ns: u64::MAX }
    }
}

/// How much was worked for a recording is no part of what it holds.
impl PartialEq for Effort {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Effort {
    /// Nothing spent yet of this time on two cores, s.
    #[must_use]
    pub fn within(limit_s: f64) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a negative time is none, a huge one no limit"
        )]
        Self { limit_ns: (limit_s * CORES * 1e9) as u64, ..Self::default() }
    }

    /// A meter of its own that begins where this one stands, for one of two searches that run side by side: each may spend half of what is left, however
    /// far the other is.
    #[must_use]
    pub fn apart(&self) -> Self {
        let spent_ns = self.spent_ns();
        let limit_ns = spent_ns + self.limit_ns.saturating_sub(spent_ns) / 2;
        Self { spent_ns: Arc::new(AtomicU64::new(spent_ns)), limit_ns }
    }

    /// Adds what a search with a meter of its own has spent since this one stood at `from_s`.
    pub fn join(&self, other: &Self, from_s: f64) {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a positive time that was counted in ns"
        )]
        let began = (from_s * CORES * 1e9).round() as u64;
        self.add(other.spent_ns().saturating_sub(began));
    }

    /// What a simulation of this many ticks with derivatives by so many parameters costs, s on two cores.
    #[must_use]
    pub fn of_derivatives_s(ticks: usize, parameters: usize) -> f64 {
        derived_ns(ticks, parameters) as f64 * 1e-9 / CORES
    }

    /// Counts a simulation of this many ticks.
    pub(crate) fn simulated(&self, ticks: usize) {
        self.add(ticks as u64 * PLAIN_NS);
    }

    /// Counts a simulation with derivatives by this many parameters.
    pub(crate) fn derived(&self, ticks: usize, parameters: usize) {
        self.add(derived_ns(ticks, parameters));
    }

    /// What was spent so far, s on two cores.
    #[must_use]
    pub fn spent_s(&self) -> f64 {
        self.spent_ns() as f64 * 1e-9 / CORES
    }

    /// The limit, s on two cores; `None` where there is none.
    #[must_use]
    pub fn limit_s(&self) -> Option<f64> {
        (self.limit_ns < u64::MAX).then(|| self.limit_ns as f64 * 1e-9 / CORES)
    }

    /// Whether the limit is reached. Several searches that share a meter must not ask while they run side by side.
    #[must_use]
    pub fn is_used_up(&self) -> bool {
        self.spent_ns() >= self.limit_ns
    }

    fn spent_ns(&self) -> u64 {
        self.spent_ns.load(Ordering::Relaxed)
    }

    /// Every simulation of a search comes by here: it goes no further once it was asked to stop.
    fn add(&self, ns: u64) {
        stop::here();
        self.spent_ns.fetch_add(ns, Ordering::Relaxed);
    }
}

fn derived_ns(ticks: usize, parameters: usize) -> u64 {
    ticks as u64 * (DERIVED_NS + EIGHT_DERIVATIVES_NS * parameters.div_ceil(8) as u64)
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use machine_file::LoadSource;
    use model_core::machine::Parameter as P;
    use recording::Signal;
    use test_press::{recorded_for, with_papers_valve};

    use super::*;
    use crate::experiment::Prepared;
    use crate::fit::residuals::{runs, simulated};
    use crate::fit::{Free, From, StartState, fit};

    #[test]
    fn copies_share_a_meter_and_searches_side_by_side_have_their_own() {
        let all = Effort::within(1.0);
        let copy = all.clone();
        copy.derived(1_000_000, 12);
        assert!(all.spent_s() > 0.0 && !all.is_used_up());
        let (began_s, one, other) = (all.spent_s(), all.apart(), all.apart());
        one.simulated(1_000_000);
        let spent_s = one.spent_s() - began_s;
        assert!(spent_s > 0.0 && (all.spent_s() - began_s).abs() < 1e-12 && (other.spent_s() - began_s).abs() < 1e-12);
        all.join(&one, began_s);
        assert!((all.spent_s() - began_s - spent_s).abs() < 1e-8);
        all.derived(10_000_000, 12);
        assert!(all.is_used_up() && !other.is_used_up());
    }

    #[test]
    fn without_a_limit_it_is_never_used_up() {
        let all = Effort::default();
        all.derived(1_000_000_000, 60);
        assert!(!all.is_used_up() && all.limit_s().is_none());
        assert_eq!(Effort::within(2.5).limit_s(), Some(2.5));
    }

    /// What a tick costs here on one core beside the price that it is counted at.
    #[test]
    #[ignore = "measures times"]
    fn price_of_a_tick_here() {
        let machine = with_papers_valve();
        let read = recorded_for(&machine, &[(Signal::Position, 1e-5)], 20_000);
        let case = Prepared::new(&read, &machine, LoadSource::Constant, None).unwrap();
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let timed = |what: &str, work: &(dyn Fn() + Sync)| {
            one.install(work);
            let (spent_s, start) = (case.effort.spent_s(), Instant::now());
            one.install(work);
            let counted_s = CORES * (case.effort.spent_s() - spent_s);
            println!("{what}: {:.2} of the price", start.elapsed().as_secs_f64() / counted_s);
        };
        timed("without derivatives", &|| {
            let runs = runs(&machine, (0..8).map(|_| (&case, StartState::default())));
            simulated(&machine, &runs, |_| true).unwrap();
        });
        let values = [
            P::ValveGain,
            P::DeadZone,
            P::TimeConstant1,
            P::TimeConstant2,
            P::TransportDelay,
            P::FlowCoefficient,
            P::BulkModulus,
            P::ViscousFriction,
            P::ValveOffset,
            P::MovingMass,
            P::LoadForce,
            P::VolumeA,
        ];
        for count in [6, 12] {
            let around = |&parameter: &P| {
                let value = machine.get(parameter);
                Free::around(parameter, value, 0.1 * value.abs().max(0.1))
            };
            let free: Vec<Free> = values[..count].iter().map(around).collect();
            timed(&format!("with {count} derivatives"), &|| {
                fit(&machine, &free, &[&case], &From::default(), 1e-3).unwrap();
            });
        }
    }
}
