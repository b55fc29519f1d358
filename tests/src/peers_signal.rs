//! The random steps under which other programs for the same drive are compared with ours, tick by tick.
//!
//! The definition is theirs, `_random` in `common.py` of the peers' folder: 4 s at 1 kHz; from 0.1 s on steps that are held for 80 to 500 ms,
//! of ±10 V, drawn by `numpy.random.default_rng(1).uniform`. That is the generator PCG64 and a `f64` of its upper 53 bits.

use rand_core::Rng;
use rand_pcg::Pcg64;

/// State and stream that `NumPy` seeds the generator with: `SeedSequence(1).generate_state(4, numpy.uint64)`, two words each.
const STATE: u128 = 0x672d_8ee5_6d67_91ff_8ae1_9ca1_4eb1_072c;
const STREAM: u128 = 0x4915_796d_1322_fc4a_d0cc_2bdc_aba0_49bd;

/// Ticks of 1 ms, of which the first hundred are at rest.
const TICKS: usize = 4000;
const AT_REST: usize = 100;
/// Range of a command, V.
const VOLTS: f64 = 10.0;
/// Shortest and longest time for which a command is held, s.
const HELD: [f64; 2] = [0.08, 0.5];
const TICK_S: f64 = 1e-3;

/// The commands, V, one a tick.
#[must_use]
pub fn random() -> Vec<f32> {
    let mut generator = Pcg64::new(STATE, STREAM);
    let mut uniform = |low: f64, high: f64| {
        let share = (generator.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        low + (high - low) * share
    };
    let mut volts = vec![0.0; AT_REST];
    while volts.len() < TICKS {
        let [shortest, longest] = HELD;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most 500 ticks, cut off as theirs"
        )]
        let held = (uniform(shortest, longest) / TICK_S) as usize;
        #[expect(clippy::cast_possible_truncation, reason = "theirs are single precision")]
        let command = uniform(-VOLTS, VOLTS) as f32;
        volts.extend(std::iter::repeat_n(command, held));
    }
    volts.truncate(TICKS);
    volts
}
