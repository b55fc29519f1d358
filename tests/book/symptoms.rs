//! The table from what people see at a machine to what it may be and to the test that shows it.

use std::fmt::Write;

use diagnosis::catalogue::CATALOGUE;
use model_core::effects::Effect;
use report::wording::{capital, cause};
use system_tests::snapshot;

const HEAD: &str = "\
# Symptom, cause, test

What somebody sees beside the machine, what it may be, and what to do: check the part first, or record the test and let `diagnose` decide. One symptom has
several causes; the test is the one that tells this cause from the others. [The standard tests](plan.md) are short commands that anyone can give.

*The tables of effects are written by `RENEW=1 cargo test -p system-tests --test book symptoms`.*

## It is not always the drive

Look here first: these are cheap to check, and `inspect` or `diagnose` says them of a recording.

| seen in the recording | cause | what to do |
|---|---|---|
| a signal runs the other way, or is wrong by a factor of 10, 100, 1000 | wires or ports exchanged, another unit | `diagnose` tries it before any physics and says which; mend the unit in the header or by `--map`, a sign by `zero` and `full` in `[channels]` |
| a signal stands at one highest or lowest value | the sensor's or the logger's range ends there | a larger range; the rows there are left out and reported |
| both pressures are 1 bar too high | they are absolute, not gauge | `pressure = \"absolute\"` in `[channels]` |
| everything comes late by the same time | clocks of two loggers | one clock, or record the command with the same logger |
| an error that happens once | a push, a collision, somebody at the machine | record again; `diagnose` reports it as a disturbance with its time |
| an error with one frequency, whatever the drive does | a structure that rings, another machine, ripple of the pump | `diagnose` tells the frequency; look for who has it |
";

/// How a cell may name several words of a table: the bar ends a cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

#[test]
fn the_table_of_symptoms_is_that_of_the_code() {
    let mut text = HEAD.to_owned();
    let mut link = String::new();
    for effect in CATALOGUE {
        let told = cause(Effect::named(effect.name).unwrap());
        if link != effect.subsystem.to_string() {
            link = effect.subsystem.to_string();
            writeln!(text, "\n## In the {link}\n\n| seen | cause | check | test |\n|---|---|---|---|").unwrap();
        }
        let name = format!("[{0}](effects.md#{0})", effect.name);
        let [seen, happens] = [told.seen, told.happens].map(|said| cell(&capital(said)));
        writeln!(text, "| {seen} | {happens}: {name} | {} | {} |", cell(told.check), cell(effect.separated_by))
            .unwrap();
    }
    snapshot::compare("../docs/symptoms.md", &text, |found, kept| found == kept);
}
