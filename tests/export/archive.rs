//! The archive of an FMU.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::Path;

use fmi_schema::fmi2::{Fmi2ModelDescription, Real, ScalarVariable, ScalarVariableElement, SimpleTypeElement};
use fmi_schema::fmi3::{AbstractVariableTrait, Fmi3ModelDescription, FmiFloat64, TypeDefinition, TypedVariableTrait};
use zip::ZipArchive;

use super::{PUMP, VERSIONS, exported, leaking_press, library, run, text};

fn packed(machine: &str, further: &[&str]) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::read(exported(folder.path(), "drive", machine, further)).unwrap()
}

fn entry(bytes: &[u8], name: &str) -> Vec<u8> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).unwrap();
    let mut content = Vec::new();
    archive.by_name(name).unwrap().read_to_end(&mut content).unwrap();
    content
}

fn description(bytes: &[u8]) -> String {
    String::from_utf8(entry(bytes, "modelDescription.xml")).unwrap()
}

fn described(bytes: &[u8]) -> Fmi3ModelDescription {
    fmi_schema::deserialize(&description(bytes)).unwrap()
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

/// The variables that a description by FMI 2.0 has, with their units.
fn units_of_version_2(description: &Fmi2ModelDescription) -> BTreeMap<String, String> {
    let types = &description.type_definitions.as_ref().unwrap().types;
    let unit = |variable: &ScalarVariable| {
        let ScalarVariableElement::Real(Real { declared_type: Some(declared), .. }) = &variable.elem else {
            panic!("not a real number: {variable:?}")
        };
        let simple = types.iter().find(|simple| simple.name == *declared).unwrap();
        let SimpleTypeElement::Real(real) = &simple.elem else { panic!("not a real number: {simple:?}") };
        (variable.name.clone(), real.unit.clone().unwrap())
    };
    description.get_model_variables().map(unit).collect()
}

#[test]
fn an_fmu_holds_a_description_a_drive_and_the_library_and_nothing_else() {
    for version in VERSIONS {
        let bytes = packed(&leaking_press(), &["--fmi", version]);
        let archive = ZipArchive::new(Cursor::new(&bytes)).unwrap();
        let mut names = archive.file_names().collect::<Result<Vec<_>, _>>().unwrap();
        names.sort_unstable();
        assert_eq!(names.len(), 4, "{names:?}");
        let binary = &*names[0];
        let mut path = binary.split('/');
        assert_eq!((path.next(), path.clone().count()), (Some("binaries"), 2), "{binary}");
        let folder = path.next().unwrap();
        // `x86_64-linux` became the name with FMI 3.0; before, it was `linux64`.
        assert_eq!(folder.contains('-'), version == "3.0", "{binary}");
        assert!(path.next().unwrap().starts_with("drive."), "{binary}");
        assert_eq!(names[1..], ["modelDescription.xml", "resources/machine.toml", "resources/settings.json"]);
        assert_eq!(entry(&bytes, binary), std::fs::read(library()).unwrap());
        assert!(description(&bytes).contains(&format!(" fmiVersion=\"{version}\" ")));
        let machine = String::from_utf8(entry(&bytes, "resources/machine.toml")).unwrap();
        assert!(machine.contains("[effects.internal-leakage]"), "{machine}");
    }
}

#[test]
fn both_versions_describe_the_same_variables_by_the_same_token() {
    for drive in [&leaking_press(), PUMP] {
        let three = described(&packed(drive, &[]));
        assert_eq!(three, described(&packed(drive, &["--fmi", "3.0"])), "3.0 is the default");
        let text = description(&packed(drive, &["--fmi", "2.0"]));
        let two: Fmi2ModelDescription = fmi_schema::deserialize(&text).unwrap();
        assert_eq!((two.guid, two.model_name), (three.instantiation_token.clone(), three.model_name.clone()));
        assert_eq!(units_of_version_2(&fmi_schema::deserialize(&text).unwrap()), units(&three));
    }
}

#[test]
fn a_valve_drive_has_these_variables_in_these_units() {
    let description = described(&packed(&leaking_press(), &["--tick", "0.5"]));
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
    let description = described(&packed(PUMP, &[]));
    let units = units(&description);
    assert_eq!(units["pump_speed"], "rev/s");
    assert_eq!(units["valve_direction"], "1");
    assert!(!units.contains_key("command") && !units.contains_key("spool"), "{units:?}");
    assert_eq!(description.model_name, "pump \"ü\" ??/");
}

#[test]
fn the_same_drive_becomes_the_same_file() {
    let float = |version| packed(&leaking_press(), &["--arithmetic", "float", "--fmi", version]);
    let [two, three] = VERSIONS.map(|version| {
        let once = float(version);
        assert!(once == float(version));
        assert!(once != packed(&leaking_press(), &["--fmi", version]));
        once
    });
    assert!(two != three);
    for name in ["resources/machine.toml", "resources/settings.json"] {
        assert_eq!(entry(&two, name), entry(&three, name));
    }
    assert_eq!(entry(&two, "resources/settings.json"), b"{\"tick\":\"OneMillisecond\",\"arithmetic\":\"float\"}\n");
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
    assert!(other.contains("machine.toml: no function fmi2Instantiate"), "{other}");
    let useless = refused(&["--arithmetic", "float"], &path("params.h"));
    assert!(useless.contains("--arithmetic: only an FMU has it; expected --out with .fmu"), "{useless}");
    let older = refused(&["--fmi", "2.0"], &path("params.rs"));
    assert!(older.contains("--fmi: only an FMU has it; expected --out with .fmu"), "{older}");
    let slow = leaking_press().replace("transport_delay_s = 0.007", "transport_delay_s = 0.8");
    std::fs::write(path("machine.toml"), slow).unwrap();
    let library = library();
    let late = refused(&["--library", text(&library)], &path("drive.fmu"));
    assert!(late.contains("valve.transport_delay_s = 0.8 s: needs 802 ticks"), "{late}");
}
