//! The shipped machine files: each can be read and states the source of every value.

use std::path::Path;

use model_core::machine::Parameter;

fn preset(name: &str) -> (String, machine_file::MachineFile) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../presets").join(name);
    let text = std::fs::read_to_string(&path).unwrap();
    let file = machine_file::read(&path).unwrap();
    (text, file)
}

#[test]
fn every_value_of_a_preset_says_printed_derived_or_assumed() {
    for name in ["paper-as-printed.toml", "press-63-40.toml", "press-63-40-installed.toml"] {
        let (text, file) = preset(name);
        assert_eq!(format!("{}.toml", file.name), name);
        file.machine.check().unwrap();
        for line in text.lines().filter(|line| line.contains('=') && !line.starts_with(['#', 'n'])) {
            let why = line.split_once('#').map_or("", |(_, comment)| comment.trim());
            let reasoned =
                ["derived: ", "assumed: "].iter().any(|kind| why.len() > kind.len() + 10 && why.starts_with(kind));
            assert!(why == "printed" || why.starts_with("printed: ") || reasoned, "{name}: {line}");
        }
    }
}

#[test]
fn the_printed_coefficients_are_in_the_preset_of_that_name() {
    let (_, file) = preset("paper-as-printed.toml");
    let get = |parameter| file.machine.get(parameter);
    let stiffness = |volume| get(Parameter::BulkModulus) / get(volume);
    assert!((stiffness(Parameter::VolumeA) / 9.63e12 - 1.0).abs() < 1e-4);
    assert!((stiffness(Parameter::VolumeB) / 1.28e12 - 1.0).abs() < 1e-4);
    let span = 10.0 * get(Parameter::ValveGain) + get(Parameter::ValveOffset);
    assert!((get(Parameter::DeadZone) / span - 0.1768).abs() < 1e-4);
}

#[test]
fn the_areas_are_those_of_a_63_mm_bore_and_a_40_mm_rod() {
    for name in ["paper-as-printed.toml", "press-63-40.toml", "press-63-40-installed.toml"] {
        let (_, file) = preset(name);
        let circle = |diameter_m: f64| 0.25 * std::f64::consts::PI * diameter_m * diameter_m;
        assert!((file.machine.get(Parameter::AreaA) - circle(0.063)).abs() < 1e-6);
        assert!((file.machine.get(Parameter::AreaB) - circle(0.063) + circle(0.040)).abs() < 1e-6);
    }
}
