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
    for more in [&[][..], &["--bake"]] {
        let arguments = [&["export", "--machine", "machine.toml", "--out", "params.rs"], more].concat();
        let message = refused(folder.path(), &arguments);
        assert!(message.contains("machine.toml: valve.transport_delay_s = 0.8 s: needs 802 ticks"), "{message}");
        assert!(!folder.path().join("params.rs").exists());
    }
}

#[test]
fn a_baked_drive_has_its_coefficients_as_words_and_its_values_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let machine = example("machine.toml");
    done(folder.path(), &["export", "--machine", &machine, "--out", "plain.rs"]);
    done(folder.path(), &["export", "--machine", &machine, "--bake", "--out", "params.rs"]);
    let [plain, baked] =
        ["plain.rs", "params.rs"].map(|file| std::fs::read_to_string(folder.path().join(file)).unwrap());
    let coefficients = baked.strip_prefix(&plain).expect("the values come first, as without --bake");
    assert!(coefficients.contains("impl model_core::drive::Baked for Exported {"), "{coefficients}");
    // 0.0559/V times 10 V, in steps of 2⁻²⁸.
    assert!(coefficients.contains("gain: FixedI32::from_bits(150055420),"), "{coefficients}");
    let printed = done(folder.path(), &["export", "--machine", &machine, "--bake", "--format", "rust", "--out", "-"]);
    assert_eq!(printed, baked);
}

#[test]
fn a_drive_is_baked_in_single_precision_too() {
    let folder = tempfile::tempdir().unwrap();
    let machine = example("machine.toml");
    let baked = |number: &[&str]| {
        let bake = ["export", "--machine", &machine, "--bake", "--format", "rust", "--out", "-"];
        done(folder.path(), &[&bake, number].concat())
    };
    let [fixed, single] = [baked(&[]), baked(&["--number", "f32"])];
    assert_eq!(baked(&["--number", "fixed"]), fixed);
    assert!(single.contains("    type Number = model_core::number::Single;\n"), "{single}");
    assert!(!single.contains("from_bits"), "{single}");
    // 0.0559/V times 10 V, the word in single precision nearest to it, in the fewest digits.
    assert!(single.contains("gain: 0.559,"), "{single}");
    let line = |text: &str, start: &str| text.lines().find(|line| line.starts_with(start)).unwrap().to_owned();
    let [fixed, single] = [fixed, single].map(|text| {
        ["pub const FINGERPRINT: u32 = ", "pub const VALUES: ", "pub const STATE_BYTES: "]
            .map(|start| line(&text, start))
    });
    assert_ne!(fixed[0], single[0]);
    assert_eq!(fixed[1], single[1]);
}

#[test]
fn single_precision_is_refused_where_nothing_is_baked_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let machine = example("machine.toml");
    let only_baked = ("--number: only a baked drive has it", "= expected: --bake");
    let only_fixed =
        ("--number f32: the library for C has fixed point alone", "= expected: --out with .rs, or --number fixed");
    for (more, (said, expected)) in [
        (&["--out", "params.rs"][..], only_baked),
        (&["--out", "drive.fmu"], only_baked),
        (&["--bake", "--out", "drive.h"], only_fixed),
    ] {
        let arguments = [&["export", "--machine", &machine, "--number", "f32"], more].concat();
        let message = refused(folder.path(), &arguments);
        assert!(message.contains(said) && message.contains(expected), "{message}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

#[test]
fn an_fmu_is_not_baked() {
    let folder = tempfile::tempdir().unwrap();
    let machine = example("machine.toml");
    let message = refused(folder.path(), &["export", "--machine", &machine, "--bake", "--out", "drive.fmu"]);
    let expected = ["--bake: only Rust and C have it", "expected: --out with .rs or .h"];
    assert!(expected.iter().all(|part| message.contains(part)), "{message}");
    assert!(!folder.path().join("drive.fmu").exists());
}

#[test]
fn an_fmu_follows_the_version_that_was_asked_for_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("library"), "fmi2Instantiate fmi3InstantiateCoSimulation").unwrap();
    let machine = example("machine.toml");
    let exported = |fmi: &[&str]| {
        let export = ["export", "--machine", &machine, "--library", "library", "--out", "drive.fmu", "--json", "-"];
        let printed = done(folder.path(), &[&export, fmi].concat());
        let document: serde_json::Value = serde_json::from_str(&printed).unwrap();
        (document["fmi"].as_str().unwrap().to_owned(), std::fs::read(folder.path().join("drive.fmu")).unwrap())
    };
    let [three, two] = [exported(&[]), exported(&["--fmi", "2.0"])];
    assert_eq!((three.0.as_str(), two.0.as_str()), ("3.0", "2.0"));
    assert!(three.1 != two.1);
    assert!(exported(&["--fmi", "2"]) == two && exported(&["--fmi", "3"]) == three);
    let message = refused(folder.path(), &["export", "--machine", &machine, "--fmi", "2.0", "--out", "params.rs"]);
    assert!(message.contains("--fmi: only an FMU has it"), "{message}");
}
