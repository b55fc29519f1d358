//! The loop with the processor in it: the firmware under QEMU, its parts and its machine here.
//!
//! Then the whole circle: the monitor sees that the machine is not the model, the recorder's frames become recordings, the diagnosis names
//! what the model lacks, the export takes it to the controller, and the machine follows better than before.

use std::path::Path;

use firmware::press;
use firmware::set_point::{Bounds, Leg};
use host_sim::diagnose::{Verdict, diagnose};
use host_sim::export::Constants;
use host_sim::import;
use host_sim::machine_file::MachineFile;
use host_sim::recording::{self, ChannelMap, Recording};
use host_sim::testbed::PlantEffect;
use host_sim::testbed::sensors::{PositionSensor, Sensors};
use model_core::machine::Machine;
use model_core::parameter::Parameter as P;
use system_tests::at_hand::skipped;
use system_tests::emulator::Processor as Target;

use crate::pi::{Pi, tuned};
use crate::processor::{Processor, SETTLING};
use crate::rig::{Rig, TICK, Wanted, course, largest_force_n, rms_mm};

/// Dry friction that the model does not know, N: 9 % of the largest force.
const FRICTION_N: f64 = 2000.0;

/// Moves within the stroke, from one place, at speeds of their own.
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

/// A rig with the encoder that the firmware is wired to.
fn rig(machine: &Machine<f64>, wanted: Vec<Wanted>) -> Rig {
    let position = PositionSensor::Linear { resolution_m: 1.0 / press::COUNTS_PER_M };
    Rig { sensors: Sensors::with_position(machine, position), ..Rig::new(machine, wanted) }
}

/// A run of the image on a rig.
struct Run {
    rms_mm: f64,
    /// Period of the monitor's first alarm, and the signal it was for.
    alarm: Option<(usize, u8)>,
    record: Vec<u8>,
}

fn run(image: &Path, rig: &Rig) -> Run {
    let mut processor = Processor::start(image, &rig.at_rest());
    let rms_mm = rms_mm(&rig.run(&mut processor));
    let alarm = processor.alarm;
    Run { rms_mm, alarm, record: processor.end(rig.wanted[0]) }
}

fn recording(name: &str, record: &[u8], folder: &Path) -> Recording {
    let stream = import::stream(record).unwrap();
    assert_eq!((stream.losses.missing, stream.losses.refused), (0, 0));
    let file = folder.join(name);
    std::fs::write(&file, stream.chosen(None).unwrap().csv().unwrap()).unwrap();
    recording::read(&file, &ChannelMap::default()).unwrap()
}

#[test]
fn the_firmware_follows_on_the_emulated_target_and_better_once_the_diagnosis_has_told_it_of_the_friction() {
    if !Target::M4F.can_be_emulated() {
        return skipped("no processor in the loop");
    }
    let machine = press::machine();
    let image = Target::M4F.built("loop", None);
    let nominal = rig(&machine, moves(&machine, 0.0, 1.0));
    let (gains, _) = tuned(&nominal, 0.0);
    let pi_mm = |rig: &Rig| rms_mm(&rig.run(&mut Pi::new(&rig.machine, gains)));

    let plain = run(&image, &nominal);
    println!("nominal: {:.3} mm, PI {:.3} mm, alarm {:?}", plain.rms_mm, pi_mm(&nominal), plain.alarm);
    assert_eq!(plain.alarm, None, "the model is the machine");

    let loaded = machine.with(&[(P::LoadForce, -0.5 * largest_force_n(&machine))]);
    let under_load = Rig { machine: loaded, ..nominal.clone() };
    let load = run(&image, &under_load);
    println!("half load: {:.3} mm, PI {:.3} mm, alarm {:?}", load.rms_mm, pi_mm(&under_load), load.alarm);
    assert!(load.rms_mm < pi_mm(&under_load) / 3.0 && load.alarm.is_some());

    let effects = vec![PlantEffect::coulomb_friction(FRICTION_N)];
    let rubbing = |shift_m, pace| Rig { effects: effects.clone(), ..rig(&machine, moves(&machine, shift_m, pace)) };
    let rigs = [rubbing(0.0, 1.0), rubbing(0.05, 0.8), rubbing(-0.03, 1.2)];
    let runs = rigs.each_ref().map(|rig| run(&image, rig));
    let friction = &runs[0];
    println!("friction: {:.3} mm, PI {:.3} mm, alarm {:?}", friction.rms_mm, pi_mm(&rigs[0]), friction.alarm);
    assert!(friction.rms_mm < pi_mm(&rigs[0]) / 3.0 && friction.alarm.is_some());

    let folder = tempfile::tempdir().unwrap();
    let [first, second, held_out] =
        [0, 1, 2].map(|index| recording(&format!("run-{index}.csv"), &runs[index].record, folder.path()));
    let file = MachineFile::from_machine(press::values::NAME, machine);
    let found = diagnose(&file, &[first, second], &[held_out], None, &|_| ()).unwrap();
    let names: Vec<&str> = found.findings.iter().map(|finding| finding.effect.name).collect();
    println!(
        "{:?}: {names:?}, {:?}",
        found.verdict,
        found.findings.iter().map(|found| &found.parameters).collect::<Vec<_>>()
    );
    assert_eq!((found.verdict, names.as_slice()), (Verdict::MissingPhysics, ["coulomb-friction"].as_slice()));

    let values = folder.path().join("params.rs");
    std::fs::write(&values, Constants::of(press::values::NAME, &found.machine_after, TICK).unwrap().rust()).unwrap();
    let image = Target::M4F.built("loop", Some(&values));
    let told = run(&image, &rigs[0]);
    println!("friction, in the model: {:.3} mm, alarm {:?}", told.rms_mm, told.alarm);
    // A step of the encoder is 0.014 mm: there is not much left to gain.
    assert!(told.rms_mm < 0.9 * friction.rms_mm, "{} mm, then {} mm", friction.rms_mm, told.rms_mm);
}
