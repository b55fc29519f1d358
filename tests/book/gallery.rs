//! The gallery: what each effect does to the signal that shows it most, simulated and drawn by the tool, with what it is at the machine.

use std::fmt::Write;
use std::fs;

use diagnosis::catalogue::{CATALOGUE, Hypothesis};
use experiment::standard_tests::{StandardTest, standard_tests};
use machine_file::{LoadSource, MachineFile};
use model_core::effects::Effect;
use model_core::machine::{Machine, Parameter, Tick};
use recording::display_unit::unit_for_people;
use recording::{Column, Recording, Signal};
use report::plot::{Panel, Style, Trace, svg};
use report::wording::cause;
use simulation::{InputPoint, StartOffset, Stimulus, Trajectory, simulate_f64};
use system_tests::snapshot;

use super::effects::{press, scene, strong, table_of};
use super::root;

const HEAD: &str = "\
# Gallery

Each effect in one picture: the signal that shows it most, without the effect (orange) and with it (blue), and below the difference. The drive is
[the press](../presets/press-63-40.toml) in a test that `diagnose` also proposes, the effect is strong, but of [usual size](effects.md);
pump slip is shown on a small cylinder that a pump moves.

*Drawn and written by `RENEW=1 cargo test -p system-tests --test book gallery`.*

A finding's page of each: make a case that has the effect and diagnose it; the name and strength are those of the effect's section, here the internal leakage.

```sh
host-sim testbed --machine presets/press-63-40.toml --train \"steps:6V\" --train \"sweep:4V\" --holdout \"random:6V\" --effect internal-leakage=2e-12 --out case
host-sim diagnose case --report case.html
```
";

/// Largest command of the tests, V.
const LARGEST_V: f64 = 6.0;
/// What is drawn of a test, s.
const WINDOW_S: f64 = 1.6;
/// What a difference is counted in: the usual noise of a sensor, in SI units.
const NOISE: [(Signal, f64); 4] =
    [(Signal::Spool, 5e-4), (Signal::PressureA, 3e4), (Signal::PressureB, 3e4), (Signal::Position, 5e-5)];

/// A drive in a test, without and with the effect.
struct Pair {
    how: String,
    time_s: Vec<f64>,
    without: Trajectory,
    with: Trajectory,
}

/// The part of a signal in a test that shows the effect most.
struct Picture<'a> {
    pair: &'a Pair,
    signal: Signal,
    rows: std::ops::Range<usize>,
    over_noise: f64,
}

fn pair(test: &StandardTest, without: &Machine<f64>, with: &Machine<f64>) -> Option<Pair> {
    let simulated = |machine: &Machine<f64>| {
        simulate_f64(machine, &test.stimulus(machine, Tick::OneMillisecond)?, StartOffset::none()).ok()
    };
    let time_s = (0..test.command_v.len()).map(|row| row as f64 * test.interval_s).collect();
    let how = format!("{}: {}", test.name, test.how);
    Some(Pair { how, time_s, without: simulated(without)?, with: simulated(with)? })
}

/// The pump of the recordings of a pump-controlled cylinder, one stroke out and in against a load.
fn pumped(effect: &Hypothesis) -> Pair {
    let text = fs::read_to_string(root().join("tests/diagnosis/eha.toml")).unwrap();
    let text = text.replace("source = \"recorded-pressures\"", "source = \"constant\"");
    let read = |text: &str| machine_file::read_text("pump.toml", text).unwrap().machine;
    let (without, with) =
        (read(&text), read(&format!("{text}\n[effects.{}]\nconductance_m3_per_s_pa = 6e-13\n", effect.name)));
    let time_s: Vec<f64> = (0..1000).map(|row| f64::from(row) * 2e-3).collect();
    let speed = time_s.iter().map(|time| if *time < 0.1 || *time > 1.5 { 0.0 } else { 20.0 }).collect();
    let direction = time_s.iter().map(|time| if *time < 0.1 || *time > 1.5 { 0.0 } else { 1.0 }).collect();
    let columns = vec![
        Column::si(Signal::Time, time_s.clone()),
        Column::si(Signal::PumpSpeed, speed),
        Column::si(Signal::ValveDirection, direction),
        Column::si(Signal::LoadForce, vec![-8e3; time_s.len()]),
        Column::si(Signal::Position, vec![0.01; time_s.len()]),
    ];
    let recording = Recording::new("stroke", columns).unwrap();
    let simulated = |machine: &Machine<f64>| {
        let stimulus =
            Stimulus::new(&recording, machine, InputPoint::Pump, LoadSource::Constant, Tick::OneMillisecond).unwrap();
        simulate_f64(machine, &stimulus, StartOffset::none()).unwrap()
    };
    let how = "one stroke against 8 kN, pump at 20 rev/s".to_owned();
    Pair { how, time_s, without: simulated(&without), with: simulated(&with) }
}

/// What changes, and a hundredth of what is constant: a sensor's offset has nothing else.
fn shown(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count + 0.01 * mean.powi(2)
}

/// Of one signal in one test: the window in which the difference changes most.
fn picture(pair: &Pair, signal: Signal, noise: f64) -> Option<Picture<'_>> {
    let (without, with) = (pair.without.signal(signal)?, pair.with.signal(signal)?);
    let length = pair.time_s.iter().take_while(|time| **time < WINDOW_S).count();
    let off: Vec<f64> = without.iter().zip(with).map(|(one, other)| other - one).collect();
    // What changes in a window shows more than what is constant there; a pressure below 0 that no floor holds shows nothing that a drive does.
    let tearing = |rows: std::ops::Range<usize>| {
        let pressures = [Signal::PressureA, Signal::PressureB].map(|pressure| pair.with.signal(pressure));
        pressures.into_iter().flatten().any(|values| values[rows.clone()].iter().any(|pa| *pa < -1.01e5))
    };
    let starts = (0..=pair.time_s.len() - length).step_by(length / 8).filter(|from| !tearing(*from..from + length));
    let windows = starts.map(|from| (from, shown(&off[from..from + length])));
    let (from, mean) = windows.max_by(|one, other| one.1.total_cmp(&other.1))?;
    // The position goes on missing what was missed once: it tells less than its size.
    let weight = if signal == Signal::Position { 0.1 } else { 1.0 };
    Some(Picture { pair, signal, rows: from..from + length, over_noise: weight * mean.sqrt() / noise })
}

/// A stroke while a load pulls harder than the oil pushes: what none of the standard tests asks for.
fn pulled(machine: &Machine<f64>) -> StandardTest {
    let rows = 800;
    let load_n = 1.3 * machine.get(Parameter::SupplyPressure) * machine.get(Parameter::AreaB);
    let during = |rows_of: std::ops::Range<usize>, value: f64| {
        (0..rows).map(|row| if rows_of.contains(&row) { value } else { 0.0 }).collect()
    };
    StandardTest {
        name: "pulled stroke",
        how: format!("{LARGEST_V} V while a load pulls with 1.3 times the full force of B"),
        interval_s: 2e-3,
        command_v: during(100..250, LARGEST_V),
        load_n: during(100..400, load_n),
    }
}

fn pairs(effect: &Hypothesis, file: &MachineFile) -> Vec<Pair> {
    if effect.name == Effect::PumpSlip.name() {
        return vec![pumped(effect)];
    }
    let preset = fs::read_to_string(root().join("presets/press-63-40.toml")).unwrap();
    let with =
        machine_file::read_text("with.toml", &format!("{preset}\n{}", table_of(effect, &scene(file), strong))).unwrap();
    let mut tests = standard_tests(&file.machine, LARGEST_V);
    tests.push(pulled(&file.machine));
    tests.iter().filter_map(|test| pair(test, &file.machine, &with.machine)).collect()
}

fn drawn(effect: &Hypothesis, picture: &Picture<'_>) -> String {
    let unit = unit_for_people(picture.signal);
    let values = |of: &Trajectory| -> Vec<f64> {
        let values = of.signal(picture.signal).unwrap();
        values[picture.rows.clone()].iter().map(|value| unit.from_si(*value)).collect()
    };
    let (without, with) = (values(&picture.pair.without), values(&picture.pair.with));
    let difference = with.iter().zip(&without).map(|(with, without)| with - without).collect();
    let name = picture.signal.name().replace("pressure_a", "pressure A").replace("pressure_b", "pressure B");
    let symbol = if picture.signal == Signal::Spool { "% of travel" } else { unit.symbol() };
    let time_s = picture.pair.time_s[picture.rows.clone()].to_vec();
    let both = Panel { points: Some(300), ..Panel::new(&name, symbol, time_s.clone()) }
        .trace(Trace::new("without", without, Style::Before))
        .trace(Trace::new("with", with, Style::After));
    let difference = Panel { points: Some(300), ..Panel::new("with − without", symbol, time_s) }.trace(Trace::new(
        "difference",
        difference,
        Style::After,
    ));
    svg(effect.name, &picture.pair.how, &[both, difference])
}

#[test]
fn the_gallery_is_what_the_tool_draws() {
    let file = press();
    let mut page = HEAD.to_owned();
    for effect in CATALOGUE {
        let pairs = pairs(effect, &file);
        let all = pairs.iter().flat_map(|pair| NOISE.map(|(signal, noise)| picture(pair, signal, noise))).flatten();
        let best = all.max_by(|one, other| one.over_noise.total_cmp(&other.over_noise)).unwrap();
        assert!(best.over_noise > 1.0, "{}: {} of the noise in {}", effect.name, best.over_noise, best.pair.how);
        let picture = format!("figures/gallery/{}.svg", effect.name);
        snapshot::compare(&format!("../docs/{picture}"), &drawn(effect, &best), |found, kept| found == kept);
        let told = cause(Effect::named(effect.name).unwrap());
        writeln!(page, "\n## {}\n\n![{} in {}]({picture})\n", effect.name, effect.name, best.signal.name()).unwrap();
        writeln!(page, "*In the machine:* {}. *Seen:* {}.\n*Check:* {}.\n", told.happens, told.seen, told.check)
            .unwrap();
        writeln!(page, "[Equation, parameters, what looks alike](effects.md#{})", effect.name).unwrap();
    }
    snapshot::compare("../docs/gallery.md", &page, |found, kept| found == kept);
}
