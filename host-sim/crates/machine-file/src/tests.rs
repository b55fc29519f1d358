//! What is read, what is refused, and what comes out again.

use model_core::machine::Source;
use recording::files::source_error::{Explained, render};
use recording::{Mapping, Scale, Signal};

use crate::*;

const VALVE: &str = r#"# Data sheet, page 3.
name = "press-63-40"

[supply]
pressure_pa = 7.0e6   # at the pump

[valve]
gain_per_v = 0.0559
dead_zone = 0.1049                  # in x; both sides
time_constants_s = [0.018, 0.0279]

[cylinder]
area_a_m2 = 3.117e-3
area_b_m2 = 1.861e-3
moving_mass_kg = 20
"#;

/// A mass that a recorded force moves.
const AXIS: &str = r#"name = "axis"

[cylinder]
moving_mass_kg = 80.0
viscous_friction_n_s_per_m = 250.0
stroke_m = 0.3

[load]
force_n = -3.0

[effects.coulomb-friction]
force_n = 20.0

[fit.sigma]
"cylinder.moving_mass_kg" = 20.0
"#;

const PUMP: &str = "[pump]\n[cylinder]\narea_a_m2 = 1e-3\narea_b_m2 = 1e-3\n";

fn parse(text: &str) -> Result<MachineFile, MachineFileError> {
    read_text("machine.toml", text)
}

/// The error for the text of the valve drive, with lines inserted after one of its table headers.
#[track_caller]
fn refused(table: &str, lines: &str, line: usize) -> MachineFileError {
    let header = format!("[{table}]\n");
    let text = VALVE.replace(&header, &format!("{header}{lines}\n"));
    assert_ne!(text, VALVE);
    let error = parse(&text).unwrap_err();
    assert_eq!(error.place().line(), Some(line), "{error}");
    assert!(error.to_string().starts_with("machine.toml:"), "{error}");
    assert!(render(&error).contains("= expected: "), "{}", render(&error));
    error
}

macro_rules! assert_error {
    ($error:expr, $pattern:pat) => {{
        let error = $error;
        assert!(matches!(error, $pattern), "{error:?}");
    }};
}

#[test]
#[expect(clippy::float_cmp, reason = "values come out as they stand in the text")]
fn a_valve_drive_is_read_with_defaults() {
    let file = parse(VALVE).unwrap();
    assert_eq!(file.name, "press-63-40");
    assert_eq!(file.machine.source, Source::Valve);
    assert_eq!(file.machine.get(Parameter::TimeConstant2), 0.0279);
    assert_eq!(file.machine.get(Parameter::MovingMass), 20.0);
    assert_eq!(file.machine.get(Parameter::FlowLimit), f64::INFINITY);
    assert_eq!(file.machine.get(Parameter::VolumeA), 3.117e-3 * 0.3 / 2.0);
    assert_eq!(file.machine.get(Parameter::VolumeB), 1.861e-3 * 0.3 / 2.0);
    assert!(file.given.contains(&Parameter::MovingMass) && !file.given.contains(&Parameter::Stroke));
    assert!(!file.has_sigma_table && file.effects.is_empty());
    assert_eq!(file.load_source, LoadSource::Constant);
    let pump = parse(PUMP).unwrap();
    assert_eq!((pump.machine.source, pump.name.as_str()), (Source::Pump, "machine"));
}

#[test]
fn a_table_that_was_pasted_twice_says_where_its_lines_belong() {
    let error = refused("supply", "[channels]\ntime = \"t\"\n[channels]", 7);
    assert!(error.to_string().contains("belong below the first"), "{error}");
}

#[test]
fn columns_that_are_left_unused_are_read_written_and_taken_back() {
    let channels = "[channels]\nposition = \"Weg [mm]\"\nunused = [\"Weg [mm]\", \"flow [l/min]\"]\nspool = \"x\"\n";
    let file = parse(&format!("{VALVE}{channels}")).unwrap();
    assert_eq!(file.channels.unused(), ["flow [l/min]"], "what is mapped is used");
    let mut other = file.clone();
    other.channels.leave_unused("x");
    let text = other.to_text("other.toml").unwrap();
    assert!(text.contains("unused = [\"flow [l/min]\", \"x\"]") && !text.contains("spool ="), "{text}");
    let again = parse(&text).unwrap();
    assert_eq!(again.channels, other.channels);
    let mut back = again.clone();
    back.channels.insert(Signal::Spool, Mapping::column("x", false));
    assert_eq!(parse(&back.to_text("back.toml").unwrap()).unwrap().channels, file.channels);
    assert_error!(refused("supply", "[channels]\nunused = \"x\"", 6), MachineFileError::WrongType { .. });
    assert_error!(refused("supply", "[channels]\nunused = [\"\"]", 6), MachineFileError::EmptyHeader { .. });
}

#[test]
fn the_other_tables_are_read() {
    let more = "[load]\nsource = \"recorded-pressures\"\n[effects.coulomb-friction]\nforce_n = 900\n[effects]\npump-slip = {}\n\
        [channels]\nposition = \"Kolbenweg [mm]\"\n[fit.sigma]\n\"valve.time_constants_s[0]\" = 0.001\n";
    let file = parse(&format!("{VALVE}{more}")).unwrap();
    assert_eq!(file.load_source, LoadSource::RecordedPressures);
    assert_eq!(file.effects.iter().copied().collect::<Vec<_>>(), ["coulomb-friction", "pump-slip"]);
    assert_eq!(file.channels.get(Signal::Position).unwrap().header, "Kolbenweg [mm]");
    assert_eq!(file.sigma, BTreeMap::from([(Parameter::TimeConstant1, 0.001)]));
    assert!(file.has_sigma_table);
}

#[test]
fn unknown_tables_and_keys_are_met_with_the_nearest_known_one() {
    let error = refused("supply", "pressure_bar = 70", 5);
    assert!(error.to_string().contains("perhaps `supply.pressure_pa`"), "{error}");
    assert_error!(error, MachineFileError::UnknownKey { .. });
    assert_error!(refused("supply", "[valves]", 5), MachineFileError::UnknownTable { nearest: Some(_), .. });
    assert_error!(refused("supply", "[effects.leakage]", 5), MachineFileError::UnknownTable { .. });
    assert_error!(refused("supply", "[fit]\nsigmas = 1", 6), MachineFileError::UnknownKey { .. });
    assert_error!(refused("supply", "[fit.sigma]\n\"valve.gain\" = 1", 6), MachineFileError::UnknownKey { .. });
    assert_error!(
        refused("supply", "[channels]\npositon = \"x\"", 6),
        MachineFileError::UnknownSignal { nearest: "position", .. }
    );
    let top = parse(&format!("gain_per_v = 1\n{VALVE}")).unwrap_err();
    assert!(top.to_string().contains("perhaps `valve.gain_per_v`"), "{top}");
}

#[test]
fn what_must_be_there_is_asked_for() {
    for (table, left) in [("supply", "supply"), ("cylinder", "cylinder")] {
        let text = VALVE
            .replace(&format!("[{left}]"), "[linkage]")
            .replace("pressure_pa", "#")
            .replace("area_", "#")
            .replace("moving", "#");
        assert!(matches!(parse(&text).unwrap_err(), MachineFileError::MissingTable { table: t, .. } if t == table));
    }
    let error = parse(&VALVE.replace("area_b_m2", "#")).unwrap_err();
    assert_eq!(error.place().line(), Some(12));
    assert_error!(error, MachineFileError::MissingKey { key: "cylinder.area_b_m2", .. });
    assert_error!(parse("name = \"x\"\n").unwrap_err(), MachineFileError::NoSource { .. });
    assert_error!(parse(&format!("{VALVE}[pump]\n")).unwrap_err(), MachineFileError::TwoSources { .. });
    let lone = parse(&format!("{VALVE}[directional_valve]\n")).unwrap_err();
    assert_error!(lone, MachineFileError::DirectionalValveWithoutPump { .. });
}

#[test]
#[expect(clippy::float_cmp, reason = "values come out as they stand in the text")]
fn a_file_without_valve_and_pump_is_a_mass_that_a_recorded_force_moves() {
    let file = parse(AXIS).unwrap();
    assert_eq!(file.machine.source, Source::Force);
    assert_eq!(file.machine.get(Parameter::ViscousFriction), 250.0);
    assert_eq!([Parameter::AreaA, Parameter::AreaB, Parameter::VolumeA].map(|one| file.machine.get(one)), [0.0; 3]);
    file.machine.check().unwrap();
    // Both areas, or none: the pressures are the force.
    let areas = "area_a_m2 = 2e-3\narea_b_m2 = 1e-3\n";
    let driven = parse(&AXIS.replace("stroke_m", &format!("{areas}stroke_m"))).unwrap();
    assert_eq!(driven.machine.get(Parameter::AreaB), 1e-3);
    driven.machine.check().unwrap();
    for (left, key) in [
        ("moving_mass_kg = 80.0\n", "cylinder.moving_mass_kg"),
        ("viscous_friction_n_s_per_m = 250.0\n", "cylinder.viscous_friction_n_s_per_m"),
    ] {
        let error = parse(&AXIS.replace(left, "")).unwrap_err();
        assert!(matches!(error, MachineFileError::MissingKey { key: found, .. } if found == key), "{error}");
    }
    let one = parse(&AXIS.replace("stroke_m", "area_a_m2 = 2e-3\nstroke_m")).unwrap_err();
    assert_error!(one, MachineFileError::MissingKey { key: "cylinder.area_b_m2", .. });
}

#[test]
fn what_takes_no_part_in_a_mass_asks_whether_the_valve_is_missing() {
    for (at, lines, found, line) in [
        ("[load]", "[supply]\npressure_pa = 7e6\n", "[supply]", 8),
        ("[load]", "[supply]\n\n", "[supply]", 8),
        ("stroke_m", "volume_a_m3 = 1e-4\n", "`cylinder.volume_a_m3`", 6),
        ("stroke_m", "bulk_modulus_pa = 1e9\n", "`cylinder.bulk_modulus_pa`", 6),
        ("[load]", "[sensing]\nlvdt_counts_per_unit = 100\n", "`sensing.lvdt_counts_per_unit`", 9),
        ("[load]", "[effects.internal-leakage]\nconductance_m3_per_s_pa = 1e-12\n", "[effects.internal-leakage]", 8),
        ("[load]", "[effects.pressure-dependent-friction]\n", "[effects.pressure-dependent-friction]", 8),
        ("\"cylinder", "\"valve.gain_per_v\" = 0.01\n", "`valve.gain_per_v` in [fit.sigma]", 15),
        (
            "[load]",
            "[fit.tolerance]\n\"effects.internal-leakage.conductance_m3_per_s_pa\" = 1e-13\n",
            "[fit.tolerance]",
            9,
        ),
        ("force_n = -3.0", "source = \"recorded-pressures\"\n", "`load.source`", 8),
        ("[load]", "[effects.unnamed]\nquantity = 2\nvalues = [1e-6]\n", "`effects.unnamed.quantity` is 2", 9),
    ] {
        let text = AXIS.replacen(at, &format!("{lines}{at}"), 1);
        let error = parse(&text).unwrap_err();
        let told = render(&error);
        assert!(matches!(error, MachineFileError::WithoutSource { .. }) && told.contains(found), "{lines}: {told}");
        assert!(told.contains("neither [valve] nor [pump]") && told.contains("is one missing?"), "{told}");
        assert_eq!(error.place().line(), Some(line), "{told}");
    }
    // A typing error in the table's name is told as one.
    let misspelt = parse(&VALVE.replace("[valve]", "[valves]")).unwrap_err();
    assert_error!(misspelt, MachineFileError::UnknownTable { nearest: Some(_), .. });
    let forgotten = parse(
        &VALVE.replace("[valve]", "[sensing]").replace("gain_per_v", "#").replace("dead", "#").replace("time", "#"),
    );
    assert_error!(forgotten.unwrap_err(), MachineFileError::WithoutSource { .. });
}

#[test]
fn a_mass_that_a_force_moves_is_written_as_it_is_read() {
    let mut file = parse(AXIS).unwrap();
    assert_eq!(file.to_text("axis.toml").unwrap(), AXIS);
    file.machine.set(Parameter::MovingMass, 81.5);
    assert_eq!(file.to_text("axis.toml").unwrap(), AXIS.replace("80.0", "81.5"));
    // Made in the program, with a mass that is the default of other drives.
    let mut machine = file.machine;
    machine.set(Parameter::MovingMass, 20.0);
    let made = MachineFile::from_machine("axis", machine);
    let text = made.to_text("axis.toml").unwrap();
    assert!(!text.contains("[supply]") && !text.contains("[valve]") && !text.contains("area"), "{text}");
    assert_eq!(parse(&text).unwrap().machine, machine, "{text}");
}

#[test]
fn wrong_types_are_refused() {
    assert_error!(refused("valve", "offset = \"0\"", 8), MachineFileError::WrongType { .. });
    assert_error!(refused("valve", "offset = [0.1]", 8), MachineFileError::WrongType { .. });
    assert_error!(refused("supply", "[load]\nsource = 1", 6), MachineFileError::WrongType { .. });
    assert_error!(refused("supply", "[load]\nsource = \"other\"", 6), MachineFileError::UnknownChoice { .. });
    assert_error!(refused("supply", "[channels]\ntime = \"\"", 6), MachineFileError::EmptyHeader { .. });
    assert_error!(refused("supply", "[fit.sigma]\nvalve.gain_per_v = 1", 6), MachineFileError::WrongType { .. });
    assert_error!(refused("supply", "[fit.sigma]\n\"valve.gain_per_v\" = 0", 6), MachineFileError::NotPositive { .. });
    let tolerance = |line: &str| refused("supply", &format!("[fit.tolerance]\n{line}"), 6);
    assert_error!(tolerance("\"effects.sensor-offset.spool\" = -1"), MachineFileError::NotPositive { .. });
    // Only what an effect has can be within a tolerance.
    assert_error!(tolerance("\"valve.gain_per_v\" = 0.1"), MachineFileError::UnknownKey { .. });
    assert_error!(parse(&VALVE.replace("[supply]", "[[supply]]")).unwrap_err(), MachineFileError::WrongType { .. });
    let long = parse(&VALVE.replace("0.0279]", "1, 2]")).unwrap_err();
    assert_error!(long, MachineFileError::TooManyEntries { found: 3, most: 2, .. });
    let single = parse(&VALVE.replace("[0.018, 0.0279]", "0.018")).unwrap_err();
    assert_error!(single, MachineFileError::WrongType { .. });
}

#[test]
fn impossible_values_are_refused() {
    for (line, table, at) in [
        ("viscous_friction_n_s_per_m = -1", "cylinder", 13),
        ("stroke_m = nan", "cylinder", 13),
        ("bulk_modulus_pa = inf", "cylinder", 13),
        ("offset = 2", "valve", 8),
        ("transport_delay_s = -0.001", "valve", 8),
    ] {
        assert_error!(refused(table, line, at), MachineFileError::OutOfRange { .. });
    }
    assert_error!(parse(&VALVE.replace("= 20", "= -20")).unwrap_err(), MachineFileError::OutOfRange { .. });
    let table = |lines: &str| parse(&format!("{VALVE}[effects.unnamed]\n{lines}\n")).unwrap_err();
    assert_error!(table("quantity = 5"), MachineFileError::OutOfRange { .. });
    assert_error!(table("over = 1.5"), MachineFileError::NotWhole { .. });
    assert_error!(table("values = \"none\""), MachineFileError::WrongType { .. });
    let error = parse(&VALVE.replace("0.1049 ", "1.0 ")).unwrap_err();
    assert_eq!(error.to_string(), "machine.toml:9:13: `valve.dead_zone` is 1.0; expected 0.0 to 0.999");
}

#[test]
fn text_that_is_not_toml_is_refused_with_its_line() {
    assert_error!(refused("supply", "pressure = = 1", 5), MachineFileError::Syntax { .. });
    assert_error!(refused("valve", "offset = 0\noffset = 0", 9), MachineFileError::Syntax { .. });
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.toml");
    std::fs::write(&path, b"name = \"a\"\n\xff").unwrap();
    let error = read(&path).unwrap_err();
    assert_eq!(error.place().line(), Some(2));
    assert_error!(error, MachineFileError::NotUtf8 { .. });
    std::fs::write(&path, vec![b'#'; (1 << 20) + 1]).unwrap();
    assert_error!(read(&path).unwrap_err(), MachineFileError::TooLarge { .. });
    assert_error!(read(folder.path()).unwrap_err(), MachineFileError::Io { .. });
}

#[test]
#[expect(clippy::float_cmp, reason = "the value comes out as it stands in the text")]
fn a_floor_of_the_pressures_lies_between_vacuum_and_the_tank() {
    let with = |line: &str| parse(&format!("{VALVE}[effects.cavitation]\n{line}\n"));
    let file = with("floor_pa = -8e4").unwrap();
    assert!(file.effects.contains("cavitation"));
    assert_eq!(file.machine.get(Parameter::CavitationFloor), -8e4);
    let expected = "\
error: `effects.cavitation.floor_pa` is 20000.0 Pa
  --> machine.toml:17:12
   |
17 | floor_pa = 2e4
   |            ^^^
   |
   = expected: -101300.0 Pa (vacuum) to `supply.tank_pressure_pa`, which is 0.0 Pa";
    assert_eq!(render(&with("floor_pa = 2e4").unwrap_err()), expected);
    assert_error!(with("floor_pa = -2e5").unwrap_err(), MachineFileError::Floor { .. });
    let error = with("").unwrap_err();
    assert_eq!(error.place().line(), Some(16));
    assert_error!(error, MachineFileError::MissingKey { .. });
}

#[test]
fn an_error_is_drawn_with_its_line() {
    let error = parse(&VALVE.replace("= 20", "= -20")).unwrap_err();
    let expected = "\
error: `cylinder.moving_mass_kg` is -20.0 kg
  --> machine.toml:15:18
   |
15 | moving_mass_kg = -20
   |                  ^^^
   |
   = expected: 0.01 to 10000000.0 kg";
    assert_eq!(render(&error), expected);
}

#[test]
fn a_saved_file_keeps_comments_and_order_and_changes_only_what_changed() {
    let mut file = parse(VALVE).unwrap();
    assert_eq!(file.to_text("m").unwrap(), VALVE);
    file.machine.set(Parameter::DeadZone, 0.11);
    file.machine.set(Parameter::TimeConstant1, 1e-5);
    file.machine.set(Parameter::CoulombFriction, 913.0);
    file.machine.set(Parameter::LoadForce, -2801.76);
    file.load_source = LoadSource::RecordedPressures;
    file.effects.insert("hose-compliance");
    file.sigma.insert(Parameter::ValveGain, 0.003);
    let expected = VALVE.replace("0.1049 ", "0.11 ").replace("0.018", "1e-5")
        + "\n[load]\nforce_n = -2801.76\nsource = \"recorded-pressures\"\n\
           \n[effects.hose-compliance]\ncompliance_m3_per_pa = 0.0\n\
           \n[effects.coulomb-friction]\nforce_n = 913.0\n\
           \n[fit.sigma]\n\"valve.gain_per_v\" = 0.003\n";
    let text = file.to_text("m").unwrap();
    assert_eq!(text, expected);
    let mut again = parse(&text).unwrap();
    assert_eq!(again.machine, file.machine);
    again.effects.clear();
    again.machine.set(Parameter::CoulombFriction, 0.0);
    assert!(!again.to_text("m").unwrap().contains("[effects."));
}

#[test]
fn a_level_at_rest_that_was_found_is_saved_and_nothing_is_written_where_none_was() {
    let mut file = parse(VALVE).unwrap();
    file.start_at(None);
    assert_eq!(file.to_text("m").unwrap(), VALVE);
    file.start_at(Some(0.44));
    let again = parse(&file.to_text("m").unwrap()).unwrap();
    assert_eq!(again.machine.get(Parameter::LevelAtRest).to_bits(), 0.44_f64.to_bits());
    assert!(again.given.contains(&Parameter::LevelAtRest));
}

#[test]
fn a_drive_made_in_the_program_is_saved_and_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.toml");
    for text in [VALVE, PUMP] {
        let mut machine = parse(text).unwrap().machine;
        machine.set(Parameter::InternalLeakage, 2e-12);
        let file = MachineFile::from_machine("made", machine);
        file.save(&path).unwrap();
        let again = read(&path).unwrap();
        assert_eq!((again.machine, again.name, again.effects), (file.machine, file.name, file.effects));
    }
    let before = std::fs::read(&path).unwrap();
    let mut wrong = read(&path).unwrap();
    wrong.machine.set(Parameter::MovingMass, f64::NAN);
    assert_error!(wrong.save(&path).unwrap_err(), MachineFileError::OutOfRange { .. });
    assert_eq!(std::fs::read(&path).unwrap(), before);
}

#[test]
fn a_sensor_that_reads_volts_has_its_zero_and_full_reading_beside_its_column() {
    let channels = "\n[channels]\nspool = { column = \"spool_sensor [V]\", zero = 5, full = 5.0 }\n\
        command = { column = \"command_5v_centre [V]\", zero = 5.0 }\nposition = \"Kolbenweg [mm]\"\n";
    let file = parse(&format!("{VALVE}{channels}")).unwrap();
    let scale = |signal| file.channels.get(signal).unwrap().scale;
    assert_eq!(scale(Signal::Spool), Some(Scale { zero: 5.0, full: 5.0 }));
    assert_eq!(scale(Signal::Command), Some(Scale { zero: 5.0, full: 1.0 }));
    assert_eq!(scale(Signal::Position), None);
    // A file is written as it was read, and a new mapping is written so that it can be read back.
    assert!(file.to_text("machine.toml").unwrap().contains("zero = 5, full = 5.0 }"));
    let mut made = MachineFile::from_machine("made", file.machine);
    made.channels = file.channels.clone();
    assert_eq!(file.channels.pressure, recording::PressureZero::Gauge);
    made.channels.pressure = recording::PressureZero::Absolute;
    let absolute = parse(&made.to_text("made.toml").unwrap()).unwrap().channels;
    assert_eq!(absolute, made.channels);
    made.channels = file.channels.clone();
    assert_eq!(parse(&made.to_text("made.toml").unwrap()).unwrap().channels, file.channels);
}

#[test]
fn another_consumer_is_known_by_its_flow_or_by_its_command() {
    let channels = "\n[channels]\nother_flow = \"Q2 [l/min]\"\n\
        other_flow_2 = { column = \"Stick [V]\", zero = 5, full = 2.5, full_flow_m3_per_s = 5e-4 }\n";
    let file = parse(&format!("{VALVE}{channels}")).unwrap();
    assert_eq!(file.channels.get(Signal::OtherFlow).unwrap().scale, None);
    let Some(Scale { zero, full }) = file.channels.get(Signal::OtherFlow2).unwrap().scale else { panic!() };
    assert_eq!((zero, (7.5 - zero) / full), (5.0, 5e-4));
    let mut made = MachineFile::from_machine("made", file.machine);
    made.channels = file.channels.clone();
    assert_eq!(parse(&made.to_text("made.toml").unwrap()).unwrap().channels, file.channels);
    let other = |key: &str, value: &str| {
        refused("supply", &format!("[channels]\n{key} = {{ column = \"x\", full_flow_m3_per_s = {value} }}"), 6)
    };
    assert_error!(other("other_flow", "0"), MachineFileError::NoSpan { .. });
    assert_error!(other("flow", "1e-4"), MachineFileError::UnknownKey { .. });
    let without = "[channels]\nother_flow = { column = \"x\", full = 10.0 }";
    assert_error!(refused("supply", without, 6), MachineFileError::MissingKey { key: "full_flow_m3_per_s", .. });
}

#[test]
fn a_sensor_that_says_too_little_or_too_much_is_refused() {
    let spool = |sensor: &str| refused("supply", &format!("[channels]\nspool = {sensor}"), 6);
    assert_error!(spool("{ column = \"s [V]\", zero = 5, ful = 5 }"), MachineFileError::UnknownKey { .. });
    assert_error!(spool("{ zero = 5 }"), MachineFileError::MissingKey { key: "column", .. });
    assert_error!(spool("{ column = \"\" }"), MachineFileError::EmptyHeader { .. });
    assert_error!(spool("{ column = \"s\", full = \"5\" }"), MachineFileError::WrongType { .. });
    assert_error!(spool("{ column = \"s\", zero = nan }"), MachineFileError::OutOfRange { .. });
    assert_error!(spool("{ column = \"s\", full = 0.0 }"), MachineFileError::NoSpan { .. });
    assert_error!(spool("5"), MachineFileError::WrongType { .. });
}

const SIDES: &str = "\n[linkage]\nbase_m = 0.6\narm_m = 0.5\nlength_retracted_m = 0.45\nangle_at_zero_rad = 0.4\n";
const TABLE: &str = "\n[linkage]\nangles_deg = [70, 40, 10.0]\npositions_m = [0.0, 0.12, 0.3]\n";

fn linkage_of(text: &str) -> recording::Linkage {
    (**parse(&format!("{VALVE}{text}")).unwrap().channels.linkage.as_ref().unwrap()).clone()
}

#[test]
fn a_linkage_is_given_by_its_sides_or_by_a_table() {
    let right = (0.36_f64 + 0.25).sqrt() - 0.45;
    let quarter = std::f64::consts::FRAC_PI_2;
    assert!((linkage_of(SIDES).position_m(quarter - 0.4).unwrap() - right).abs() < 1e-12);
    let turned = linkage_of(&format!("{SIDES}angle_rises = \"retracting\"\n"));
    assert!((turned.position_m(0.4 - quarter).unwrap() - right).abs() < 1e-12);
    let degrees = linkage_of(TABLE);
    assert_eq!(degrees.position_m(40_f64.to_radians()), Some(0.12));
    let radians = linkage_of(&TABLE.replace("angles_deg = [70, 40, 10.0]", "angles_rad = [1.2, 0.7, 0.2]"));
    assert_eq!(radians.position_m(0.7), Some(0.12));
    // A part of a triangle is none: what is missing has a default for the controller only.
    assert_eq!(parse(&format!("{VALVE}\n[linkage]\nbase_m = 0.6\n")).unwrap().channels.linkage, None);
}

#[test]
fn what_makes_no_linkage_is_refused() {
    let linkage = |lines: &str, at: usize| {
        let error = parse(&format!("{VALVE}[linkage]\n{lines}\n")).unwrap_err();
        assert_eq!(error.place().line(), Some(11 + at), "{error}");
        error
    };
    assert_error!(linkage("angles_deg = [1, 2]", 5), MachineFileError::MissingKey { key: "linkage.positions_m", .. });
    assert_error!(linkage("positions_m = [1, 2]", 5), MachineFileError::MissingKey { key: "linkage.angles_rad", .. });
    let table = "angles_deg = [10, 20, 30]\npositions_m = ";
    assert_error!(linkage(&format!("{table}[0, 0.1]"), 5), MachineFileError::Linkage { .. });
    let back = linkage(&format!("{table}[0, 0.2, 0.1]"), 5);
    assert_eq!(
        back.to_string(),
        "machine.toml:16:2: in [linkage], entry 3 of positions_m is 0.1 m after 0.2 m; expected values that rise throughout, or fall throughout"
    );
    assert_error!(linkage(&format!("{table}[0, nan, 0.1]"), 7), MachineFileError::OutOfRange { .. });
    assert_error!(linkage(&format!("{table}[0, \"x\", 0.1]"), 7), MachineFileError::WrongType { .. });
    assert_error!(linkage("angles_deg = 7", 6), MachineFileError::WrongType { .. });
    assert_error!(linkage("angles_deg = [1]\nangles_rad = [1]", 7), MachineFileError::TwoLinkages { .. });
    let both = linkage(&format!("{table}[0, 0.1, 0.2]\nbase_m = 0.6"), 8);
    assert_error!(both, MachineFileError::TwoLinkages { .. });
    assert_error!(linkage("angle_rises = \"left\"", 6), MachineFileError::UnknownChoice { .. });
    let misspelt = linkage("angle_deg = [1]", 6);
    assert!(misspelt.to_string().contains("perhaps `linkage.angles_deg`"), "{misspelt}");
    let short = parse(&format!("{VALVE}{}", SIDES.replace("0.5", "0.05"))).unwrap_err();
    assert!(
        short.to_string().contains("no triangle with a cylinder of 0.45 m; expected from foot to eye 0.55 to 0.65 m"),
        "{short}"
    );
}

#[test]
fn a_linkage_is_saved_and_read_again() {
    for linkage in [SIDES.to_owned(), format!("{SIDES}angle_rises = \"retracting\"\n"), TABLE.to_owned()] {
        let mut file = parse(&format!("{VALVE}{linkage}")).unwrap();
        file.machine.set(Parameter::DeadZone, 0.11);
        let text = file.to_text("m").unwrap();
        assert!(text.contains(&linkage), "{text}");
        assert_eq!(parse(&text).unwrap().channels, file.channels);
        // One made in the program has it written.
        let mut made = MachineFile::from_machine("made", file.machine);
        made.given.extend(file.given.iter().copied());
        made.channels = file.channels.clone();
        for side in [Parameter::LinkageBase, Parameter::LinkageArm, Parameter::LinkageLengthRetracted] {
            if file.given.contains(&side) {
                made.machine.set(side, file.machine.get(side) * 1.000_000_1);
            }
        }
        let again = parse(&made.to_text("made").unwrap()).unwrap().channels.linkage.unwrap();
        let before = file.channels.linkage.as_ref().unwrap();
        assert!((again.angle_rad(0.1) - before.angle_rad(0.1)).abs() < 1e-5);
    }
}
