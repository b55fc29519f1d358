//! A machine file from a data sheet, and the way from there to a model that follows its recordings.

use std::path::Path;

use identification::compare::compare;
use identification::experiment::Prepared;
use machine_file::LoadSource;
use machine_file::data_sheet::Item;
use recording::ChannelMap;
use simulation::Arithmetic;

use super::{PRESS, done, refused, root};

#[test]
fn a_valve_that_is_driven_by_a_current_counts_in_milliamperes() {
    let folder = tempfile::tempdir().unwrap();
    // 59.35 % of travel at 40 mA.
    let by_current = PRESS.map(|word| if word == "10V" { "40mA" } else { word });
    done(folder.path(), &by_current);
    let file = machine_file::read(&folder.path().join("press.toml")).unwrap();
    let gain = file.machine.get(model_core::machine::Parameter::ValveGain);
    assert!((gain - 0.5935 / 40.0).abs() < 1e-9, "{gain}");
    // A solenoid of 800 mA: in both number types the spool goes where the current says, and does not end at a tenth of it.
    let solenoid = PRESS.map(|word| if word == "10V" { "800mA" } else { word });
    done(folder.path(), &[&solenoid[..], &["--force"]].concat());
    let row = |row: u32| format!("{},{}", f64::from(row) * 1e-3, if row < 50 { 0 } else { 700 });
    let rows: Vec<String> = (0..600).map(row).collect();
    std::fs::write(folder.path().join("run.csv"), format!("time [s],command [mA]\n{}\n", rows.join("\n"))).unwrap();
    for arithmetic in ["fixed", "float"] {
        let simulate = ["simulate", "--machine", "press.toml", "--recording", "run.csv", "--out", "out.csv"];
        done(folder.path(), &[&simulate[..], &["--arithmetic", arithmetic]].concat());
        let out = recording::read(&folder.path().join("out.csv"), &ChannelMap::default()).unwrap();
        let spool = *out.signal(recording::Signal::Spool).unwrap().last().unwrap();
        assert!((spool - 700.0 / 800.0 * 0.5935).abs() < 1e-3, "{arithmetic}: {spool}");
    }
}

#[test]
fn the_slowest_valve_that_the_model_computes_has_a_machine_file_too() {
    let folder = tempfile::tempdir().unwrap();
    // Its dead time is 150 ms.
    done(folder.path(), &PRESS.map(|word| if word == "96ms" { "3s" } else { word }));
    done(
        folder.path(),
        &["simulate", "--machine", "press.toml", "--input", "step:5V", "--tick", "0.5", "--out", "s.csv"],
    );
}

#[test]
fn a_machine_file_comes_out_of_flags_and_says_what_to_do_next() {
    let folder = tempfile::tempdir().unwrap();
    let printed = done(folder.path(), &PRESS);
    assert!(
        printed.starts_with("press.toml\nassumed    tank_pressure_pa, offset, speed_overdrive, damping, "),
        "{printed}"
    );
    assert!(printed.contains("host-sim inspect run.csv --machine press.toml"), "{printed}");
    let text = std::fs::read_to_string(folder.path().join("press.toml")).unwrap();
    for line in [
        "stroke_m = 0.3 ",
        "# given: 300 mm",
        "# derived: K_Q = Q_N/(√Δp_N·(x_N − dead zone)): 5 l/min at 5 bar over one edge",
        "bulk_modulus_pa = 1200000000.0",
        "# assumed: oil with the usual bit of air",
        "[fit.sigma]",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    assert_eq!(machine_file::read(&folder.path().join("press.toml")).unwrap().name, "press");
}

#[test]
fn a_pump_takes_the_place_of_the_valve() {
    let folder = tempfile::tempdir().unwrap();
    let pump = ["--out", "lift.toml", "--bore", "63mm", "--rod", "40mm", "--stroke", "300mm", "--mass", "40kg"];
    let more =
        ["--supply", "150bar", "--pump-displacement", "16cm3/rev", "--hose-length", "1m", "--hose-diameter", "8mm"];
    done(folder.path(), &[&["init"][..], &pump, &more].concat());
    let text = std::fs::read_to_string(folder.path().join("lift.toml")).unwrap();
    assert!(text.contains("[pump]\ndisplacement_m3_per_rev = 1.6e-5") && !text.contains("[valve]"), "{text}");
    assert!(text.contains("hose of 1 m, 8 mm"), "{text}");
}

#[test]
fn a_file_that_is_there_stays_unless_it_is_to_go() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("press.toml"), "mine").unwrap();
    let message = refused(folder.path(), &PRESS);
    assert!(message.contains("press.toml is there already") && message.contains("--force"), "{message}");
    assert_eq!(std::fs::read_to_string(folder.path().join("press.toml")).unwrap(), "mine");
    done(folder.path(), &[&PRESS[..], &["--force"]].concat());
    assert!(std::fs::read_to_string(folder.path().join("press.toml")).unwrap().contains("[valve]"));
}

#[test]
fn the_help_marks_what_is_required_and_names_the_rest() {
    let folder = tempfile::tempdir().unwrap();
    let help = done(folder.path(), &["init", "--help"]);
    let manual = done(folder.path(), &["man", "init"]).replace('\\', "").replace("*(Aq", "'");
    for item in Item::ALL {
        let question = item.question();
        let heading = help.split_once(&format!("--{} <", question.flag)).map(|(before, _)| {
            before.lines().rfind(|line| line.ends_with(':') && !line.starts_with(' ')).unwrap().trim_end_matches(':')
        });
        let expected = match (item.is_needed(false), item.is_needed(true)) {
            (true, true) => Some("Cylinder, load and supply (required)"),
            (true, false) => Some("Valve (required)"),
            (false, true) => Some("Pump in place of a valve"),
            (false, false) if question.flag.starts_with("valve-") && heading.is_some() => {
                Some("Speed of the valve (one is required)")
            }
            (false, false) => None,
        };
        assert_eq!(heading, expected, "{}", question.flag);
        assert!(help.contains(&format!("--{}", question.flag)), "{}", question.flag);
        assert!(manual.contains(&format!("{} [", question.what)), "{}", question.flag);
    }
}

#[test]
fn without_a_terminal_every_missing_flag_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let message = refused(folder.path(), &["init", "--bore", "63mm", "--stroke", "0.3m"]);
    for flag in ["--rod", "--mass", "--supply", "--rated-flow", "--rated-drop", "--rated-signal", "--valve-response"] {
        assert!(message.contains(&format!("{flag} ")), "{flag}: {message}");
    }
    assert!(!message.contains("--bore") && !message.contains("--stroke "), "{message}");
}

#[test]
fn answers_that_make_no_sense_are_refused_with_what_would() {
    let folder = tempfile::tempdir().unwrap();
    for (extra, found, expected) in [
        (&["--bore", "63bar"][..], "`bar` is not a unit of this quantity\n", "one of m, mm, such as `63mm`"),
        (&["--bore", "63"], "`63` has no unit", "one of m, mm"),
        (&["--bore=-63mm"], "-63mm", "more than 0"),
        (&["--rod", "80mm"], "--rod 80 mm in --bore 63 mm", "a rod thinner than the piston"),
        (&["--hose-length", "1m"], "--hose-length without --hose-diameter", "both or neither"),
        (&["--pump-displacement", "16cm3/rev"], "--rated-flow beside --pump-displacement", "a valve or a pump"),
        (&["--mass", "1e30kg"], "`cylinder.moving_mass_kg` is 1e30", ""),
    ] {
        // A flag that is given twice is refused by its name: so the first one is removed.
        let flag = extra[0].split('=').next().unwrap();
        let kept: Vec<&str> = match PRESS.iter().position(|known| *known == flag) {
            Some(at) => [&PRESS[..at], &PRESS[at + 2..]].concat(),
            None => PRESS.to_vec(),
        };
        let message = refused(folder.path(), &[kept.as_slice(), extra].concat());
        assert!(message.contains(found) && message.contains(&format!("expected: {expected}")), "{extra:?}: {message}");
    }
}

#[test]
fn from_data_sheet_to_the_noise_floor() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &PRESS);
    let preset = root().join("presets/press-63-40-installed.toml").display().to_string();
    let testbed = ["testbed", "--machine", &preset, "--out", "case", "--tick", "2", "--seed", "5"];
    let commands =
        ["--train", "random:8V,0.08s,0.5s,3s,seed=1", "--train", "steps:7V", "--holdout", "sweep:6V,0.5Hz,4Hz,3s"];
    done(folder.path(), &[&testbed[..], &commands].concat());

    let inspected = done(folder.path(), &["inspect", "case/train-1.csv", "--machine", "press.toml"]);
    assert_eq!(inspected.matches("alone: driven by").count(), 5, "{inspected}");
    let simulate = ["simulate", "--machine", "press.toml", "--recording", "case/train-1.csv", "--out", "simulated.csv"];
    done(folder.path(), &simulate);
    let fit = [
        "fit",
        "--machine",
        "press.toml",
        "--train",
        "case/train-1.csv",
        "case/train-2.csv",
        "--save-machine",
        "fitted.toml",
    ];
    let printed = done(folder.path(), &fit);
    assert!(printed.contains("\nWhat is left: ") && !printed.contains("more than noise"), "{printed}");

    let before = misses(folder.path(), "press.toml");
    let after = misses(folder.path(), "fitted.toml");
    assert_eq!(after.len(), 4);
    for ((signal, before), (_, after)) in before.iter().zip(&after) {
        println!("{signal}: {before:.1} → {after:.2} times the noise");
        assert!(*after < 1.5 && before > after, "{signal} misses {after} times its noise, {before} before");
    }
    let text = std::fs::read_to_string(folder.path().join("fitted.toml")).unwrap();
    assert!(text.contains("# assumed: oil with the usual bit of air"), "the comments stay: {text}");
}

/// The model's misfit for each signal of the held-out recording, in standard deviations of the sensor's noise.
fn misses(folder: &Path, machine: &str) -> Vec<(String, f64)> {
    let file = machine_file::read(&folder.join(machine)).unwrap();
    let held_out = recording::read(&folder.join("case/holdout-1.csv"), &ChannelMap::default()).unwrap();
    let prepared = Prepared::new(&held_out, &file.machine, LoadSource::Constant, None).unwrap();
    let comparison = compare(&file.machine, LoadSource::Constant, &held_out, Arithmetic::Float, None).unwrap();
    let fits = &comparison.sections[0].fits;
    let noise = |signal| prepared.channels.iter().find(|channel| channel.signal == signal).unwrap().noise;
    fits.iter().map(|fit| (fit.signal.to_string(), fit.rmse / noise(fit.signal))).collect()
}
