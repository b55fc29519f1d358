//! A machine file that `init` writes is taken by every other command, whatever a data sheet says.

use std::cell::Cell;
use std::f64::consts::PI;
use std::fs;

use clap::Parser;
use proptest::option::of;
use proptest::prelude::*;
use proptest::sample::select;
use proptest::test_runner::{Config, TestRunner};

use host_sim::cli::{self, Cli, Console, Outcome};
use machine_file::data_sheet::Item;

use super::cases;

/// What is printed, or the error.
fn run(arguments: &[String]) -> Result<String, String> {
    let line = ["host-sim", "--quiet"].into_iter().chain(arguments.iter().map(String::as_str));
    let cli = Cli::try_parse_from(line).map_err(|error| error.to_string())?;
    let mut out = Vec::new();
    match cli::run(&cli.command, &mut Console::into_buffer(&mut out)) {
        Ok(Outcome::Done) => Ok(String::from_utf8_lossy(&out).into_owned()),
        Ok(other) => Err(format!("{other:?}")),
        Err(error) => Err(error.render()),
    }
}

/// A number of a data sheet, anywhere between two sizes of a catalogue, with three digits.
fn between(least: f64, most: f64) -> impl Strategy<Value = f64> {
    (least.ln()..most.ln()).prop_map(f64::exp)
}

fn flag(item: Item, value: f64, unit: &str) -> String {
    format!("--{}={value:.3e}{unit}", item.question().flag)
}

/// Density of steel, kg/m³.
const STEEL_KG_PER_M3: f64 = 7850.0;

/// A cylinder from a valve's pilot to a press's: its area A in m², and its flags. A mass is at least half of its own rod and piston.
fn cylinder() -> impl Strategy<Value = (f64, Vec<String>)> {
    let sizes = (between(10.0, 500.0), 0.2..0.85, between(0.5, 30.0), between(10.0, 420.0));
    let parts = (between(0.5, 500.0), of(between(0.02, 1.0)), of(between(0.001, 0.5)), of(between(0.001, 0.6)));
    let hose = of((between(0.1, 20.0), between(0.05, 0.3)));
    (sizes, parts, hose, of(between(200.0, 2200.0))).prop_map(
        |((bore_mm, rod, strokes, supply_bar), (masses, dead, friction, load), hose, modulus)| {
            let (bore_m, stroke_mm) = (1e-3 * bore_mm, strokes * bore_mm);
            let area_m2 = PI / 4.0 * bore_m * bore_m;
            let (swept_m3, full_n) = (1e-3 * stroke_mm * area_m2, 1e5 * supply_bar * area_m2);
            let own_kg = STEEL_KG_PER_M3 * (0.5 * bore_m * area_m2 + rod * rod * swept_m3);
            let hose = hose.map(|(length_m, bore)| {
                [flag(Item::HoseLength, length_m, "m"), flag(Item::HoseDiameter, bore * bore_mm, "mm")]
            });
            let needed = [
                flag(Item::Bore, bore_mm, "mm"),
                flag(Item::Rod, rod * bore_mm, "mm"),
                flag(Item::Stroke, stroke_mm, "mm"),
                flag(Item::Mass, masses * own_kg, "kg"),
                flag(Item::Supply, supply_bar, "bar"),
            ];
            let further = [
                dead.map(|share| flag(Item::DeadVolume, 1e6 * share * swept_m3, "cm3")),
                friction.map(|share| flag(Item::Friction, share * full_n, "N")),
                load.map(|share| flag(Item::Load, share * full_n, "N")),
                modulus.map(|modulus_mpa| flag(Item::BulkModulus, modulus_mpa, "MPa")),
            ];
            (
                area_m2,
                needed.into_iter().chain(further.into_iter().flatten()).chain(hose.into_iter().flatten()).collect(),
            )
        },
    )
}

/// A column of commands and their largest, the rod's speed in m/s at the rated flow, the supply's limit over that flow, and the other flags.
fn valve() -> impl Strategy<Value = ((&'static str, f64), f64, Option<f64>, Vec<String>)> {
    let slow = prop_oneof![
        between(1.0, 500.0).prop_map(|ms| vec![flag(Item::ValveResponse, ms, "ms")]),
        between(1.0, 500.0).prop_map(|hz| vec![flag(Item::ValveFrequency, hz, "Hz")]),
        (between(2.0, 500.0), 30.0..200.0).prop_map(|(hz, percent)| vec![
            flag(Item::NaturalFrequency, hz, "Hz"),
            flag(Item::ValveDamping, percent, "%")
        ]),
    ];
    let signal = prop_oneof![
        between(1.0, 24.0).prop_map(|volts| (("command [V]", volts), flag(Item::RatedSignal, volts, "V"))),
        between(4.0, 3000.0).prop_map(|most| (("command [mA]", most), flag(Item::RatedSignal, most, "mA"))),
    ];
    let over = select(vec!["edge", "both"]).prop_map(|over| format!("--rated-drop-over={over}"));
    let further = (of(between(0.1, 40.0)), of(between(30.0, 100.0)), of(between(1.0, 500.0)));
    (signal, (between(0.005, 2.0), between(1.0, 70.0), of(between(0.3, 3.0))), over, slow, further).prop_map(
        |((column, signal), (speed_m_per_s, drop_bar, limit), over, slow, (overlap, at_rated, time))| {
            let further = [
                overlap.map(|percent| flag(Item::Overlap, percent, "%")),
                at_rated.map(|percent| flag(Item::SpoolAtRated, percent, "%")),
                time.map(|ms| flag(Item::ValveStrokeTime, ms, "ms")),
            ];
            let needed = [signal, flag(Item::RatedDrop, drop_bar, "bar"), over];
            let flags = needed.into_iter().chain(slow).chain(further.into_iter().flatten()).collect();
            (column, speed_m_per_s, limit, flags)
        },
    )
}

/// A column of what drives it and its largest value, and the flags.
fn sheet() -> impl Strategy<Value = ((&'static str, f64), Vec<String>)> {
    let by_valve = (cylinder(), valve()).prop_map(|((area_m2, cylinder), (column, speed_m_per_s, limit, valve))| {
        let flow = 6e4 * area_m2 * speed_m_per_s;
        let flows = [
            Some(flag(Item::RatedFlow, flow, "l/min")),
            limit.map(|times| flag(Item::FlowLimit, times * flow, "l/min")),
        ];
        (column, [cylinder, valve, flows.into_iter().flatten().collect()].concat())
    });
    let by_pump = (cylinder(), between(0.005, 1.0)).prop_map(|((area_m2, cylinder), speed_m_per_s)| {
        let pump = flag(Item::PumpDisplacement, 1e6 * area_m2 * speed_m_per_s / 25.0, "cm3/rev");
        (("pump_speed [rpm]", 1500.0), [cylinder, vec![pump]].concat())
    });
    prop_oneof![4 => by_valve, 1 => by_pump]
}

/// What drives it, as a logger writes it: to and fro, with pauses, up to most of what the data sheet names.
fn recording(header: &str, most: f64) -> String {
    let row = |row: u32| {
        let time_s = f64::from(row) * 2e-3;
        let level = [0.0, 0.4, 0.0, -0.4, 0.8, 0.0, -0.8][(row / 150) as usize % 7];
        format!("{time_s:.3},{:.6}", level * most)
    };
    let rows: Vec<String> = (0..1050).map(row).collect();
    format!("time [s],{header}\n{}\n", rows.join("\n"))
}

/// Commands that take the machine file in a folder, one after the other: some read what an earlier one wrote. Not `testbed`, which refuses what
/// drives the rod to an end of its stroke.
const COMMANDS: [&str; 12] = [
    "simulate --machine M --recording @run.csv --out @train-1.csv",
    "simulate --machine M --recording @run.csv --out @float.csv --arithmetic float",
    "inspect @train-1.csv --machine M",
    "compare @train-1.csv --machine M",
    "compare @float.csv --machine M --arithmetic float",
    "fit @train-1.csv --machine M --save-machine @fitted.toml",
    "simulate --machine @fitted.toml --recording @run.csv --out @again.csv",
    "diagnose --machine M --train @train-1.csv --time-limit 1 --save-machine @found.toml",
    "simulate --machine @found.toml --recording @run.csv --out @further.csv",
    "export --machine M --out @params.rs",
    "export --machine M --out @params.h",
    "export --machine M --bake --out @drive.rs",
];
/// Those of a valve alone; the second one takes as long as all others together, and is asked once.
const OF_VALVES: [&str; 2] = [
    "simulate --machine M --input steps:4V --out @steps.csv",
    "plan --machine M --sensors position,pressure_a,pressure_b",
];

/// Of a drive that is too fast for the model, `init` says so; what it writes is taken.
#[test]
fn what_init_writes_every_command_takes() {
    let (tried, written, planned) = (Cell::new(0), Cell::new(0), Cell::new(false));
    // Each case is a dozen commands, and a failing sheet is as good as a smaller one.
    let config = Config { max_shrink_iters: 0, source_file: Some(file!()), ..cases(3) };
    let law = TestRunner::new(config).run(&sheet(), |((header, most), flags)| {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).display().to_string();
        let machine = path("machine.toml");
        tried.set(tried.get() + 1);
        let init = [vec!["init".to_owned(), format!("--out={machine}")], flags.clone()].concat();
        if let Err(error) = run(&init) {
            println!("{}: {error}", flags.join(" "));
            return Ok(());
        }
        written.set(written.get() + 1);
        fs::write(path("run.csv"), recording(header, most)).unwrap();
        let of_valves = if header.starts_with("pump") { 0 } else { 1 + usize::from(!planned.replace(true)) };
        for command in COMMANDS.iter().chain(&OF_VALVES[..of_valves]) {
            let word = |word: &str| match (word, word.strip_prefix('@')) {
                ("M", _) => machine.clone(),
                (_, Some(name)) => path(name),
                (word, None) => word.to_owned(),
            };
            let outcome = run(&command.split(' ').map(word).collect::<Vec<_>>());
            prop_assert!(outcome.is_ok(), "init {}\n{command}\n{}", flags.join(" "), outcome.unwrap_err());
        }
        Ok(())
    });
    law.unwrap();
    println!("{} of {} data sheets make a machine file", written.get(), tried.get());
    assert!(4 * written.get() > 3 * tried.get(), "{} of {}", written.get(), tried.get());
}

/// A press whose supply gives this much and whose oil is this stiff, MPa.
fn press(flow_limit: &str, modulus_mpa: f64) -> Vec<String> {
    let sheet = "--bore=63mm --rod=40mm --stroke=300mm --mass=18.3kg --supply=70bar --rated-flow=5l/min --rated-drop=5bar --rated-signal=10V \
                 --valve-response=20ms";
    let own = [format!("--flow-limit={flow_limit}"), format!("--bulk-modulus={modulus_mpa}MPa")];
    sheet.split_whitespace().map(str::to_owned).chain(own).collect()
}

/// What a fit of a drive saves, at the tick that it was fitted at or names: the commands without --tick take the tick that computes it.
const OF_FITTED: [&str; 3] = [
    "simulate --machine @fitted.toml --recording @run.csv --out @again.csv",
    "simulate --machine @fitted.toml --input step:4V,0.1s --out @step.csv",
    "compare @train.csv --machine @fitted.toml",
];

/// Oil that was recorded stiffer than the file says, up to a spring that a tick of 1 ms does not compute; and a supply of next to nothing, whose
/// tolerances no format holds.
#[test]
fn what_a_fit_saves_every_command_takes() {
    for (flow_limit, mass_kg, tick) in [("18l/min", 0.6, "1"), ("18l/min", 0.4, "0.5"), ("0.01l/min", 18.3, "1")] {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).display().to_string();
        let command = |line: &str| {
            let word = |word: &str| word.strip_prefix('@').map_or_else(|| word.to_owned(), path);
            run(&line.split(' ').map(word).collect::<Vec<_>>())
        };
        let written = |name: &str, modulus_mpa: f64| {
            let out = path(name);
            run(&[vec!["init".to_owned(), format!("--out={out}")], press(flow_limit, modulus_mpa)].concat()).unwrap();
            let text = fs::read_to_string(&out).unwrap();
            let mass = text.lines().find(|line| line.starts_with("moving_mass_kg")).unwrap();
            fs::write(&out, text.replace(mass, &format!("moving_mass_kg = {mass_kg:?}"))).unwrap();
        };
        written("machine.toml", 1200.0);
        written("stiff.toml", 2200.0);
        let rows: Vec<String> = recording("command [V]", 10.0).lines().take(420).map(str::to_owned).collect();
        fs::write(path("run.csv"), rows.join("\n")).unwrap();
        command("simulate --machine @stiff.toml --recording @run.csv --out @train.csv --arithmetic float").unwrap();
        let fitted =
            command(&format!("fit @train.csv --machine @machine.toml --tick {tick} --save-machine @fitted.toml"));
        let of = format!("{flow_limit}, {mass_kg} kg, {tick} ms");
        fitted.unwrap_or_else(|error| panic!("{of}: {error}"));
        let export = format!("export --machine @fitted.toml --tick {tick} --out @params.rs");
        for line in OF_FITTED.into_iter().chain([export.as_str()]) {
            let outcome = command(line);
            assert!(outcome.is_ok(), "{of}\n{line}\n{}", outcome.unwrap_err());
        }
    }
}
