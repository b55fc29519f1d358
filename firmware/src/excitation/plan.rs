//! A planned excitation: the voltages that `host-sim plan` finds, for the reference model.
//!
//! They drive the model in place of a set point ([`Period::play`](crate::period::Period::play)), and the loops make the machine do what the model does: so the
//! valve gets the plan and small corrections, and a rod that does otherwise than planned is told by the same limits as always.
//!
//! ```text
//! word     16 bits, 10 V/2¹⁵ a step: a voltage of the plan rounded to nearest, within 0.16 mV
//! row      a whole number of ticks, in which a voltage is held
//! ```
//!
//! The plan states from where it begins and how far and fast the model then goes, as the planner found by this model: it is refused before the rod moves where
//! that does not fit.

use crc::{CRC_32_ISO_HDLC, Crc, Table};
use model_core::machine::{Bases, Machine, Parameter};
use model_core::number::PerUnit;

use super::refused::PlanError;
use crate::set_point::Bounds;

/// Farthest from the place where the plan begins that the rod may stand, m.
pub const START_WITHIN_M: f64 = 5e-3;

/// Some rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Piece<'a> {
    /// So many rows of one word.
    Held(u16, i16),
    /// Rows of a word each.
    Rows(&'a [i16]),
}

/// A plan, as `host-sim plan --firmware` writes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan<'a> {
    /// Name of the machine.
    pub machine: &'a str,
    /// [`fingerprint`] of its values.
    pub fingerprint: u32,
    /// Length of a row, µs.
    pub row_us: u32,
    /// Largest voltage, V.
    pub largest_v: f64,
    /// Where the rod stands at the start, m.
    pub start_m: f64,
    /// Least position of the model, m.
    pub from_m: f64,
    /// Largest position of the model, m.
    pub to_m: f64,
    /// Largest velocity of the model, either way, m/s.
    pub fastest_m_per_s: f64,
    /// The voltages.
    pub pieces: &'a [Piece<'a>],
}

/// What a plan may do: the machine that it moves, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Permitted {
    /// [`fingerprint`] of the machine.
    pub fingerprint: u32,
    /// What 1 per unit stands for.
    pub bases: Bases,
    /// Where the rod may go, and how fast; at this acceleration it comes to rest.
    pub bounds: Bounds,
    /// Largest command, V.
    pub most_v: f64,
}

/// A plan that may be played here: configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Play<'a> {
    pieces: &'a [Piece<'a>],
    ticks_per_row: u32,
}

/// How far a plan has got.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PlayState {
    piece: usize,
    /// Row within the piece, and tick within the row.
    row: u16,
    tick: u32,
}

/// CRC-32 of the values that are not the default: what tells a machine from others.
#[must_use]
pub fn fingerprint(machine: &Machine<f64>) -> u32 {
    const CRC: Crc<u32, Table<0>> = Crc::<u32, Table<0>>::new(&CRC_32_ISO_HDLC);
    let default = Machine::with_defaults(machine.source);
    let mut digest = CRC.digest();
    for &parameter in Parameter::ALL {
        let bits = machine.get(parameter).to_bits();
        if bits != default.get(parameter).to_bits() {
            digest.update(parameter.description().key.as_bytes());
            digest.update(&bits.to_le_bytes());
        }
    }
    digest.finalize()
}

impl<'a> Plan<'a> {
    /// The plan, to be played with the rod at `from`, a share of the stroke.
    ///
    /// # Errors
    /// It is for another machine, begins elsewhere or does not fit: the error says what was found and what is expected.
    pub fn at(&self, from: PerUnit, permitted: &Permitted) -> Result<Play<'a>, PlanError> {
        let Permitted { fingerprint: expected, bases, bounds, most_v } = *permitted;
        let Self { fingerprint: found, largest_v, start_m, fastest_m_per_s, .. } = *self;
        if found != expected {
            return Err(PlanError::Machine { found, expected });
        }
        let play = self.by(bases.tick_s)?;
        // NaN fails each comparison.
        if !(0.0..=most_v).contains(&largest_v) {
            return Err(PlanError::Command { largest_v, most_v });
        }
        if !(0.0..=bounds.velocity_m_per_s).contains(&fastest_m_per_s) {
            return Err(PlanError::Velocity { fastest_m_per_s, most_m_per_s: bounds.velocity_m_per_s });
        }
        let rod_m = from.to_f64() * bases.stroke_m;
        let away_m = rod_m - start_m;
        if !(-START_WITHIN_M..=START_WITHIN_M).contains(&away_m) {
            return Err(PlanError::Start { rod_m, start_m, within_m: START_WITHIN_M });
        }
        let stop_m = fastest_m_per_s * fastest_m_per_s / (2.0 * bounds.acceleration_m_per_s2);
        let (from_m, to_m) = (self.from_m + away_m - stop_m, self.to_m + away_m + stop_m);
        if from_m >= bounds.from_m && to_m <= bounds.to_m {
            Ok(play)
        } else {
            Err(PlanError::Range { from_m, to_m, least_m: bounds.from_m, most_m: bounds.to_m })
        }
    }

    /// The plan for a model of this tick, whatever the machine.
    ///
    /// # Errors
    /// A row is not a whole number of ticks.
    pub fn by(&self, tick_s: f64) -> Result<Play<'a>, PlanError> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "two milliseconds at most")]
        let tick_us = libm::round(1e6 * tick_s) as u32;
        let ticks_per_row = self.row_us.checked_div(tick_us).unwrap_or(0);
        if ticks_per_row == 0 || ticks_per_row * tick_us != self.row_us {
            return Err(PlanError::Rows { row_us: self.row_us, tick_us });
        }
        Ok(Play { pieces: self.pieces, ticks_per_row })
    }
}

impl Piece<'_> {
    /// The word of a row, if it has so many.
    fn word(&self, row: u16) -> Option<i16> {
        match self {
            Self::Held(rows, word) => (row < *rows).then_some(*word),
            Self::Rows(words) => words.get(usize::from(row)).copied(),
        }
    }
}

impl Play<'_> {
    /// The command of this period, in units of 10 V, for the model; `None` after the end.
    pub fn step(&self, state: &mut PlayState) -> Option<PerUnit> {
        let word = loop {
            match self.pieces.get(state.piece)?.word(state.row) {
                Some(word) => break word,
                None => *state = PlayState { piece: state.piece + 1, ..PlayState::default() },
            }
        };
        state.tick += 1;
        if state.tick >= self.ticks_per_row {
            (state.row, state.tick) = (state.row.saturating_add(1), 0);
        }
        Some(PerUnit::from_bits(i32::from(word) << 13))
    }

    /// Whether it has ended.
    #[must_use]
    pub fn is_done(&self, state: &PlayState) -> bool {
        self.step(&mut state.clone()).is_none()
    }
}

#[cfg(test)]
mod tests;
