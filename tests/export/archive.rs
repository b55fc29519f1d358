//! The archive of an FMU.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::Path;

use fmi_schema::fmi3::{AbstractVariableTrait, Fmi3ModelDescription, FmiFloat64, TypeDefinition, TypedVariableTrait};
use tempfile::TempDir;
use zip::ZipArchive;

use super::{PUMP, done, leaking_press, library, run, text};

fn exported(machine: &str, further: &[&str]) -> (TempDir, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let [file, fmu] = ["machine.toml", "drive.fmu"].map(|name| folder.path().join(name));
    std::fs::write(&file, machine).unwrap();
    let library = library();
    let always = ["export", "--machine", text(&file), "--out", text(&fmu), "--library", text(&library)];
    done(&[&always, further].concat());
    let bytes = std::fs::read(&fmu).unwrap();
    (folder, bytes)
}

fn entry(bytes: &[u8], name: &str) -> Vec<u8> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut content = Vec::new();
    archive.by_name(name).unwrap().read_to_end(&mut content).unwrap();
    content
}

fn described(bytes: &[u8]) -> Fmi3ModelDescription {
    let xml = String::from_utf8(entry(bytes, "modelDescription.xml")).unwrap();
    fmi_schema::deserialize(&xml).unwrap()
}

/// Names and units of all variables.
fn units(description: &Fmi3ModelDescription) -> BTreeMap<String, String> {
    let types = &description.type_definitions.as_ref().unwrap().type_definitions;
    let unit = |variable: &FmiFloat64| {
        let declared = types.iter().find_map(|declared| match declared {
            TypeDefinition::Float64(declared) if Some(declared.name.as_str()) == variable.declared_type() => {
                declared.unit.clone()
            }
            _ => None,
        });
        (variable.name().to_owned(), declared.unwrap())
    };
    description.model_variables.float64().into_iter().map(unit).collect()
}

#[test]
fn an_fmu_holds_a_description_a_drive_and_the_library_and_nothing_else() {
    let (_folder, bytes) = exported(&leaking_press(), &[]);
    let archive = ZipArchive::new(Cursor::new(&bytes)).unwrap();
    let mut names = archive.file_names().collect::<Result<Vec<_>, _>>().unwrap();
    names.sort_unstable();
    assert_eq!(names.len(), 4, "{names:?}");
    let binary = &*names[0];
    assert!(binary.starts_with("binaries/") && binary.contains("/drive."), "{binary}");
    assert_eq!(names[1..], ["modelDescription.xml", "resources/machine.toml", "resources/settings.json"]);
    assert_eq!(entry(&bytes, binary), std::fs::read(library()).unwrap());
    let machine = String::from_utf8(entry(&bytes, "resources/machine.toml")).unwrap();
    assert!(machine.contains("[effects.internal-leakage]"), "{machine}");
}

#[test]
fn a_valve_drive_has_these_variables_in_these_units() {
    let description = described(&exported(&leaking_press(), &["--tick", "0.5"]).1);
    let expected = [
        ("command", "V"),
        ("flow", "m3/s"),
        ("force", "N"),
        ("load_force", "N"),
        ("oil_temperature", "degC"),
        ("position", "m"),
        ("position_start", "m"),
        ("pressure_a", "Pa"),
        ("pressure_b", "Pa"),
        ("spool", "1"),
        ("time", "s"),
        ("velocity", "m/s"),
    ];
    let expected = expected.map(|(name, unit)| (name.to_owned(), unit.to_owned()));
    assert_eq!(units(&description), BTreeMap::from(expected));
    let simulation = description.co_simulation.unwrap();
    assert_eq!((simulation.model_identifier.as_str(), simulation.fixed_internal_step_size), ("drive", Some(5e-4)));
    assert_eq!(description.model_name, "press-63-40");
}

#[test]
fn a_pump_drive_has_speed_and_direction_in_place_of_a_command() {
    let description = described(&exported(PUMP, &[]).1);
    let units = units(&description);
    assert_eq!(units["pump_speed"], "rev/s");
    assert_eq!(units["valve_direction"], "1");
    assert!(!units.contains_key("command") && !units.contains_key("spool"), "{units:?}");
    assert_eq!(description.model_name, "pump \"ü\" ??/");
}

#[test]
fn the_same_drive_becomes_the_same_file() {
    let (_, once) = exported(&leaking_press(), &["--arithmetic", "float"]);
    let (_, again) = exported(&leaking_press(), &["--arithmetic", "float"]);
    assert!(once == again);
    let (_, fixed) = exported(&leaking_press(), &[]);
    assert!(once != fixed);
    assert_eq!(entry(&once, "resources/settings.json"), b"{\"tick\":\"OneMillisecond\",\"arithmetic\":\"float\"}\n");
}

#[test]
fn what_cannot_be_packed_is_refused_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("machine.toml"), leaking_press()).unwrap();
    let refused = |further: &[&str], out: &Path| {
        let machine = path("machine.toml");
        let always = ["export", "--machine", text(&machine), "--out", text(out)];
        let message = run(&[&always, further].concat()).unwrap_err();
        assert!(!out.exists());
        message
    };
    let machine = path("machine.toml");
    let other = refused(&["--library", text(&machine)], &path("drive.fmu"));
    assert!(other.contains("machine.toml: no function fmi3InstantiateCoSimulation"), "{other}");
    let useless = refused(&["--arithmetic", "float"], &path("params.h"));
    assert!(useless.contains("--arithmetic: only an FMU has it; expected --out with .fmu"), "{useless}");
    let slow = leaking_press().replace("transport_delay_s = 0.007", "transport_delay_s = 0.8");
    std::fs::write(path("machine.toml"), slow).unwrap();
    let library = library();
    let late = refused(&["--library", text(&library)], &path("drive.fmu"));
    assert!(late.contains("valve.transport_delay_s = 0.8 s: needs 802 ticks"), "{late}");
}
