//! A planned excitation as the firmware plays it: words for the reference model, and how far and fast this model goes with them.
//!
//! The words are the plan's voltages, rounded to the firmware's step, with the neutral voltage after them until the model rests. The model is the
//! firmware's own, and reads them by the firmware's own code.

use std::fmt::{self, Write};

use firmware::control::Reference;
use firmware::excitation::PlanError;
use firmware::excitation::plan::{Piece, Plan, PlayState, fingerprint};
use model_core::control::{FollowError, Follower, Tuning};
use model_core::machine::{Machine, MachineError, Parameter, Tick};
use model_core::number::PerUnit;
use simulation::DELAY_LINE;

/// One step of a word, V.
pub const STEP_V: f64 = 10.0 / 32_768.0;
/// From so many equal rows on, their number takes less room than the rows.
const RUN: usize = 12;
/// Most rows of a piece, whose number has 16 bits.
const MOST_ROWS: usize = 60_000;
/// Words in a line of the source.
const IN_A_LINE: usize = 20;
/// The model rests below this velocity, m/s.
const RESTS_M_PER_S: f64 = 5e-5;
/// Time at neutral in which it must come to rest, s.
const REST_WITHIN_S: f64 = 2.0;
/// The plan is simulated at this tick.
const TICK: Tick = Tick::OneMillisecond;

/// A plan for the firmware.
#[derive(Clone, Debug, PartialEq)]
pub struct Played {
    /// Name of the machine.
    pub name: String,
    /// What tells its values from others.
    pub fingerprint: u32,
    /// Length of a row, µs.
    pub row_us: u32,
    /// Voltages, in steps of [`STEP_V`]: those of the plan, and the rest after it.
    pub words: Vec<i16>,
    /// Where the rod stands at the start, m.
    pub start_m: f64,
    /// Where the model's rod goes, m.
    pub reach_m: [f64; 2],
    /// Its largest velocity, either way, m/s.
    pub fastest_m_per_s: f64,
}

/// Why the firmware cannot play an excitation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlayedError {
    /// A voltage is larger than a word holds.
    #[error("{volts} V in row {row}: expected at most 10 V, as the output of the firmware gives")]
    Volts {
        /// The first such row.
        row: usize,
        /// Its voltage.
        volts: f64,
    },
    /// The rod goes on.
    #[error(
        "the model still moves at {m_per_s} m/s, {REST_WITHIN_S} s after the end of the plan; expected a drive that rests at its neutral voltage"
    )]
    Moves {
        /// How fast.
        m_per_s: f64,
    },
    /// Fixed point cannot hold the drive.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// It cannot be controlled.
    #[error(transparent)]
    Follow(#[from] FollowError),
    /// The rows do not fit the tick.
    #[error(transparent)]
    Rows(#[from] PlanError),
}

/// The word nearest to a voltage.
fn word(row: usize, volts: f64) -> Result<i16, PlayedError> {
    // NaN fails this comparison.
    if !(-10.0..=10.0).contains(&volts) {
        return Err(PlayedError::Volts { row, volts });
    }
    #[expect(clippy::cast_possible_truncation, reason = "a cast holds 10 V at the end of the format")]
    let word = (volts / STEP_V).round() as i16;
    Ok(word)
}

impl Played {
    /// The excitation of this drive with these voltages, one for each row of `interval_s`.
    ///
    /// # Errors
    /// The firmware cannot play it.
    pub fn of(name: &str, machine: &Machine<f64>, interval_s: f64, command_v: &[f64]) -> Result<Self, PlayedError> {
        let words = command_v.iter().enumerate().map(|(row, &volts)| word(row, volts));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an interval of some ms")]
        let row_us = (1e6 * interval_s).round() as u32;
        let mut played = Self {
            name: name.to_owned(),
            fingerprint: fingerprint(machine),
            row_us,
            words: words.collect::<Result<_, _>>()?,
            start_m: 0.5 * machine.get(Parameter::Stroke),
            reach_m: [0.0; 2],
            fastest_m_per_s: 0.0,
        };
        let neutral: PerUnit = Follower::new(machine, &Tuning::by_rule(machine, true), TICK)?.neutral();
        let neutral = word(played.words.len(), 10.0 * neutral.to_f64())?;
        played.run(Reference::at_rest(machine, TICK, 0.5)?, neutral)?;
        Ok(played)
    }

    /// Lets the model play it, and come to rest.
    fn run(&mut self, mut model: Reference<DELAY_LINE>, neutral: i16) -> Result<(), PlayedError> {
        let (stroke_m, base_m_per_s) = (model.bases().stroke_m, model.bases().velocity_m_per_s);
        let mut reach_m = [self.start_m; 2];
        let (mut fastest, mut speed) = (0.0_f64, 0.0_f64);
        let planned = self.words.clone();
        let mut play = |words: &[i16]| -> Result<f64, PlayedError> {
            let pieces = [Piece::Rows(words)];
            let (play, mut state) = (self.plan(&pieces).by(TICK.seconds())?, PlayState::default());
            while let Some(command) = play.step(&mut state) {
                let predicted = model.step(command);
                let position_m = predicted.position.to_f64() * stroke_m;
                reach_m = [reach_m[0].min(position_m), reach_m[1].max(position_m)];
                speed = predicted.velocity.to_f64().abs() * base_m_per_s;
                fastest = fastest.max(speed);
            }
            Ok(speed)
        };
        planned.chunks(MOST_ROWS).try_for_each(|words| play(words).map(drop))?;
        // A tenth of a second at a time.
        let rest = vec![neutral; (100_000 / self.row_us.max(1)).max(1) as usize];
        let mut rests = 0;
        loop {
            let m_per_s = play(&rest)?;
            rests += 1;
            if m_per_s < RESTS_M_PER_S {
                break;
            }
            if 0.1 * f64::from(rests) >= REST_WITHIN_S {
                return Err(PlayedError::Moves { m_per_s });
            }
        }
        (self.reach_m, self.fastest_m_per_s) = (reach_m, fastest);
        (0..rests).for_each(|_| self.words.extend(&rest));
        Ok(())
    }

    /// As the firmware has it.
    fn plan<'a>(&'a self, pieces: &'a [Piece<'a>]) -> Plan<'a> {
        let largest = self.words.iter().map(|word| word.unsigned_abs()).max().unwrap_or(0);
        Plan {
            machine: &self.name,
            fingerprint: self.fingerprint,
            row_us: self.row_us,
            largest_v: STEP_V * f64::from(largest),
            start_m: self.start_m,
            from_m: self.reach_m[0],
            to_m: self.reach_m[1],
            fastest_m_per_s: self.fastest_m_per_s,
            pieces,
        }
    }

    /// The rows as pieces: long runs of the same word by their number.
    fn pieces(&self) -> Vec<Piece<'_>> {
        let mut pieces = Vec::new();
        let (mut from, mut at) = (0, 0);
        while at < self.words.len() {
            let same = self.words[at..].iter().take_while(|&&word| word == self.words[at]).count();
            let run = same.min(MOST_ROWS);
            if run >= RUN {
                pieces.extend(self.words[from..at].chunks(MOST_ROWS).map(Piece::Rows));
                pieces.push(Piece::Held(u16::try_from(run).unwrap_or(u16::MAX), self.words[at]));
                from = at + run;
            }
            at += run;
        }
        pieces.extend(self.words[from..].chunks(MOST_ROWS).map(Piece::Rows));
        pieces
    }

    /// Rust source, for `FIRMWARE_PLAN`.
    #[must_use]
    pub fn rust(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, out: &mut impl Write) -> fmt::Result {
        let pieces = self.pieces();
        let Plan { machine, fingerprint, row_us, largest_v, start_m, from_m, to_m, fastest_m_per_s, .. } =
            self.plan(&pieces);
        let [upper, lower] = [fingerprint >> 16, fingerprint & 0xffff];
        writeln!(
            out,
            "// A planned excitation, written by `host-sim plan --firmware`: plan again rather than change it.\n"
        )?;
        writeln!(out, "use firmware::excitation::plan::{{Piece, Plan}};\n")?;
        writeln!(out, "/// The voltages, and what the model does with them.\n#[rustfmt::skip]")?;
        writeln!(out, "#[allow(clippy::unreadable_literal, reason = \"every digit of a written value counts\")]")?;
        writeln!(out, "pub const PLAN: Plan<'static> = Plan {{")?;
        writeln!(out, "    machine: {machine:?},\n    fingerprint: 0x{upper:04x}_{lower:04x},\n    row_us: {row_us},")?;
        writeln!(
            out,
            "    largest_v: {largest_v:?},\n    start_m: {start_m:?},\n    from_m: {from_m:?},\n    to_m: {to_m:?},"
        )?;
        writeln!(out, "    fastest_m_per_s: {fastest_m_per_s:?},\n    pieces: &[")?;
        for piece in &pieces {
            match piece {
                Piece::Held(rows, word) => writeln!(out, "        Piece::Held({rows}, {word}),")?,
                Piece::Rows(words) => {
                    writeln!(out, "        Piece::Rows(&[")?;
                    for line in words.chunks(IN_A_LINE) {
                        let line: Vec<String> = line.iter().map(i16::to_string).collect();
                        writeln!(out, "            {},", line.join(", "))?;
                    }
                    writeln!(out, "        ]),")?;
                }
            }
        }
        writeln!(out, "    ],\n}};")
    }
}

#[cfg(test)]
mod tests {
    use firmware::app::press;

    use super::*;

    fn played(words: Vec<i16>) -> Played {
        let press = Played::of("press", &press::machine(), 2e-3, &[0.0, 1.0]).unwrap();
        Played { words, ..press }
    }

    #[test]
    fn pieces_of_any_length_are_the_words_in_their_order() {
        let long = (0..70_000).map(|row| i16::try_from(row % 7).unwrap());
        let mut words: Vec<i16> = [-3; 11].into_iter().chain([9; 12]).chain(long).collect();
        words.extend(std::iter::repeat_n(5, 130_000).chain([1]));
        let played = played(words.clone());
        let pieces = played.pieces();
        let held = pieces.iter().filter(|piece| matches!(piece, Piece::Held(..))).count();
        assert_eq!((pieces.len(), held), (8, 4), "{:?}", pieces.len());
        let (play, mut along) = (played.plan(&pieces).by(2e-3).unwrap(), PlayState::default());
        let found = std::iter::from_fn(|| play.step(&mut along)).map(|command| i16::try_from(command.to_bits() >> 13));
        assert!(found.map(Result::unwrap).eq(words));
    }

    #[test]
    fn a_drive_that_does_not_rest_at_neutral_and_a_voltage_beyond_the_output_are_refused() {
        let press = press::machine();
        for (volts, row) in [(10.01, 1), (f64::NAN, 1)] {
            let refused = Played::of("press", &press, 2e-3, &[0.0, volts]).unwrap_err();
            assert!(matches!(refused, PlayedError::Volts { row: found, .. } if found == row), "{refused}");
        }
        // A valve that leaks under a load lets the rod creep for ever.
        let creeping = press.with(&[
            (Parameter::LoadForce, 8000.0),
            (Parameter::ValveLeakageOpening, 0.1),
            (Parameter::ValveLeakageReach, 0.1),
        ]);
        let refused = Played::of("press", &creeping, 2e-3, &[0.0; 100]).unwrap_err();
        assert!(matches!(refused, PlayedError::Moves { m_per_s } if m_per_s > RESTS_M_PER_S), "{refused}");
    }
}
