//! The header of a baked drive's C library, whose functions are those of the crate `drive-c`.
//!
//! Signals are words of fixed point per unit, so that a controller without an FPU converts nothing; the header states what 1 is, in SI units. Nothing but
//! types of fixed width, constants and functions: no macro with arguments, no memory taken.

use std::fmt::{self, Write};

use model_core::machine::{Bases, MachineError, Source};
use model_core::number::PerUnit;

use crate::c99::{constant, quoted};
use crate::rust::{Coefficients, Constants};

/// A word of an input: its name, and what it is.
type Word = (&'static str, String);

impl Constants {
    /// The header of the C library.
    ///
    /// # Errors
    /// As [`Constants::baked`].
    pub fn c_header(&self) -> Result<String, MachineError> {
        let baked = self.coefficients::<PerUnit>()?;
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write_c_header(&baked, &mut text);
        Ok(text)
    }

    fn write_c_header(&self, baked: &Coefficients<PerUnit>, out: &mut impl Write) -> fmt::Result {
        let bases = baked.drive.bases();
        out.write_str(HEAD)?;
        writeln!(out, "/* What the drive is called, UTF-8. */\n#define DRIVE_NAME {}", quoted(&self.name))?;
        writeln!(
            out,
            "/* Checksum of the coefficients: drive_fingerprint() of the library that belongs to this header. */"
        )?;
        writeln!(out, "#define DRIVE_FINGERPRINT (UINT32_C({:#010x}))", baked.fingerprint)?;
        writeln!(
            out,
            "/* Time from one call of drive_step to the next, s. */\n#define DRIVE_TICK_S {}\n",
            constant(bases.tick_s)
        )?;
        writeln!(
            out,
            "/* What 1 is: 2^28 of a word that ends in q28, 2^56 of a position; round to the nearest word. */"
        )?;
        for (name, value) in self.scales(bases) {
            writeln!(out, "#define DRIVE_{name} {}", constant(value))?;
        }
        let words = baked.state_bytes.div_ceil(size_of::<u64>());
        writeln!(out, "\n/* Words of the state. */\n#define DRIVE_STATE_WORDS {words}U\n")?;
        writeln!(
            out,
            "/* State: all that a tick leaves to the next. It may be copied, stored and restored as a whole. */"
        )?;
        writeln!(out, "typedef struct {{\n    uint64_t words[DRIVE_STATE_WORDS];\n}} drive_state_t;\n")?;
        out.write_str(REST)?;
        writeln!(out, "/* Inputs of a tick, held over it. */\ntypedef struct {{")?;
        for (name, what) in self.inputs(baked) {
            writeln!(out, "    int32_t {name}; /* {what} */")?;
        }
        writeln!(out, "}} drive_input_t;\n")?;
        out.write_str(TAIL)
    }

    /// The bases of the drive's words.
    fn scales(&self, bases: &Bases) -> Vec<(&'static str, f64)> {
        let pressure = ("PRESSURE_BASE_PA", bases.pressure_pa);
        let of_source = match self.machine.source {
            Source::Valve => vec![("COMMAND_BASE_V", bases.command_v), pressure],
            Source::Pump => vec![("PUMP_SPEED_BASE_REV_PER_S", bases.pump_speed_rev_per_s), pressure],
            Source::Force => Vec::new(),
        };
        let rod = [
            ("POSITION_BASE_M", bases.stroke_m),
            ("VELOCITY_BASE_M_PER_S", bases.velocity_m_per_s),
            ("FORCE_BASE_N", bases.force_n),
            ("TEMPERATURE_BASE_C", bases.temperature_c),
        ];
        of_source.into_iter().chain(rod).collect()
    }

    /// The words of an input, in the order in which the library reads them.
    fn inputs(&self, baked: &Coefficients<PerUnit>) -> Vec<Word> {
        let load = || ("load_q28", "external force on the rod beside the constant load; positive extends".to_owned());
        let mut words = match self.machine.source {
            Source::Valve => vec![("command_q28", "command to the valve; positive extends".to_owned()), load()],
            Source::Pump => vec![
                ("pump_speed_q28", "speed of the pump; its sign does not count".to_owned()),
                ("valve_direction", "above 0 connects the pump to A, below 0 to B, 0 is closed".to_owned()),
                load(),
            ],
            Source::Force => {
                vec![("force_q28", "force on the mass beside the constant load; positive extends".to_owned())]
            }
        };
        if let Some(reference) = baked.drive.measured_oil() {
            let reference = reference.to_f64() * baked.drive.bases().temperature_c;
            words.push((
                "oil_temperature_q28",
                format!("measured temperature of the oil; the values are for {reference:.1} degrees Celsius"),
            ));
        }
        words
    }
}

const HEAD: &str = "/* A drive for C, written by `host-sim export --bake`: change the machine file and export again.
 *
 * The functions are in the static library of the crate drive-c, built with the Rust source that the same command writes (docs/export.md).
 * Words are signed fixed point per unit: a value is its word / 2^28 * its base. A value beyond the range of +-8 is held there.
 * No function takes memory, waits or stops, and the time of each has a bound. They may be called from an interrupt, but no two at a time with the same state.
 */
#ifndef DRIVE_H
#define DRIVE_H

#include <stdint.h>

#ifdef __cplusplus
extern \"C\" {
#endif

";

const REST: &str = "/* A drive at rest, the command held for long. */
typedef struct {
    int64_t position_q56; /* rod: 0 is fully in, 2^56 fully out */
    int32_t command_q28; /* 0 without a valve */
    int32_t pressure_a_q28;
    int32_t pressure_b_q28;
} drive_rest_t;

/* What the sensors read. */
typedef struct {
    int64_t position_q56; /* rod: 0 is fully in, 2^56 fully out */
    int32_t velocity_q28; /* positive extends */
    int32_t spool_q28; /* 1 is full travel; positive extends; 0 without a valve */
    int32_t pressure_a_q28;
    int32_t pressure_b_q28;
} drive_reading_t;

";

const TAIL: &str = "/* DRIVE_FINGERPRINT of the header that the library belongs to. */
uint32_t drive_fingerprint(void);

/* Sets the state to rest. Nothing is done where a pointer is null, here and below. */
void drive_init(drive_state_t *state, const drive_rest_t *rest);

/* One tick of DRIVE_TICK_S. */
void drive_step(drive_state_t *state, const drive_input_t *input);

/* Reads the sensors of a state. */
void drive_read(const drive_state_t *state, drive_reading_t *reading);

#ifdef __cplusplus
}
#endif

#endif
";
