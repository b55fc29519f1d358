//! Constants as a C99 header, as a C compiler reads them.

use std::fmt::Write;
use std::process::Command;

use model_core::machine::Parameter;
use system_tests::at_hand::skipped;

use super::{PUMP, done, leaking_press, text};

/// Names and values of the macros, as printed by a program that includes the header; `None` without a compiler.
fn compiled(machine: &str) -> Option<(Vec<(String, u64)>, String)> {
    if Command::new("cc").arg("--version").output().is_err() {
        skipped("there is no cc");
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    let [file, header] = ["machine.toml", "params.h"].map(|name| folder.path().join(name));
    std::fs::write(&file, machine).unwrap();
    done(&["export", "--machine", text(&file), "--out", text(&header)]);
    let header = std::fs::read_to_string(header).unwrap();
    let names: Vec<&str> = header
        .lines()
        .filter_map(|line| line.strip_prefix("#define ")?.split_once(' '))
        .map(|(name, _)| name)
        .filter(|name| *name != "DRIVE_NAME")
        .collect();
    let mut program = String::from(
        "#include \"params.h\"\n#include \"params.h\"\n#include <stdint.h>\n#include <inttypes.h>\n#include <stdio.h>\n#include <string.h>\n\
         static void shown(const char *name, double value) {\n  uint64_t bits;\n  memcpy(&bits, &value, sizeof bits);\n  \
         printf(\"%s %\" PRIu64 \"\\n\", name, bits);\n}\nint main(void) {\n  puts(DRIVE_NAME);\n",
    );
    for name in names {
        writeln!(program, "  shown(\"{name}\", {name});").unwrap();
    }
    program.push_str("  return 0;\n}\n");
    std::fs::write(folder.path().join("main.c"), program).unwrap();
    let strict = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "main.c", "-o", "main"];
    let built = Command::new("cc").args(strict).current_dir(folder.path()).output().unwrap();
    assert!(built.status.success(), "{}\n{header}", String::from_utf8_lossy(&built.stderr));
    let printed = Command::new(folder.path().join("main")).output().unwrap();
    let printed = String::from_utf8(printed.stdout).unwrap();
    let (name, values) = printed.split_once('\n').unwrap();
    let value = |line: &str| {
        let (name, bits) = line.split_once(' ').unwrap();
        (name.to_owned(), bits.parse().unwrap())
    };
    Some((values.lines().map(value).collect(), name.to_owned()))
}

/// The macro of a parameter.
fn name_of(parameter: Parameter) -> String {
    let key = parameter.description().key.trim_start_matches("effects.").trim_end_matches(']');
    let letter = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_uppercase() } else { '_' };
    format!("DRIVE_{}", key.chars().map(letter).collect::<String>())
}

/// Compiles the header and compares every value in it with the drive; returns the macros' names.
fn assert_values(machine: &str) -> Option<Vec<String>> {
    let (values, name) = compiled(machine)?;
    let file = machine_file::read_text("machine.toml", machine).unwrap();
    assert_eq!(name, file.name);
    let mut held = 0;
    for &parameter in Parameter::ALL {
        if let Some((name, bits)) = values.iter().find(|(name, _)| *name == name_of(parameter)) {
            assert_eq!(*bits, file.machine.get(parameter).to_bits(), "{name}");
            held += 1;
        } else {
            // A parameter that is left out is off, or belongs to the other source of oil.
            assert!(!file.given.contains(&parameter), "{parameter:?}");
        }
    }
    assert!(held > 20, "{held}");
    let tick = values.iter().find(|(name, _)| name == "DRIVE_TICK_S").unwrap().1;
    assert_eq!(tick, 1e-3_f64.to_bits());
    Some(values.into_iter().filter(|(_, bits)| *bits != 0).map(|(name, _)| name).collect())
}

#[test]
fn a_c_compiler_reads_every_value_of_a_valve_drive_to_the_last_bit() {
    let Some(names) = assert_values(&leaking_press()) else { return };
    let has = |name: &str| names.iter().any(|known| known == name);
    assert!(has("DRIVE_SOURCE_VALVE") && !has("DRIVE_SOURCE_PUMP"), "{names:?}");
    assert!(has("DRIVE_EFFECT_INTERNAL_LEAKAGE") && !has("DRIVE_EFFECT_COULOMB_FRICTION"), "{names:?}");
    assert!(
        has("DRIVE_INTERNAL_LEAKAGE_CONDUCTANCE_M3_PER_S_PA") && has("DRIVE_VALVE_TIME_CONSTANTS_S_1"),
        "{names:?}"
    );
    // A default value that is used is written too.
    assert!(has("DRIVE_VALVE_LAMINAR_TRANSITION_PA") && !has("DRIVE_PUMP_DISPLACEMENT_M3_PER_REV"), "{names:?}");
}

#[test]
fn a_c_compiler_reads_every_value_of_a_pump_drive_with_any_name() {
    let Some(names) = assert_values(PUMP) else { return };
    assert!(names.iter().any(|name| name == "DRIVE_PUMP_DISPLACEMENT_M3_PER_REV"), "{names:?}");
}
