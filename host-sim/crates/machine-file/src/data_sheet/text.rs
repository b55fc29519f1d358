//! The machine file as text: the origin of every value follows it in a comment.

use std::fmt::Write;

use model_core::machine::Tick;
use recording::files::source_error::{Place, rounded};

use super::derive::{Derived, Origin};
use crate::{MachineFileError, carried, read_text};

/// Comments begin in this column, unless the line before them is longer.
const COMMENTS: usize = 47;

/// The text of a machine file that the program takes. `file` stands for it in messages, `name` is the drive's.
///
/// # Errors
/// A value is impossible, as a mass of 1e30 kg, or the model's shortest step does not compute this drive.
pub fn checked_toml(file: &str, name: &str, made: &Derived) -> Result<String, MachineFileError> {
    let text = toml(name, made);
    let machine = read_text(file, &text)?.machine;
    match carried(&machine, Tick::HalfMillisecond) {
        Ok(()) => Ok(text),
        Err(cause) => Err(MachineFileError::NotCarried { place: Place::file(file), cause }),
    }
}

/// The text of a machine file. `name` is the drive's.
#[must_use]
pub fn toml(name: &str, made: &Derived) -> String {
    let mut text = format!(
        "# Behind every value: given (by data sheet or drawing), derived (from what was given, and how), or assumed (and why).\n\
         # What is assumed is worth finding out; a fit moves it within [fit.sigma].\n\
         name = {}\n",
        toml_edit::Value::from(name)
    );
    let mut table = "";
    for entry in &made.entries {
        if entry.table != table {
            table = entry.table;
            let _ = write!(text, "\n[{table}]\n");
        }
        let numbers: Vec<String> = entry.values.iter().map(|value| number(*value, entry.origin)).collect();
        let value = match numbers.as_slice() {
            [one] => one.clone(),
            several => format!("[{}]", several.join(", ")),
        };
        line(&mut text, &format!("{} = {value}", entry.key), &format!("{}: {}", entry.origin.name(), entry.why));
    }
    text.push_str("\n# Standard deviation of each value that may move, in its own unit. Values not listed are exact.\n[fit.sigma]\n");
    for sigma in &made.sigma {
        let value = format!("{:.1e}", sigma.value).parse().unwrap_or(sigma.value);
        line(&mut text, &format!("\"{}\" = {}", sigma.key, plain(value)), &sigma.why);
    }
    text.push_str(
        "\n# What every installed drive has within its drawing, up to this much: a fit may use it, and it is a finding only beyond.\n[fit.tolerance]\n",
    );
    for tolerance in &made.tolerance {
        let value = format!("{:.1e}", tolerance.value).parse().unwrap_or(tolerance.value);
        line(&mut text, &format!("\"{}\" = {}", tolerance.key, plain(value)), &tolerance.why);
    }
    text.push_str(
        "\n# Where the columns of the recordings have other names, paste the table [channels] that `host-sim inspect` guesses from them, and check it.\n",
    );
    text
}

fn line(text: &mut String, value: &str, comment: &str) {
    let _ = writeln!(text, "{value:<COMMENTS$} # {comment}");
}

/// Given values keep every digit; computed values have six.
fn number(value: f64, origin: Origin) -> String {
    plain(if origin == Origin::Given { format!("{value:.14e}").parse().unwrap_or(value) } else { rounded(value) })
}

/// A number as TOML writes it: with a point or a power of ten.
fn plain(value: f64) -> String {
    format!("{value:?}")
}

#[cfg(test)]
mod tests {
    use model_core::machine::{Parameter, Source};

    use super::*;
    use crate::data_sheet::derive::{Edges, derived};
    use crate::data_sheet::item::{Answers, Item};
    use crate::reader::read_text;

    /// The example of every item, for a drive with a valve or a pump.
    fn examples(pump: bool) -> Answers {
        let mut answers = Answers::default();
        for item in Item::ALL.iter().filter(|item| item.belongs(pump)) {
            answers.insert(*item, item.parse(item.question().example).unwrap());
        }
        answers
    }

    #[test]
    fn what_is_written_is_a_machine_file_and_says_of_every_value_where_it_comes_from() {
        for pump in [false, true] {
            let mut needed = Answers::default();
            if pump {
                needed.insert(Item::PumpDisplacement, Item::PumpDisplacement.parse("16cm3/rev").unwrap());
            }
            for item in needed.missing() {
                needed.insert(item, item.parse(item.question().example).unwrap());
            }
            for answers in [examples(pump), needed] {
                let text = toml("a \"drive\"", &derived(&answers, Edges::Edge).unwrap());
                let file = read_text("machine.toml", &text).unwrap();
                file.machine.check().unwrap();
                assert_eq!(file.name, "a \"drive\"");
                assert_eq!(file.machine.source, if pump { Source::Pump } else { Source::Valve });
                assert!(file.sigma.contains_key(&Parameter::BulkModulus));
                let values = text.lines().filter(|line| line.contains(" = ") && !line.starts_with(['#', '"', 'n']));
                for line in values {
                    let why = line.split_once("# ").unwrap().1;
                    let kinds = ["given: ", "derived: ", "assumed: "];
                    assert!(kinds.iter().any(|kind| why.starts_with(kind) && why.len() > kind.len()), "{line}");
                }
            }
        }
    }

    #[test]
    fn what_was_given_stands_in_the_file_as_it_was_meant() {
        let text = toml("press", &derived(&examples(false), Edges::Edge).unwrap());
        assert!(text.contains("stroke_m = 0.3 ") && text.contains("# given: 300 mm"), "{text}");
        assert!(text.contains("pressure_pa = 7000000.0 "), "{text}");
        assert!(text.contains("moving_mass_kg = 18.3 "), "{text}");
    }
}
