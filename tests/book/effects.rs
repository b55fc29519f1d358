//! The effect catalogue, written from the hypothesis files: what an effect adds is stated beside its code, and the book says the same.

use std::fmt::Write;

use diagnosis::catalogue::{CATALOGUE, EffectParameter, Hypothesis, Kind, Scene};
use machine_file::{LoadSource, MachineFile};
use model_core::machine::{Fallback, Parameter};
use recording::Signal;
use simulation::InputPoint;
use system_tests::snapshot;

use super::root;

/// The headings of every hypothesis file, in this order.
const HEADINGS: [&str; 5] = ["What it adds", "How it shows", "What looks alike", "Parameters", "Source"];

const HEAD: &str = "\
# Effect catalogue

What a drive may have and the paper's model leaves out: every effect that `diagnose` tries, in the order of the chain. An effect is
switched on by its table in the machine file, for a simulation and for the controller alike; `diagnose --save-machine` writes the table of what it has found.

*Written from the hypothesis files, `host-sim/crates/diagnosis/src/catalogue/`, by `RENEW=1 cargo test -p system-tests --test book catalogue`.*

Each section has the effect's table with values of usual size on [the press](../presets/press-63-40.toml), and its parameters: what the machine
file accepts, what a value is that is not given, and where values usually lie on that press. A search may go three times beyond what is usual, more
stiffly the further; outside of it nothing is accepted. An amount of 0 is no effect.
";

/// The shipped press, recorded with all the signals that the catalogue's ranges need.
pub(crate) fn press() -> MachineFile {
    machine_file::read(&root().join("presets/press-63-40.toml")).unwrap()
}

pub(crate) fn scene(file: &MachineFile) -> Scene<'_> {
    Scene {
        machine: &file.machine,
        input_point: InputPoint::Command,
        load: LoadSource::Constant,
        judged: &[Signal::Spool, Signal::PressureA, Signal::PressureB, Signal::Position],
        travel_m: (0.05, 0.25),
        duration_s: 10.0,
        is_sparse: false,
        lowest_pa: -1e6,
        held: &[],
        asks_since: false,
        changeable: &[],
    }
}

/// Title and sections of a hypothesis file, in order.
fn sections(effect: &Hypothesis) -> (String, Vec<(String, String)>) {
    let file =
        root().join("host-sim/crates/diagnosis/src/catalogue").join(format!("{}.rs", effect.name.replace('-', "_")));
    let text = std::fs::read_to_string(&file).unwrap();
    let mut title = String::new();
    let mut sections: Vec<(String, String)> = Vec::new();
    for line in text.lines().map_while(|line| line.strip_prefix("//!")).map(str::trim) {
        if let Some(heading) = line.strip_prefix("## ") {
            sections.push((heading.to_owned(), String::new()));
        } else if let Some(heading) = line.strip_prefix("# ") {
            heading.clone_into(&mut title);
        } else if let Some((_, body)) = sections.last_mut() {
            body.push_str(line);
            body.push('\n');
        }
    }
    (title, sections)
}

/// A value for the example: a usual one that is not neutral.
fn example(effect_parameter: &EffectParameter, scene: &Scene<'_>) -> f64 {
    let (low, high) = effect_parameter.range(scene);
    match effect_parameter.kind {
        Kind::Signed(_) => high / 2.0,
        Kind::Place(..) | Kind::Floor(..) | Kind::Setting(..) => f64::midpoint(low, high),
        _ => (low * high).sqrt(),
    }
}

/// A strong value for a picture: three quarters of the way, in powers of ten, to the most that is usual.
pub(crate) fn strong(effect_parameter: &EffectParameter, scene: &Scene<'_>) -> f64 {
    let (low, high) = effect_parameter.range(scene);
    match effect_parameter.kind {
        Kind::Amount(_) => (low * high.powi(3)).powf(0.25),
        Kind::Signed(_) => 0.75 * high,
        _ => example(effect_parameter, scene),
    }
}

/// Two digits, as TOML and people read them.
fn short(value: f64) -> String {
    let scientific = format!("{value:.1e}");
    let rounded: f64 = scientific.parse().unwrap();
    match rounded.abs() {
        0.0 => "0".to_owned(),
        size if !(1e-2..1e5).contains(&size) => scientific.replace(".0e", "e"),
        _ => format!("{rounded}"),
    }
}

/// The effect parameters of all forms, each parameter once, in the order of the machine file.
fn effect_parameters(effect: &Hypothesis) -> Vec<EffectParameter> {
    let mut all: Vec<EffectParameter> = Vec::new();
    for effect_parameter in effect.effect_parameters() {
        let known = all.iter().any(|known| known.parameter == effect_parameter.parameter);
        let own = effect.parameters().any(|parameter| parameter == effect_parameter.parameter);
        if own && !known {
            all.push(*effect_parameter);
        }
    }
    all.sort_by_key(|effect_parameter| effect_parameter.parameter);
    all
}

/// The effect's table in the machine file: its first form that is visible in these recordings.
pub(crate) fn table(effect: &Hypothesis, scene: &Scene<'_>) -> String {
    table_of(effect, scene, example)
}

/// The same with other values.
pub(crate) fn table_of(
    effect: &Hypothesis,
    scene: &Scene<'_>,
    of: impl Fn(&EffectParameter, &Scene<'_>) -> f64,
) -> String {
    let mut text = format!("[effects.{}]\n", effect.name);
    let form = effect.forms_in(scene).next().unwrap_or(effect.forms[0]);
    for effect_parameter in form {
        let key = effect_parameter.parameter.description().key;
        if let Some(name) = key.strip_prefix(&format!("effects.{}.", effect.name)) {
            let value = short(of(effect_parameter, scene));
            let fraction = if value.contains(['.', 'e']) { "" } else { ".0" };
            writeln!(text, "{name} = {value}{fraction}").unwrap();
        }
    }
    text
}

fn row(effect_parameter: &EffectParameter, scene: &Scene<'_>) -> String {
    let description = effect_parameter.parameter.description();
    let name = description.key.rsplit_once('.').unwrap().1;
    let (low, high) = effect_parameter.range(scene);
    let default = match description.default {
        Fallback::Value(value) => short(value),
        Fallback::Required | Fallback::HalfStrokeVolume => "–".to_owned(),
    };
    // Without a recorded temperature, some parameters have no place or size: then there is no range.
    let usual = if low < high { format!("{} … {}", short(low), short(high)) } else { "–".to_owned() };
    format!(
        "| `{name}` | {} | {} … {} | {default} | {usual} | {} |",
        description.unit,
        short(description.min),
        short(description.max),
        description.meaning
    )
}

fn catalogue() -> String {
    let file = press();
    let scene = scene(&file);
    let mut text = HEAD.to_owned();
    text.push_str("\n| link | effects |\n|---|---|\n");
    let mut links: Vec<(String, Vec<String>)> = Vec::new();
    for effect in CATALOGUE {
        let link = effect.subsystem.to_string();
        let named = format!("[{0}](#{0})", effect.name);
        match links.last_mut() {
            Some((last, names)) if *last == link => names.push(named),
            _ => links.push((link, vec![named])),
        }
    }
    for (link, names) in links {
        writeln!(text, "| {link} | {} |", names.join(" · ")).unwrap();
    }
    for effect in CATALOGUE {
        let (_, sections) = sections(effect);
        let body = |heading: &str| sections.iter().find(|(known, _)| known == heading).unwrap().1.trim().to_owned();
        writeln!(text, "\n## {}\n", effect.name).unwrap();
        writeln!(text, "In the {}: `{}`.\n\n{}\n", effect.subsystem, effect.equation, body("What it adds")).unwrap();
        writeln!(text, "```toml\n{}```\n", table(effect, &scene)).unwrap();
        writeln!(text, "**How it shows.** {}\n", body("How it shows")).unwrap();
        writeln!(text, "**What looks alike.** {}\n", body("What looks alike")).unwrap();
        for alike in effect.look_alikes {
            let known = CATALOGUE.iter().any(|known| known.name == alike.effect);
            let name = if known { format!("[{0}](#{0})", alike.effect) } else { alike.effect.to_owned() };
            writeln!(text, "- {name}: {}", alike.told_apart_by).unwrap();
        }
        writeln!(text, "\nThe test that shows it: {}.\n", effect.separated_by).unwrap();
        if let Some(extension) = effect.extends {
            writeln!(text, "It extends [{0}](#{0}) and has to earn what it has more.\n", extension.plain).unwrap();
        }
        writeln!(text, "**Parameters.** {}\n", body("Parameters")).unwrap();
        let mut fitted = effect.effect_parameters().map(|effect_parameter| effect_parameter.parameter);
        if let Some(shared) = fitted.find(|fitted| effect.parameters().all(|own| own != *fitted)) {
            let key = shared.description().key;
            writeln!(text, "It is also fitted with `{key}`, a key that several laws share.\n").unwrap();
        }
        text.push_str("| key | unit | accepted | not given | usual on the press | what |\n|---|---|---|---|---|---|\n");
        for effect_parameter in effect_parameters(effect) {
            writeln!(text, "{}", row(&effect_parameter, &scene)).unwrap();
        }
        writeln!(text, "\n**Source.** {}", body("Source")).unwrap();
    }
    text
}

#[test]
fn every_hypothesis_file_has_the_same_headings_and_says_something_under_each() {
    for effect in CATALOGUE {
        let (title, sections) = sections(effect);
        assert_eq!(title.to_lowercase().replace(' ', "-"), effect.name);
        let headings: Vec<&str> = sections.iter().map(|(heading, _)| heading.as_str()).collect();
        assert_eq!(headings, HEADINGS, "{}", effect.name);
        for (heading, body) in &sections {
            assert!(body.trim().len() > 20, "{}, {heading}: {body}", effect.name);
        }
    }
}

#[test]
fn every_table_that_the_catalogue_shows_is_read_by_the_tool_and_switches_its_effect_on() {
    let file = press();
    let preset = std::fs::read_to_string(root().join("presets/press-63-40.toml")).unwrap();
    for effect in CATALOGUE {
        let table = table(effect, &scene(&file));
        let read = machine_file::read_text("shown.toml", &format!("{preset}\n{table}"))
            .unwrap_or_else(|error| panic!("{table}{error}"));
        assert!(read.effects.contains(effect.name) && effect.is_on(&read.machine, &[]), "{table}");
    }
}

#[test]
fn every_parameter_of_an_effect_is_in_the_catalogue() {
    for effect in CATALOGUE {
        let shown: Vec<Parameter> =
            effect_parameters(effect).iter().map(|effect_parameter| effect_parameter.parameter).collect();
        assert_eq!(shown, effect.parameters().collect::<Vec<_>>(), "{}", effect.name);
    }
}

#[test]
fn the_catalogue_in_the_book_is_that_of_the_code() {
    snapshot::compare("../docs/effects.md", &catalogue(), |found, kept| found == kept);
}
