//! The floor of a step: the time of its arithmetic alone, if no operation waited for another and nothing else had to be done.

use std::cell::Cell;
use std::cmp::Ordering;
use std::hint::black_box;
use std::ops::{Add, Div, Mul, Neg, Sub};
use std::time::Instant;

use model_core::drive::Load;
use model_core::machine::Machine;
use model_core::number::Field;
use simulation::number::simd::{LANES, Lanes};
use system_tests::simulate::{at_rest, drive};
use virtual_plant::InitialState;

use crate::run::TICK;

/// Operations on reals; a comparison is one, a change of sign none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Operations {
    /// Sums, differences and comparisons, which take the same time.
    pub sums: f64,
    /// Products.
    pub products: f64,
    /// Quotients.
    pub quotients: f64,
    /// Square roots.
    pub roots: f64,
}

thread_local! {
    /// Operations that this thread has done with [`Counted`] numbers.
    static DONE: Cell<Operations> = const { Cell::new(Operations { sums: 0.0, products: 0.0, quotients: 0.0, roots: 0.0 }) };
}

fn done(of: impl Fn(&mut Operations) -> &mut f64) {
    let mut operations = DONE.get();
    *of(&mut operations) += 1.0;
    DONE.set(operations);
}

/// A real number that counts what is computed with it.
#[derive(Clone, Copy, Debug)]
struct Counted(f64);

impl PartialEq for Counted {
    fn eq(&self, other: &Self) -> bool {
        done(|operations| &mut operations.sums);
        self.0 == other.0
    }
}

impl PartialOrd for Counted {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        done(|operations| &mut operations.sums);
        self.0.partial_cmp(&other.0)
    }
}

impl Add for Counted {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        done(|operations| &mut operations.sums);
        Self(self.0 + other.0)
    }
}

impl Sub for Counted {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        done(|operations| &mut operations.sums);
        Self(self.0 - other.0)
    }
}

impl Mul for Counted {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        done(|operations| &mut operations.products);
        Self(self.0 * other.0)
    }
}

impl Div for Counted {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        done(|operations| &mut operations.quotients);
        Self(self.0 / other.0)
    }
}

impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Field for Counted {
    type Real = f64;

    const ZERO: Self = Self(0.0);
    const ONE: Self = Self(1.0);

    fn constant(value: f64) -> Self {
        Self(value)
    }
    fn coefficient(value: f64) -> Self {
        Self(value)
    }
    fn sqrt(self) -> Self {
        done(|operations| &mut operations.roots);
        Self(self.0.sqrt())
    }
}

impl Operations {
    /// Mean operations of a tick of the paper's model, which starts at rest and runs under commands in V.
    ///
    /// # Panics
    /// The machine is invalid, or has effects.
    #[must_use]
    pub fn of_a_tick(machine: &Machine<f64>, initial: &InitialState, volts: &[f32]) -> Self {
        let drive = drive::<Counted>(machine, TICK);
        let paper = drive.without_effects().expect("the drives that are measured are the paper's");
        let mut state = at_rest(&drive, 0.0, initial);
        DONE.set(Self::default());
        for &volts in volts {
            paper.step(&mut state, Counted(f64::from(volts) / drive.bases().command_v), Load::NONE);
        }
        let (all, ticks) = (DONE.get(), volts.len() as f64);
        Self {
            sums: all.sums / ticks,
            products: all.products / ticks,
            quotients: all.quotients / ticks,
            roots: all.roots / ticks,
        }
    }

    /// Least time that the operations take on this processor, s, if none waits for another. One instruction
    /// does [`WIDE`] operations at once, in the time of one.
    ///
    /// Sums and products run in parallel, and so do these and the divisions and roots: the longer of the two times counts.
    #[must_use]
    pub fn floor_s(&self) -> f64 {
        let both = shortest(|x, sums: &mut Chains, products: &mut Chains| {
            for (sum, product) in sums.iter_mut().zip(products) {
                *sum = *sum + x;
                *product = *product * x;
            }
        });
        let quotient = shortest(|x, values: &mut Chains, _| {
            for value in values {
                *value = x / *value;
            }
        });
        let root = shortest(|_, values: &mut Chains, _| {
            for value in values {
                *value = value.sqrt();
            }
        });
        // Sums and products are averaged: counting a pair for each of the more frequent kind would be too much where both share their units.
        let simple = 0.5 * (self.sums + self.products) * both;
        simple.max(self.quotients * quotient + self.roots * root)
    }
}

/// Doubles that one instruction handles at once: AVX2, else SSE2.
pub const WIDE: usize = if cfg!(target_feature = "avx2") { 4 } else { 2 };
/// So many independent chains that no processor has to wait for a result, and so few that its registers hold them twice.
const CHAINS: usize = 6;
type Chains = [Lanes; CHAINS * WIDE / LANES];
/// Rounds over the chains that are timed together, and how often they are timed.
const ROUNDS: usize = 20_000;
const TIMES: usize = 50;

/// Shortest time of one instruction of a round, s.
fn shortest(round: impl Fn(Lanes, &mut Chains, &mut Chains)) -> f64 {
    let once = || {
        let x = black_box(Lanes::constant(1.0));
        let [mut one, mut other]: [Chains; 2] = black_box([[x; CHAINS * WIDE / LANES]; 2]);
        let start = Instant::now();
        for _ in 0..ROUNDS {
            round(x, &mut one, &mut other);
        }
        let took = start.elapsed().as_secs_f64();
        black_box((one, other));
        took / (ROUNDS * CHAINS) as f64
    };
    (0..TIMES).map(|_| once()).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use system_tests::drives;

    use super::*;

    #[test]
    fn an_open_valve_has_four_orifices_a_tick_and_they_have_two_roots_each() {
        let machine = drives::press();
        let initial = InitialState::at_rest(&machine, 0.15);
        // After 0.1 s the spool is out of its dead zone; before, the edges are closed and no root is taken.
        let until = |ticks: usize| {
            let a_tick = Operations::of_a_tick(&machine, &initial, &vec![3.0; ticks]);
            [a_tick.roots, a_tick.products, a_tick.sums].map(|mean| mean * ticks as f64)
        };
        let [before, after] = [until(100), until(150)];
        let [roots, products, sums] = std::array::from_fn(|kind| (after[kind] - before[kind]) / 50.0);
        assert!((roots - 8.0).abs() < 1e-9, "{roots}");
        assert!(products > 50.0 && sums > 50.0, "{products} {sums}");
    }

    #[test]
    fn a_quotient_takes_longer_than_a_product() {
        let only = |products: f64, quotients: f64| Operations { products, quotients, ..Operations::default() };
        assert!(only(0.0, 100.0).floor_s() > only(100.0, 0.0).floor_s());
    }
}
