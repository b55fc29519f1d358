//! The spool of a crane's proportional valve, measured by others while the command moves.

use diagnosis::catalogue::Subsystem;
use diagnosis::localisation::Habit;
use diagnosis::{Diagnosis, Verdict, diagnose};
use identification::compare::judged::judged_by;
use machine_file::MachineFile;
use recording::{Recording, Signal};

use super::{done, root, text};

/// The crane's diagnosis, trained at 70 % and held out at 40 %, on the judged part of each recording. Prints why if the recordings are absent.
fn diagnosed(judged: impl Fn(&MachineFile, Recording) -> Recording) -> Option<Diagnosis> {
    let folder = system_tests::at_hand::shared("data/redcrane/dynamic")?;
    let file = machine_file::read(&root().join("tests/diagnosis/redcrane.toml")).unwrap();
    let read = |name| judged(&file, recording::read(&folder.join(format!("{name}.csv")), &file.channels).unwrap());
    let (training, held_out) = (["ramp-to-70", "stop-from-70"].map(read), ["ramp-to-40", "stop-from-40"].map(read));
    Some(diagnose(&file, &training, &held_out, None, &|_| {}).unwrap())
}

/// The spool sticks, breaks away and does not return to its rest position; no effect of the catalogue does all of
/// this, and two training recordings determine little: the link is what must be found.
#[test]
fn the_valve_of_a_real_crane_is_located_and_no_other_link_is_blamed() {
    let spool =
        |file: &MachineFile, whole| judged_by(whole, file.machine.source, file.load_source, &[Signal::Spool]).unwrap();
    let Some(diagnosis) = diagnosed(spool) else { return };
    let fits = [false, true].map(|after| diagnosis.mean_fits(true, after)["spool"]);
    let floor = diagnosis.noise_floor(true)["spool"];
    println!("held-out spool: {:.2} % → {:.2} %, noise floor {floor:.2} %", fits[0], fits[1]);
    for shown in diagnosis.shown.iter().filter(|shown| shown.held_out) {
        for (when, after) in [("before", false), ("after", true)] {
            println!("{} {when}: {:.2} %", shown.prepared.name, shown.fits(after).next().unwrap().nrmse_percent);
        }
    }
    for finding in &diagnosis.findings {
        println!("named: {} ({:.2})", finding.effect.name, finding.confidence);
    }
    println!("verdict: {:?}", diagnosis.verdict);
    assert_ne!(diagnosis.verdict, Verdict::NothingMissing);
    let located = diagnosis.located.unwrap();
    for habit in &located.spool {
        println!("{}", report::wording::spool_habit(habit));
    }
    let [Habit::Sticks { at, .. }, Habit::BreaksAway { speed_per_s, .. }, Habit::RestsElsewhere { rests, .. }] =
        located.spool.as_slice()
    else {
        panic!("{:?}", located.spool)
    };
    // As the recordings' own page says: it sticks at 5.25 V of 5 to 10, breaks away at 8 to 10 V/s, and rests at 5.24 V after it rested at 4.965 V.
    assert!((0.03..0.07).contains(at) && (1.6..2.0).contains(speed_per_s), "{at} {speed_per_s}");
    let [home, away] = [&rests[0], &rests[1]].map(|(_, at)| 5.0 + 5.0 * at);
    assert!((home - 4.965).abs() < 0.01 && (away - 5.245).abs() < 0.01, "{home} V {away} V");
    assert_eq!((located.subsystem, located.signal), (Subsystem::Valve, Signal::Spool));
    assert!(diagnosis.findings.iter().all(|finding| finding.effect.subsystem == Subsystem::Valve));
    assert!(fits[0] > 70.0 && fits[1] > fits[0] - 0.5 && fits[1] < floor - 1.0, "{fits:?} {floor}");
}

/// Judged by all that was recorded: its load-holding valve is named. A swinging jib and ports that trap their oil are in no catalogue: the misfit that
/// they leave is reported for each signal.
#[test]
fn a_cranes_load_holding_valve_is_named_and_what_is_left_is_owned_up_to() {
    let Some(diagnosis) = diagnosed(|_, whole| whole) else { return };
    let (before, after) = (diagnosis.mean_fits(true, false), diagnosis.mean_fits(true, true));
    for (signal, floor) in diagnosis.noise_floor(true) {
        println!("held-out {signal}: {:.1} % → {:.1} %, noise floor {floor:.1} %", before[signal], after[signal]);
    }
    println!("{:?}, still missed: {:?}", diagnosis.verdict, diagnosis.left);
    let named: Vec<&str> = diagnosis.findings.iter().map(|finding| finding.effect.name).collect();
    println!("named: {named:?}");
    assert_eq!((diagnosis.verdict, named.as_slice()), (Verdict::MissingPhysics, ["counterbalance"].as_slice()));
    for signal in [Signal::Spool, Signal::PressureA, Signal::PressureB] {
        assert!(diagnosis.left.iter().any(|miss| miss.signal == signal), "{signal} is said to be explained");
    }
}

#[test]
fn compare_spares_what_is_not_judged() {
    let Some(folder) = system_tests::at_hand::shared("data/redcrane/dynamic") else { return };
    let (machine, ramp) = (root().join("tests/diagnosis/redcrane.toml"), folder.join("ramp-to-40.csv"));
    let arguments = ["compare", "--machine", text(&machine), "--recording", text(&ramp), "--judge", "spool"];
    let printed = done(&arguments);
    println!("{printed}");
    assert!(printed.contains("weakest is valve, spool") && !printed.contains("below spool"), "{printed}");
}
