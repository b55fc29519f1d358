//! A plan as the firmware plays it, around the virtual test bed: what the recorder holds is imported, and diagnosed.
//!
//! It is the firmware's own desk, typed at, over devices that are the test bed's sensors and its valve.

use std::cell::Cell;
use std::path::Path;
use std::rc::Rc;

use diagnosis::{Diagnosis, Verdict, diagnose};
use firmware::app::{Assembly, Desk, press};
use firmware::commissioning::Note;
use firmware::io::{AnalogIn, AnalogOut, FromFn, PositionIn};
use firmware::monitor::Miss;
use firmware::period::{Devices, Place, Timing};
use firmware::set_point::SetPoint;
use firmware::supervision::{Fault, Log, Mode};
use host_sim::frames;
use machine_file::{LoadSource, MachineFile};
use model_core::number::{Number, PerUnit};
use recording::{ChannelMap, Recording, Signal};
use simulation::{InputPoint, StartOffset, Stimulus, rows_f64};
use system_tests::rig::{Controller, Readings, Rig, TICK, Wanted};
use virtual_plant::sensor::sensors::PositionSensor;
use virtual_plant::{PlantEffect, Sensors};

/// Spans of the converters, µV per 2¹⁶ counts.
const INPUT_UV: u32 = 5_120_000;
const OUTPUT_UV: u32 = 20_000_000;
/// Where the rod stands, m.
const START_M: f64 = 0.15;
/// What is typed, and in which period: three times the plan, from three places, each with its record.
const TYPED: [(usize, &str); 10] = [
    (200, "fi"),
    (400, "n"),
    (2500, "4e"),
    (8500, "d152g"),
    (11_400, "n"),
    (13_500, "4e"),
    (19_500, "d147g"),
    (22_400, "n"),
    (24_500, "4e"),
    (30_500, "d"),
];
const PERIODS: usize = 31_000;

/// Counts at the nearest step.
#[expect(clippy::cast_possible_truncation, reason = "some 100 000 counts at most")]
fn counts(value: f64) -> i32 {
    value.round() as i32
}

/// The devices' side of the machine.
#[derive(Default)]
struct Wires {
    seen: Cell<Readings>,
    output: Cell<i32>,
}

impl Wires {
    fn input(&self, channel: u8) -> i32 {
        let Readings { spool, pressure_a_pa, pressure_b_pa, .. } = self.seen.get();
        let pressure_v = |pressure_pa: f64| 0.5 + 4.0 * pressure_pa / press::PRESSURE_AT_4_5_V_PA;
        let volts = match channel {
            1 => 10.0 * spool / press::SPOOL_AT_10_V,
            2 => pressure_v(pressure_a_pa),
            _ => pressure_v(pressure_b_pa),
        };
        counts(volts * 65_536.0 / (1e-6 * f64::from(INPUT_UV)))
    }

    fn command_v(&self) -> f64 {
        f64::from(self.output.get()) / 65_536.0 * 1e-6 * f64::from(OUTPUT_UV)
    }
}

/// The desk, what is typed at it, and what it has sent.
struct Typist<'a, A, P, O> {
    wires: Rc<Wires>,
    desk: Desk<'a, A, P, O>,
    at: usize,
    told: Told,
    sent: Vec<u8>,
}

#[derive(Default)]
struct Told(Vec<Fault>);

impl Log for Told {
    fn fault(&mut self, fault: &Fault) {
        self.0.push(*fault);
    }
    fn mode(&mut self, _: Mode, _: Mode) {}
    fn alarm(&mut self, _: &Miss) {}
    fn commissioning(&mut self, _: &Note) {}
}

impl<A: AnalogIn, P: PositionIn, O: AnalogOut> Controller for Typist<'_, A, P, O> {
    fn command_v(&mut self, _: Wanted, seen: &Readings) -> f64 {
        self.wires.seen.set(*seen);
        let keys = TYPED.iter().find(|(at, _)| *at == self.at).map_or("", |(_, keys)| keys);
        for key in keys.bytes() {
            self.desk.key(key).unwrap_or_else(|error| panic!("{keys} in period {}: {error}", self.at));
            self.sent.extend(std::iter::from_fn(|| self.desk.byte()));
        }
        let report = self.desk.step(Timing::Kept, &mut self.told);
        assert!(self.at < 201 || report.mode == Mode::Following, "{}: {:?}", self.at, self.told.0);
        self.at += 1;
        self.wires.command_v()
    }
}

/// The records of a press with these effects.
fn records(effects: Vec<PlantEffect>, folder: &Path) -> Vec<Recording> {
    let rest = SetPoint { position: PerUnit::saturated(START_M / 0.3), velocity: PerUnit::ZERO };
    let wanted = vec![Wanted { position_m: START_M, per_unit: rest }; PERIODS];
    let encoder = PositionSensor::Linear { resolution_m: 1.0 / press::COUNTS_PER_M };
    let sensors = Sensors::with_position(&press::machine(), encoder);
    let rig = Rig { effects, sensors, ..Rig::new(&press::machine(), wanted) };
    let wires = Rc::new(Wires::default());
    wires.seen.set(rig.at_rest());
    let [inputs, position, output] = [(); 3].map(|()| wires.clone());
    let devices = Devices {
        inputs: FromFn::<_, INPUT_UV>(move |channel| Ok::<i32, ()>(inputs.input(channel))),
        position: FromFn::<_>(move || Ok::<i32, ()>(counts(position.seen.get().position_m * press::COUNTS_PER_M))),
        output: FromFn::<_, OUTPUT_UV>(move |count| {
            output.output.set(count);
            Ok::<(), ()>(())
        }),
    };
    let mut memory = None;
    let assembly = Assembly::new(INPUT_UV, OUTPUT_UV).unwrap();
    let station = assembly.over(devices, Place::Known, &mut memory).unwrap();
    let mut typist =
        Typist { wires, desk: Desk::new(station, press::BY_HAND), at: 0, told: Told::default(), sent: Vec::new() };
    rig.run(&mut typist);
    let stream = frames::stream(&typist.sent).unwrap();
    assert_eq!((stream.losses.missing, stream.losses.refused, stream.recordings.len()), (0, 0, 3));
    let recordings = stream.recordings.iter().enumerate().map(|(number, imported)| {
        let file = folder.join(format!("plan-{number}.csv"));
        std::fs::write(&file, imported.csv().unwrap()).unwrap();
        recording::read(&file, &ChannelMap::default()).unwrap()
    });
    recordings.collect()
}

/// The diagnosis of two records, confirmed by the third.
fn diagnosed(records: &[Recording]) -> Diagnosis {
    let file = MachineFile::from_machine(press::values::NAME, press::machine());
    diagnose(&file, &records[..2], &records[2..], None, &|_| ()).unwrap()
}

/// Distances of the recorded positions from those of the model under the recorded command, m.
fn off_m(record: &Recording) -> Vec<f64> {
    let machine = press::machine();
    let stimulus = Stimulus::new(record, &machine, InputPoint::Command, LoadSource::Constant, TICK).unwrap();
    let mut simulated_m = Vec::new();
    rows_f64(&machine, &stimulus, StartOffset::none(), &mut |_, signal| simulated_m.extend(signal(Signal::Position)))
        .unwrap();
    let recorded_m = record.signal(Signal::Position).unwrap();
    assert_eq!(simulated_m.len(), recorded_m.len());
    simulated_m.iter().zip(recorded_m).map(|(simulated_m, recorded_m)| simulated_m - recorded_m).collect()
}

#[test]
fn the_record_of_a_plan_is_what_the_model_does_with_the_recorded_command_where_the_press_is_as_the_model_says() {
    let folder = tempfile::tempdir().unwrap();
    let records = records(Vec::new(), folder.path());
    for record in &records {
        let off_m = off_m(record);
        let largest_m = off_m.iter().fold(0.0_f64, |most, off_m| most.max(off_m.abs()));
        let rms_m = (off_m.iter().map(|off_m| off_m * off_m).sum::<f64>() / off_m.len() as f64).sqrt();
        println!("{:.1} µm, at most {:.1} µm from the model", 1e6 * rms_m, 1e6 * largest_m);
        // A step of the encoder is 13.9 µm, and so much the start may be off; 7 and 19 were found.
        let step_m = 1.0 / press::COUNTS_PER_M;
        assert!(rms_m < step_m && largest_m < 2.0 * step_m, "{rms_m} {largest_m}");
        // It has moved meanwhile.
        let positions_m = record.signal(Signal::Position).unwrap();
        let [least_m, most_m] = [f64::min, f64::max].map(|of| positions_m.iter().copied().reduce(of).unwrap());
        assert!(most_m - least_m > 0.02, "{least_m} {most_m}");
    }
    // The recorder's words are finer than the encoder's counts: both roundings are noise.
    let said = diagnosed(&records);
    assert_eq!((said.verdict, said.findings.len()), (Verdict::NothingMissing, 0));
}

#[test]
fn the_record_of_a_plan_shows_the_friction_that_the_press_has_beyond_the_model() {
    const FRICTION_N: f64 = 400.0;
    let folder = tempfile::tempdir().unwrap();
    let records = records(vec![PlantEffect::coulomb_friction(FRICTION_N)], folder.path());
    let found = diagnosed(&records);
    let [finding] = found.findings.as_slice() else { panic!("{:?}, {:?}", found.verdict, found.findings) };
    assert_eq!((found.verdict, finding.effect.name), (Verdict::MissingPhysics, "coulomb-friction"));
    println!("{:.1} N of {FRICTION_N} N", finding.parameters[0].value);
    assert!((finding.parameters[0].value - FRICTION_N).abs() < 0.02 * FRICTION_N, "{:?}", finding.parameters);
}
