//! Questions on a terminal for the entries of a data sheet.

use std::io;

use dialoguer::{Input, Select};

use machine_file::data_sheet::{Answers, Item, Need, Quantity};

use super::error::CliError;

/// Asks for every item that is not answered yet and that the drive may have.
pub(crate) fn ask(answers: &mut Answers) -> Result<(), CliError> {
    let is_valve = Item::ALL.iter().any(|item| !item.belongs(true) && answers.get(*item).is_some());
    let pump = if answers.is_pump() || is_valve { answers.is_pump() } else { asked_for_pump()? };
    asked(answers, pump, &mut |item| {
        let question = item.question();
        let (prompt, optional) = match question.need {
            Need::Always | Need::OfValve | Need::MakesPump => {
                (format!("{} ({})", question.what, question.example), false)
            }
            Need::OneOf(_) => (format!("{} ({}; empty: not known)", question.what, question.example), true),
            Need::May(otherwise) | Need::MayOfValve(otherwise) => {
                (format!("{} ({}; empty: {otherwise})", question.what, question.example), true)
            }
        };
        let valid = move |text: &String| match text.trim() {
            "" if optional => Ok(()),
            text => item.parse(text).map(drop),
        };
        let text: String = Input::new()
            .with_prompt(prompt)
            .allow_empty(optional)
            .validate_with(valid)
            .interact_text()
            .map_err(|error| stopped(error.into()))?;
        Ok(item.parse(&text).ok())
    })
}

/// Asks one question after the other; an empty answer leaves the item out.
fn asked(
    answers: &mut Answers,
    pump: bool,
    answer: &mut dyn FnMut(Item) -> Result<Option<Quantity>, CliError>,
) -> Result<(), CliError> {
    for &item in Item::ALL {
        // A hose has a diameter only where it has a length.
        let no_hose = item == Item::HoseDiameter && answers.get(Item::HoseLength).is_none();
        if item.belongs(pump)
            && answers.get(item).is_none()
            && !no_hose
            && let Some(quantity) = answer(item)?
        {
            answers.insert(item, quantity);
        }
    }
    Ok(())
}

fn asked_for_pump() -> Result<bool, CliError> {
    let choice = Select::new()
        .with_prompt("What feeds the cylinder?")
        .items(["a servo or proportional valve", "a pump, directly"])
        .default(0)
        .interact()
        .map_err(|error| stopped(error.into()))?;
    Ok(choice == 1)
}

/// Ctrl-C at a question stops the program as anywhere else.
fn stopped(error: io::Error) -> CliError {
    if error.kind() == io::ErrorKind::Interrupted { CliError::Interrupted } else { CliError::Input(error) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_open_and_belongs_to_the_drive_is_asked_for() {
        let mut answers = Answers::default();
        answers.insert(Item::Bore, Item::Bore.parse("63mm").unwrap());
        let mut seen = Vec::new();
        asked(&mut answers, true, &mut |item| {
            seen.push(item);
            Ok(item.parse(item.question().example).ok())
        })
        .unwrap();
        assert!(!seen.contains(&Item::Bore) && !seen.contains(&Item::RatedFlow), "{seen:?}");
        assert!(seen.contains(&Item::PumpDisplacement) && seen.contains(&Item::HoseDiameter), "{seen:?}");
        assert!(answers.missing().is_empty());
    }

    #[test]
    fn without_a_hose_nobody_asks_how_wide_it_is() {
        let mut seen = Vec::new();
        let none = &mut |item| {
            seen.push(item);
            Ok(None)
        };
        asked(&mut Answers::default(), false, none).unwrap();
        assert!(seen.contains(&Item::HoseLength) && !seen.contains(&Item::HoseDiameter), "{seen:?}");
    }
}
