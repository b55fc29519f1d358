//! The same constants as a C99 header, for a controller that is written in C.
//!
//! Macros of SI values, each as a hexadecimal floating constant that the compiler reads back bit for bit, with the
//! decimal number beside it. C code has no access to the defaults, so the header holds every value that the drive uses, and for every
//! effect whether it is on. The fixed-point coefficients are not included: they are private to the core, and only the core knows their
//! formats.

use std::fmt::{self, Write};

use machine_file::MachineFile;
use machine_file::keys::{effect_of, table_of};
use model_core::machine::{Parameter, Source};

use crate::rust::Constants;

impl Constants {
    /// A C99 header.
    #[must_use]
    pub fn c99(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write_c99(&mut text);
        text
    }

    fn write_c99(&self, out: &mut impl Write) -> fmt::Result {
        let file = MachineFile::from_machine(&self.name, self.machine);
        writeln!(
            out,
            "/* Constants of a drive, written by `host-sim export`: change the machine file and export again. SI units. */\n"
        )?;
        writeln!(out, "#ifndef DRIVE_CONSTANTS_H\n#define DRIVE_CONSTANTS_H\n")?;
        let used = || Parameter::ALL.iter().filter(|&&parameter| parameter.is_of(self.machine.source));
        if used().any(|&parameter| self.machine.get(parameter).is_infinite()) {
            writeln!(out, "#include <math.h> /* INFINITY */\n")?;
        }
        let is = |source| u8::from(self.machine.source == source);
        writeln!(out, "/* What the drive is called, UTF-8. */\n#define DRIVE_NAME {}", quoted(&self.name))?;
        writeln!(out, "/* Where its oil comes from; none where a force moves the mass. */")?;
        writeln!(out, "#define DRIVE_SOURCE_VALVE {}", is(Source::Valve))?;
        writeln!(out, "#define DRIVE_SOURCE_PUMP {}", is(Source::Pump))?;
        writeln!(out, "#define DRIVE_SOURCE_FORCE {}", is(Source::Force))?;
        writeln!(out, "/* Control period that the values were checked for, s. */")?;
        writeln!(out, "#define DRIVE_TICK_S {}", constant(self.tick.seconds()))?;
        writeln!(out, "/* Ticks of the shortest delay line that holds its delays: a power of two. */")?;
        writeln!(out, "#define DRIVE_DELAY_LINE {}", self.delay_line)?;
        let mut table = "";
        for &parameter in used() {
            let description = parameter.description();
            let effect = effect_of(table_of(parameter));
            let on = effect.is_none_or(|effect| file.effects.contains(effect));
            if table_of(parameter) != table {
                table = table_of(parameter);
                writeln!(out, "\n/* [{table}] */")?;
                if let Some(effect) = effect {
                    writeln!(out, "#define DRIVE_EFFECT_{} {}", identifier(effect), u8::from(on))?;
                }
            }
            if on {
                writeln!(out, "/* {}, {}: {} */", description.key, description.unit, description.meaning)?;
                writeln!(
                    out,
                    "#define DRIVE_{} {}",
                    identifier(description.key.trim_start_matches("effects.")),
                    constant(self.machine.get(parameter))
                )?;
            }
        }
        writeln!(out, "\n#endif")
    }
}

/// A key in the form used in the name of a macro: `valve.time_constants_s[0]` is `VALVE_TIME_CONSTANTS_S_0`.
fn identifier(key: &str) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_uppercase() } else { '_' };
    key.trim_end_matches(']').chars().map(letter).collect()
}

/// A string literal. Bytes other than plain ASCII become octal escapes, which end after three digits; a question mark is
/// escaped, because two of them would begin a trigraph.
pub(crate) fn quoted(text: &str) -> String {
    let mut literal = String::from("\"");
    for byte in text.bytes() {
        match byte {
            b'"' | b'\\' | b'?' => literal.extend(['\\', char::from(byte)]),
            b' '..=b'~' => literal.push(char::from(byte)),
            // Writing to a string cannot fail.
            other => drop(write!(literal, "\\{other:03o}")),
        }
    }
    literal.push('"');
    literal
}

/// A floating constant of C99 with its decimal number in a comment; a negative number stands in brackets.
pub(crate) fn constant(value: f64) -> String {
    let bare = hexadecimal(value.abs());
    let signed = if value.is_sign_negative() { format!("(-{bare})") } else { bare };
    format!("{signed} /* {value:?} */")
}

/// A number that is not negative, exact to the last bit: 24 is `0x1.8p+4`.
fn hexadecimal(value: f64) -> String {
    const FRACTION_BITS: u32 = 52;
    const BIAS: i64 = 1023;
    if value.is_infinite() {
        return "INFINITY".to_owned();
    }
    let bits = value.to_bits();
    let fraction = bits & ((1 << FRACTION_BITS) - 1);
    #[expect(clippy::cast_possible_wrap, reason = "eleven bits")]
    let (lead, exponent) = match (bits >> FRACTION_BITS) as i64 {
        0 if fraction == 0 => (0, 0),
        0 => (0, 1 - BIAS),
        biased => (1, biased - BIAS),
    };
    let digits = format!("{fraction:013x}");
    let digits = digits.trim_end_matches('0');
    let point = if digits.is_empty() { "" } else { "." };
    format!("0x{lead}{point}{digits}p{exponent:+}")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn a_number_is_written_bit_for_bit() {
        let cases = [
            (0.0, "0x0p+0"),
            (24.0, "0x1.8p+4"),
            (0.1, "0x1.999999999999ap-4"),
            (f64::from_bits(3), "0x0.0000000000003p-1022"),
            (f64::MAX, "0x1.fffffffffffffp+1023"),
            (f64::INFINITY, "INFINITY"),
        ];
        for (value, text) in cases {
            assert_eq!(hexadecimal(value), text);
        }
        assert_eq!(constant(-1.5), "(-0x1.8p+0) /* -1.5 */");
    }

    #[test]
    fn a_name_cannot_leave_its_literal() {
        assert_eq!(quoted("a \"b\" \\ ??/ ü\n"), "\"a \\\"b\\\" \\\\ \\?\\?/ \\303\\274\\012\"");
    }

    #[test]
    fn macros_have_names_of_their_own_that_every_compiler_tells_apart() {
        let names: BTreeSet<String> =
            Parameter::ALL.iter().map(|p| identifier(p.description().key.trim_start_matches("effects."))).collect();
        assert_eq!(names.len(), Parameter::ALL.len());
        assert!(names.contains("VALVE_TIME_CONSTANTS_S_0"));
        // C99 5.2.4.1: 63 significant initial characters.
        assert!(names.iter().all(|name| name.len() + "DRIVE_".len() <= 63), "{names:?}");
    }
}
