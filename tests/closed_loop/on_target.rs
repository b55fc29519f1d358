//! The loop with the processor in it: the firmware under QEMU, its devices and its machine here.
//!
//! Then the whole cycle: the monitor finds that the machine differs from the model, the recorder's frames become recordings, the diagnosis names
//! what the model lacks, the export brings it to the controller, and the machine follows better than before.

use std::fmt::Write;
use std::path::Path;
use std::thread;

use diagnosis::{Verdict, diagnose};
use firmware::app::press;
use firmware::set_point::{Bounds, Leg};
use host_sim::frames;
use machine_file::MachineFile;
use model_core::machine::{Machine, Parameter as P};
use model_export::rust::Constants;
use recording::{ChannelMap, Recording};
use system_tests::at_hand::skipped;
use system_tests::emulator::Processor;
use system_tests::in_the_loop::{Board, Follows, RECORDED_FROM, SETTLING, rig};
use system_tests::rig::{Rig, TICK, Wanted, course, largest_force_n, rms_mm};
use system_tests::snapshot;
use virtual_plant::PlantEffect;

use crate::pi::{Pi, tuned};

/// Dry friction that the model does not know, N: 9 % of the largest force.
const FRICTION_N: f64 = 2000.0;

/// Moves within the stroke, from one place, each at its own speed.
fn moves(machine: &Machine<f64>, shift_m: f64, pace: f64) -> Vec<Wanted> {
    let bounds = Bounds { from_m: 0.01, to_m: 0.29, velocity_m_per_s: 0.03 * pace, acceleration_m_per_s2: 0.3 };
    let to = |to_m: f64| to_m + shift_m;
    let legs = [
        Leg::Rest { duration_s: 0.1 + SETTLING as f64 * TICK.seconds() },
        Leg::Fastest { to_m: to(0.15) },
        Leg::Rest { duration_s: 0.3 },
        Leg::Fastest { to_m: to(0.12) },
        Leg::Smooth { to_m: to(0.14), duration_s: 1.6 / pace },
        Leg::Smooth { to_m: to(0.11), duration_s: 2.4 / pace },
        Leg::Rest { duration_s: 0.3 },
    ];
    let step_m = 1.0 / press::COUNTS_PER_M;
    course(machine, &bounds, (to(0.1) / step_m).round() * step_m, &legs)
}

/// A run of the image on a rig.
struct Run {
    rms_mm: f64,
    /// Period of following in which the monitor gave its first alarm, and the signal that caused it.
    alarm: Option<(usize, u8)>,
    record: Vec<u8>,
}

fn run(image: &Path, rig: &Rig) -> Run {
    let mut follows = Follows::on(Board::start(Processor::M4F, image, &rig.at_rest()));
    let rms_mm = rms_mm(&rig.run(&mut follows));
    let alarm = follows.alarm.map(|(period, signal)| (period - SETTLING, signal));
    Run { rms_mm, alarm, record: follows.end().record }
}

fn recording(name: &str, record: &[u8], folder: &Path) -> Recording {
    let stream = frames::stream(record).unwrap();
    assert_eq!((stream.losses.missing, stream.losses.refused), (0, 0));
    let file = folder.join(name);
    std::fs::write(&file, stream.chosen(None).unwrap().csv().unwrap()).unwrap();
    recording::read(&file, &ChannelMap::default()).unwrap()
}

const HEAD: &str = "\
The firmware on an emulated Cortex-M4F around the virtual test bed.  Root of the mean square of the rod's distance to its set point, mm,
and the period of following in which the monitor gives its alarm; 0 is none.
";
/// Where the numbers begin in a row.
const COLUMN: usize = 44;
/// Largest change of a figure against the snapshot: another processor's libm can move a controller to the next encoder step.
const RELATIVE: f64 = 0.15;
/// Added to it, mm.
const ABSOLUTE_MM: f64 = 0.004;

fn row(table: &mut String, name: &str, run: &Run, pi_mm: f64) {
    let alarm = run.alarm.map_or(0, |(period, _)| period);
    writeln!(table, "{name:<COLUMN$} {:>9.3} {pi_mm:>9.3} {alarm:>9}", run.rms_mm).unwrap();
}

#[test]
fn the_firmware_follows_on_the_emulated_target_and_better_once_the_diagnosis_has_told_it_of_the_friction() {
    if !Processor::M4F.can_be_emulated() {
        return skipped("no processor in the loop");
    }
    let machine = press::machine();
    let image = Processor::M4F.built("loop", None);
    let nominal = rig(&machine, moves(&machine, 0.0, 1.0));
    let loaded = machine.with(&[(P::LoadForce, -0.5 * largest_force_n(&machine))]);
    let under_load = Rig { machine: loaded, ..nominal.clone() };
    let effects = vec![PlantEffect::coulomb_friction(FRICTION_N)];
    let rubbing = |shift_m, pace| Rig { effects: effects.clone(), ..rig(&machine, moves(&machine, shift_m, pace)) };
    let rigs = [nominal.clone(), under_load, rubbing(0.0, 1.0), rubbing(0.05, 0.8), rubbing(-0.03, 1.2)];
    // Each emulator and its test bed wait for each other most of the time: all run at once, together with the search for the gains.
    let (pi_mm, runs) = thread::scope(|scope| {
        let searched = scope.spawn(|| {
            let (gains, _) = tuned(&nominal, 0.0);
            [0, 1, 2].map(|index: usize| rms_mm(&rigs[index].run(&mut Pi::new(&rigs[index].machine, gains))))
        });
        let runs = rigs.each_ref().map(|rig| scope.spawn(|| run(&image, rig))).map(|run| run.join().unwrap());
        (searched.join().unwrap(), runs)
    });
    let [plain, load, friction, ..] = &runs;

    let folder = tempfile::tempdir().unwrap();
    let [first, second, held_out] =
        [2, 3, 4].map(|index| recording(&format!("run-{index}.csv"), &runs[index].record, folder.path()));
    let file = MachineFile::from_machine(press::values::NAME, machine);
    let found = diagnose(&file, &[first, second], &[held_out], None, &|_| ()).unwrap();
    let [finding] = found.findings.as_slice() else { panic!("{:?}, {:?}", found.verdict, found.findings) };
    let values = folder.path().join("params.rs");
    std::fs::write(&values, Constants::of(press::values::NAME, &found.machine_after, TICK).unwrap().rust()).unwrap();
    let told = run(&Processor::M4F.built("loop", Some(&values)), &rigs[2]);

    let mut table = format!("{HEAD}{:<COLUMN$} {:>9} {:>9} {:>9}\n", "machine", "firmware", "PI", "alarm");
    row(&mut table, "as the model says", plain, pi_mm[0]);
    row(&mut table, "half the largest force, unknown", load, pi_mm[1]);
    row(&mut table, "dry friction of 2000 N, unknown", friction, pi_mm[2]);
    row(&mut table, "the same, as diagnosed and exported", &told, pi_mm[2]);
    let named = format!("diagnosed: {}, {}", finding.effect.name, finding.parameters[0].parameter.description().unit);
    writeln!(table, "{named:<COLUMN$} {:>9.0}", finding.parameters[0].value).unwrap();
    snapshot::compare("closed_loop/in_the_loop.txt", &table, |found, kept| {
        snapshot::numbers_near(found, kept, COLUMN, RELATIVE, ABSOLUTE_MM)
    });

    assert_eq!(plain.alarm, None, "the model is the machine");
    for (run, pi_mm) in [(load, pi_mm[1]), (friction, pi_mm[2])] {
        assert!(run.rms_mm < pi_mm / 3.0 && run.alarm.is_some(), "{} mm, PI {pi_mm} mm", run.rms_mm);
    }
    let alarm = friction.alarm.map(|(period, _)| SETTLING + period);
    assert!(alarm.is_some_and(|period| period < RECORDED_FROM), "the record is the alarm's: {alarm:?}");
    assert_eq!((found.verdict, finding.effect.name), (Verdict::MissingPhysics, "coulomb-friction"));
    // A step of the encoder is 0.014 mm: little can still be gained.
    assert!(told.rms_mm < 0.9 * friction.rms_mm, "{} mm, then {} mm", friction.rms_mm, told.rms_mm);
}
