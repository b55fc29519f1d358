//! Recordings that cannot be worked on together, or not with a machine file.

use diagnosis::agreement::{Doubt, doubts};
use diagnosis::base_parameters;
use machine_file::MachineFile;
use recording::Recording;

use super::Refused;
use crate::wording;

/// What is doubtful about recordings for this drive, whose machine file is called `name`. What is certainly wrong is refused, unless they are to be taken
/// as they are; `otherwise` says how that is asked for.
///
/// # Errors
/// The recordings are certainly not those of this drive, or cannot be compared with it.
pub fn checked_doubts(
    (name, file): (&str, &MachineFile),
    recordings: &[&Recording],
    as_recorded: bool,
    otherwise: &str,
) -> Result<Vec<Doubt>, Refused> {
    let found = doubts(file, &base_parameters(file), recordings);
    let found = found.map_err(|cause| Refused::machine(name, cause))?;
    let certain: Vec<String> = found.iter().filter(|doubt| doubt.is_certain).map(wording::doubt).collect();
    if certain.is_empty() || as_recorded {
        return Ok(found);
    }
    let text = format!(
        "the recordings do not fit {name}: {}; expected recordings of this drive: mend the channel (a sensor's `zero` and `full` in [channels] turn \
         and scale it) or the machine file, or {otherwise}",
        certain.join("; ")
    );
    Err(Refused::of(text).in_file(name))
}

/// Checks that no recording that was held out is one of those that are fitted to. One that is fitted to may be given twice, to count twice.
///
/// # Errors
/// One of them is.
pub fn check_held_out(training: &[Recording], held_out: &[Recording]) -> Result<(), Refused> {
    let Some((first, second)) = Recording::trained_on(training, held_out) else { return Ok(()) };
    Err(the_same(first, second, "held-out recordings that are not trained on"))
}

/// Checks that a diagnosis gets each recording once: it cannot confirm effects that it was used to choose, whatever its name, even as a copy.
///
/// # Errors
/// Two are the same.
pub fn check_distinct(training: &[Recording], held_out: &[Recording]) -> Result<(), Refused> {
    let all: Vec<&Recording> = training.iter().chain(held_out).collect();
    let Some((first, second)) = Recording::held_twice(&all) else { return Ok(()) };
    Err(the_same(all[first], all[second], "each once"))
}

fn the_same(first: &Recording, second: &Recording, expected: &str) -> Refused {
    let (first, second) = (first.path(), second.path());
    Refused::of(format_args!("{first} and {second} hold the same recording; expected {expected}")).in_file(second)
}
