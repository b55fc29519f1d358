//! Constants for the firmware.

use super::{MACHINE, done, example, folder_with, refused, root};

#[test]
fn a_machine_file_becomes_rust_source_with_its_effects() {
    let folder = tempfile::tempdir().unwrap();
    let printed = done(folder.path(), &["export", "--machine", &example("machine.toml"), "--out", "params.rs"]);
    assert_eq!(printed, "");
    let text = std::fs::read_to_string(folder.path().join("params.rs")).unwrap();
    assert!(text.contains("pub const SOURCE: Source = Source::Valve;"), "{text}");
    assert!(text.contains("pub const TICK: Tick = Tick::OneMillisecond;"), "{text}");
    assert!(text.contains("(Parameter::AreaA, 0.003117), // cylinder.area_a_m2"), "{text}");

    let leaking = format!("{MACHINE}\n[effects.internal-leakage]\nconductance_m3_per_s_pa = 2.0e-12\n");
    std::fs::write(folder.path().join("leaking.toml"), leaking).unwrap();
    done(folder.path(), &["export", "--machine", "leaking.toml", "--tick", "2", "--out", "params.rs"]);
    let text = std::fs::read_to_string(folder.path().join("params.rs")).unwrap();
    assert!(text.contains("(Parameter::InternalLeakage, 2e-12)") && text.contains("Tick::TwoMilliseconds"), "{text}");
}

#[test]
fn the_firmwares_own_values_are_the_export_of_the_preset() {
    let folder = tempfile::tempdir().unwrap();
    let preset = root().join("presets/press-63-40.toml").display().to_string();
    done(folder.path(), &["export", "--machine", &preset, "--out", "machine.rs"]);
    let written = std::fs::read_to_string(folder.path().join("machine.rs")).unwrap();
    let committed = std::fs::read_to_string(root().join("firmware/machine.rs")).unwrap();
    assert_eq!(
        written, committed,
        "host-sim export --machine presets/press-63-40.toml --out firmware/machine.rs renews it"
    );
}

#[test]
fn a_drive_that_the_controller_cannot_hold_is_refused_by_name() {
    let machine = MACHINE.replace("[valve]", "[valve]\ntransport_delay_s = 0.8");
    let folder = folder_with(&machine, "time [s],command [V]\n0,0\n1,0\n");
    let message = refused(folder.path(), &["export", "--machine", "machine.toml", "--out", "params.rs"]);
    assert!(message.contains("machine.toml: valve.transport_delay_s = 0.8 s: needs 802 ticks"), "{message}");
}
