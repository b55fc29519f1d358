//! A plan on the terminal and for programs.

use std::fmt::Write;

use comfy_table::Table;
use serde_json::{Value, json};

use diagnosis::catalogue::short_name;
use experiment::plan::{Outlook, Plan, Prospect};
use experiment::sensor::Sensor;
use model_core::machine::Parameter;
use recording::display_unit::{TABLE, arrange, in_si, significant};

use crate::plot::{Cell, Grid};

/// The whole text; its tables have this number of characters a line, or 120.
#[must_use]
pub fn text(name: &str, sensors: &[Sensor], plan: &Plan, width: Option<u16>) -> String {
    let mut text = format!("{name}, seen by {}\n", seen_by(sensors));
    if let Some(given) = &plan.given {
        let _ = write!(text, "\nwith the excitation at hand, {}:\n{}\n", summary(given), table(given, width));
    }
    let _ = write!(text, "\nwith {}, {}:\n", plan.excitation.name, summary(&plan.best));
    let _ = writeln!(text, "  {}", plan.tests.join(", then "));
    let _ = writeln!(text, "{}", table(&plan.best, width));
    let (accepted, confused) = (plan.best.isolability.accepted().count(), plan.best.isolability.confused().count());
    for addition in &plan.additions {
        if addition.accepted > accepted || addition.confused < confused {
            let sensor = shown(&addition.sensor);
            let of = plan.best.effects.len();
            let _ = writeln!(
                text,
                "with {sensor} too: {} of {of} effects, {} not distinguishable",
                addition.accepted,
                pairs(addition.confused)
            );
        }
    }
    if !plan.not_testable.is_empty() {
        let names: Vec<&str> = plan.not_testable.iter().map(|effect| effect.name).collect();
        let _ = writeln!(text, "not testable with these sensors: {}", names.join(", "));
    }
    text
}

fn seen_by(sensors: &[Sensor]) -> String {
    sensors.iter().map(shown).collect::<Vec<_>>().join(", ")
}

fn shown(sensor: &Sensor) -> String {
    format!("{} (± {})", sensor.signal, recording::display_unit::difference(sensor.signal, sensor.noise))
}

fn summary(outlook: &Outlook) -> String {
    let (accepted, of) = (outlook.isolability.accepted().count(), outlook.effects.len());
    let duration = significant(outlook.duration_s, 3);
    format!(
        "{duration} s: {accepted} of {of} effects could be found, {} of them not distinguishable",
        pairs(outlook.isolability.confused().count())
    )
}

fn pairs(count: usize) -> String {
    if count == 1 { "1 pair".to_owned() } else { format!("{count} pairs") }
}

/// Characters of a line where the terminal's width is unknown.
const WIDTH: u16 = 120;

fn table(outlook: &Outlook, width: Option<u16>) -> String {
    let mut table = Table::new();
    table.load_style(TABLE);
    arrange(&mut table, Some(width.unwrap_or(WIDTH)));
    table.set_header(["effect", "link", "found from", "usual", "mistaken for"]);
    for (index, prospect) in outlook.effects.iter().enumerate() {
        let rivals: Vec<&str> = if outlook.isolability.accepted[index] {
            outlook.isolability.rivals(index).map(|rival| outlook.effects[rival].effect.name).collect()
        } else {
            vec!["not visible"]
        };
        table.add_row([
            prospect.effect.name.to_owned(),
            prospect.effect.subsystem.to_string(),
            prospect.smallest_value().map_or_else(|| "–".to_owned(), |value| in_si(value, 2)),
            usual(prospect),
            rivals.join(", "),
        ]);
    }
    table.to_string()
}

fn usual(prospect: &Prospect) -> String {
    prospect.amount().map_or_else(String::new, |(parameter, value)| with_unit(parameter, value))
}

fn with_unit(parameter: Parameter, value: f64) -> String {
    match parameter.description().unit {
        "1" => in_si(value, 2),
        unit => format!("{} {unit}", in_si(value, 2)),
    }
}

/// The document.
#[must_use]
pub fn document(name: &str, sensors: &[Sensor], plan: &Plan) -> Value {
    json!({
        "schema": "host-sim/plan/1",
        "machine": name,
        "sensors": sensors.iter().map(sensor).collect::<Vec<_>>(),
        "given": plan.given.as_ref().map(outlook),
        "best": {
            "tests": plan.tests,
            "how": plan.excitation.how,
            "outlook": outlook(&plan.best),
        },
        "further_sensors": plan.additions.iter().map(|addition| json!({
            "sensor": sensor(&addition.sensor),
            "claimed": addition.accepted,
            "mixed_up": addition.confused,
        })).collect::<Vec<_>>(),
        "not_testable": plan.not_testable.iter().map(|effect| effect.name).collect::<Vec<_>>(),
    })
}

fn sensor(sensor: &Sensor) -> Value {
    json!({ "signal": sensor.signal.name(), "noise": sensor.noise, "unit": sensor.signal.si_unit().symbol() })
}

fn outlook(outlook: &Outlook) -> Value {
    let effects: Vec<Value> = outlook
        .effects
        .iter()
        .enumerate()
        .map(|(index, prospect)| {
            let usual = prospect.usual.iter().map(|(parameter, value)| {
                json!({ "name": short_name(*parameter), "value": value, "unit": parameter.description().unit })
            });
            json!({
                "effect": prospect.effect.name,
                "subsystem": prospect.effect.subsystem,
                "usual": usual.collect::<Vec<_>>(),
                // JSON has no infinity: an effect that is never accepted has no value.
                "claimed_from_share_of_usual": prospect.smallest.is_finite().then_some(prospect.smallest),
                "claimed": outlook.isolability.accepted[index],
                "deviations": outlook.isolability.seen[index],
                "passes_for": outlook.isolability.rivals(index).map(|rival| outlook.effects[rival].effect.name).collect::<Vec<_>>(),
                "left_by": outlook.isolability.left[index],
            })
        })
        .collect();
    json!({ "duration_s": outlook.duration_s, "effects": effects })
}

/// The isolability matrix: a row for each effect that is present, a column for each effect that it might be taken for.
#[must_use]
pub fn matrix(outlook: &Outlook) -> Grid {
    let names: Vec<String> = outlook.effects.iter().map(|prospect| prospect.effect.name.to_owned()).collect();
    let cell = |truth: usize, rival: usize| {
        if !outlook.isolability.accepted[truth] {
            Cell::None
        } else if truth == rival {
            Cell::Own
        } else if outlook.isolability.separated[truth][rival] {
            Cell::Distance(outlook.isolability.left[truth][rival])
        } else {
            Cell::Alike
        }
    };
    let cells = (0..names.len()).map(|truth| (0..names.len()).map(|rival| cell(truth, rival)).collect()).collect();
    Grid {
        title: format!("Which effect would pass for which, {} s", significant(outlook.duration_s, 3)),
        rows: "true effect".to_owned(),
        columns: "mistaken for".to_owned(),
        names,
        cells,
    }
}
