//! A machine file from a filled form.

use std::collections::BTreeMap;

use machine_file::data_sheet::{Answers, Edges, Item, Need, checked_toml, derived};
use report::refused::Refused;
use serde::Deserialize;
use serde_json::{Value, json};

/// A filled form: texts with units, by the names of their items.
#[derive(Debug, Deserialize)]
pub(crate) struct Form {
    name: String,
    /// Whether the rated pressure drop stands over both edges in series.
    over_both_edges: bool,
    answers: BTreeMap<String, String>,
}

/// The items of a data sheet: the table of `init`.
pub(crate) fn questions() -> Value {
    let question = |item: &Item| {
        let question = item.question();
        let (need, otherwise) = match question.need {
            Need::Always => ("required", None),
            Need::OfValve => ("required for a valve", None),
            Need::MakesPump => ("required for a pump", None),
            Need::OneOf(_) => ("one of these is required for a valve", None),
            Need::May(otherwise) | Need::MayOfValve(otherwise) => ("optional", Some(otherwise)),
        };
        json!({
            "flag": question.flag, "what": question.what, "example": question.example, "need": need, "otherwise": otherwise,
            "of_valve": item.belongs(false), "of_pump": item.belongs(true),
        })
    };
    Item::ALL.iter().map(question).collect()
}

/// The text of the machine file; one that could not be read back is an error.
pub(crate) fn machine_file(form: &Form) -> Result<String, Refused> {
    let mut answers = Answers::default();
    for item in Item::ALL {
        let flag = item.question().flag;
        let given = form.answers.get(flag).map(|text| text.trim()).filter(|text| !text.is_empty());
        if let Some(text) = given {
            answers.insert(*item, item.parse(text).map_err(|cause| Refused::of(format_args!("{flag}: {cause}")))?);
        }
    }
    let edges = if form.over_both_edges { Edges::Both } else { Edges::Edge };
    Ok(checked_toml("machine.toml", &form.name, &derived(&answers, edges)?)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A form with the example of every item that a drive of this kind needs.
    fn form(pump: bool) -> Form {
        let asked = questions();
        let which = if pump { "of_pump" } else { "of_valve" };
        let items = asked.as_array().unwrap().iter().filter(|item| item[which] == true && item["need"] != "optional");
        let text = |value: &Value| value.as_str().unwrap().to_owned();
        let answers = items.map(|item| (text(&item["flag"]), text(&item["example"]))).collect();
        Form { name: "press".to_owned(), over_both_edges: false, answers }
    }

    #[test]
    fn a_form_with_what_is_needed_makes_a_machine_file() {
        for pump in [false, true] {
            let text = machine_file(&form(pump)).unwrap();
            assert_eq!(machine_file::read_text("machine.toml", &text).unwrap().name, "press");
        }
    }

    #[test]
    fn what_is_missing_or_impossible_is_named() {
        let mut bare = form(false);
        bare.answers.remove("bore");
        assert!(String::from(machine_file(&bare).unwrap_err()).contains("bore"));
        bare.answers.insert("bore".to_owned(), "-63mm".to_owned());
        assert!(String::from(machine_file(&bare).unwrap_err()).starts_with("bore: "));
    }
}
