//! `fleet`: every night of every drive becomes a row, whatever is wrong with it, once, and the same whatever happens meanwhile.
#![cfg(all(feature = "virtual-plant", feature = "fleet"))]

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use fleet::{Judgement, Row, rows};
use model_core::machine::Parameter;
use serde_json::Value;
use tempfile::TempDir;

use super::{done, program, refused, root, run, text};

/// Recordings of the installed press with these effects, into a folder of a night.
fn recorded(folder: &Path, night: &str, seed: u32, effects: &[&str]) {
    let machine = root().join("presets/press-63-40-installed.toml").display().to_string();
    let seed = seed.to_string();
    let first = ["testbed", "--machine", &machine, "--seed", &seed, "--spread", "0", "--out", night];
    let signals =
        ["--train", "steps:6V", "--train", "random:6V,0.05s,0.3s,3s,seed=1", "--train", "sweep:5V,0.5Hz,4Hz,3s"];
    let effects = effects.iter().flat_map(|effect| ["--effect", effect]);
    done(folder, &first.into_iter().chain(signals).chain(effects).collect::<Vec<_>>());
}

/// A machine file with the band that the recordings of a healthy night tell, in `w.toml`.
fn learn(folder: &Path) {
    recorded(folder, "then", 1, &[]);
    let healthy = ["then/train-1.csv", "then/train-2.csv", "then/train-3.csv"];
    let learn = ["watch", "--machine", "then/machine.toml", "--save-machine", "w.toml", "--healthy"];
    done(folder, &learn.into_iter().chain(healthy).collect::<Vec<_>>());
}

/// `w.toml` as the machine file of a drive.
fn drive(folder: &Path, name: &str) {
    let machine = folder.join(format!("hall/{name}/machine.toml"));
    fs::create_dir_all(machine.parent().unwrap()).unwrap();
    fs::copy(folder.join("w.toml"), machine).unwrap();
}

/// A hall with a healthy drive, one that leaks in its second night, one without machine file, one in two folders; a recording that is none, a night
/// without any.
fn hall() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    learn(here);
    for name in ["drive=healthy", "drive=leaks", "drive=twice", "twice"] {
        drive(here, name);
    }
    recorded(here, "hall/drive=healthy/date=2026-01-01", 2, &[]);
    recorded(here, "hall/drive=healthy/date=2026-01-02", 3, &[]);
    fs::write(here.join("hall/drive=healthy/date=2026-01-02/cut.parquet"), "PAR1").unwrap();
    fs::write(here.join("hall/drive=healthy/date=2026-01-02/other.csv"), "time [s],Kolbenweg\n0,1\n1,2\n").unwrap();
    fs::create_dir(here.join("hall/drive=healthy/date=2026-01-03")).unwrap();
    recorded(here, "hall/drive=leaks/date=2026-01-01", 4, &[]);
    recorded(here, "hall/drive=leaks/date=2026-01-02", 5, &["internal-leakage=3e-12"]);
    for other in ["hall/drive=lost/n", "hall/drive=twice/n", "hall/twice/n"] {
        fs::create_dir_all(here.join(other)).unwrap();
        fs::copy(here.join("then/train-1.csv"), here.join(other).join("1.csv")).unwrap();
    }
    folder
}

/// The rows of a table, but for the time that they took.
fn table(folder: &Path, name: &str) -> Vec<Row> {
    let mut all = rows(&folder.join(name)).unwrap();
    for row in &mut all {
        row.seconds = 0.0;
    }
    all
}

/// The rows of a night.
fn of<'a>(all: &'a [Row], drive: &str, night: &str) -> Vec<&'a Row> {
    all.iter().filter(|row| row.key() == (drive, night)).collect()
}

#[test]
fn every_night_becomes_a_row_and_what_is_wrong_with_one_says_why_and_leaves_the_others_alone() {
    let folder = hall();
    let here = folder.path();
    let told = done(here, &["fleet", "hall", "--out", "table", "--json", "f.json"]);
    assert!(told.starts_with("7 nights: 3 in-band, 1 changed, 3 unusable"), "{told}");
    let all = table(here, "table");
    assert_eq!(all.len(), 9, "{all:#?}");

    let [healthy] = of(&all, "healthy", "2026-01-01")[..] else { panic!("{all:#?}") };
    assert_eq!((healthy.judgement, healthy.recordings, healthy.link), (Judgement::InBand, 3, None));
    assert!(
        healthy.of_limit.unwrap() < 1.0 && healthy.misfits.iter().all(|misfit| misfit.unwrap() < 1.2),
        "{healthy:?}"
    );

    let [row, cut, other] = of(&all, "healthy", "2026-01-02")[..] else { panic!("{all:#?}") };
    assert_eq!((row.judgement, row.recordings), (Judgement::InBand, 3));
    assert_eq!((cut.judgement, cut.recording.as_deref()), (Judgement::Unusable, Some("cut.parquet")));
    assert!(cut.words.contains("expected "), "{cut:?}");
    assert_eq!((other.judgement, other.recording.as_deref()), (Judgement::Unusable, Some("other.csv")));

    let [leaks] = of(&all, "leaks", "2026-01-02")[..] else { panic!("{all:#?}") };
    assert_eq!(leaks.judgement, Judgement::Changed, "{leaks:?}");
    assert!(leaks.words.contains("internal-leakage") && leaks.words.contains("outside its band"), "{leaks:?}");
    let leak = leaks.strengths.iter().find(|one| one.parameter == Parameter::InternalLeakage).unwrap();
    assert!((leak.value / 3e-12 - 1.0).abs() < 0.1 && leak.std < 0.1 * leak.value, "{leak:?}");

    for (drive, night, why) in [
        ("healthy", "2026-01-03", "no recording: nothing is known of this night"),
        ("lost", "n", "machine.toml"),
        ("twice", "n", "two folders have this name"),
    ] {
        let [row] = of(&all, drive, night)[..] else { panic!("{all:#?}") };
        assert!(row.judgement == Judgement::Unusable && row.words.contains(why), "{row:?}");
    }

    let document: Value = serde_json::from_str(&fs::read_to_string(here.join("f.json")).unwrap()).unwrap();
    assert_eq!((&document["nights"], &document["verdicts"]["changed"]), (&7.into(), &1.into()));
    assert_eq!(document["not_in_band"].as_array().unwrap().len(), 6);
}

#[test]
fn rows_are_the_same_whatever_the_threads_and_a_second_run_adds_none() {
    let folder = hall();
    let here = folder.path();
    let refit = |out: &str, threads: &str| {
        done(here, &["fleet", "hall", "--upto", "refit", "--out", out, "--threads", threads])
    };
    refit("one", "1");
    refit("two", "2");
    let one = table(here, "one");
    assert_eq!(one, table(here, "two"));
    assert_eq!(of(&one, "leaks", "2026-01-02")[0].judgement, Judgement::Left);
    assert!(refit("one", "2").starts_with("every night is in the table already"));
    assert_eq!(one, table(here, "one"));
    // A night that comes later is added.
    recorded(here, "hall/drive=leaks/date=2026-01-03", 6, &[]);
    assert!(refit("one", "2").starts_with("1 night: 1 in-band"));
    assert_eq!(table(here, "one").len(), one.len() + 1);
}

/// What the file holds may have become more: a refit that follows is not enough to call the drive unchanged.
#[test]
fn of_a_drive_whose_file_holds_a_leak_a_larger_one_is_a_change_and_the_same_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let healthy = |effect: &str, name: &str, seed: u32| recorded(here, name, seed, &[effect]);
    healthy("internal-leakage=2e-12", "then", 1);
    let text = fs::read_to_string(here.join("then/machine.toml")).unwrap();
    fs::create_dir_all(here.join("hall/a")).unwrap();
    let leak = "\n[effects.internal-leakage]\nconductance_m3_per_s_pa = 2.0e-12\n";
    fs::write(here.join("with.toml"), format!("{text}{leak}")).unwrap();
    let recordings = ["then/train-1.csv", "then/train-2.csv", "then/train-3.csv"];
    let learn = ["watch", "--machine", "with.toml", "--save-machine", "hall/a/machine.toml", "--healthy"];
    done(here, &learn.into_iter().chain(recordings).collect::<Vec<_>>());
    healthy("internal-leakage=2e-12", "hall/a/1", 2);
    healthy("internal-leakage=2.6e-12", "hall/a/2", 3);
    done(here, &["fleet", "hall", "--out", "table"]);
    let all = table(here, "table");
    let [same, more] = &all[..] else { panic!("{all:#?}") };
    assert!(matches!(same.judgement, Judgement::InBand | Judgement::Unchanged), "{same:?}");
    assert!(more.judgement == Judgement::Changed && more.words.contains("internal-leakage rose"), "{more:?}");
}

/// No file may become longer than a block: as on a full disk.
#[cfg(unix)]
#[test]
fn where_the_table_cannot_grow_it_stays_as_it_was_and_the_same_command_goes_on() {
    let folder = hall();
    let here = folder.path();
    let arguments = ["fleet", "hall", "--upto", "watch", "--out", "table"];
    let full = std::process::Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_host-sim")])
        .args(arguments)
        .current_dir(here)
        .output()
        .unwrap();
    let said = text(&full.stderr);
    assert!(full.status.code() == Some(2) && said.contains("part-000000.parquet"), "{said}");
    assert!(table(here, "table").is_empty());
    let left = fs::read_dir(here.join("table")).unwrap().map(|entry| entry.unwrap().file_name());
    assert_eq!(left.collect::<Vec<_>>(), [".lock"], "nothing half-written");
    done(here, &arguments);
    assert!(!table(here, "table").is_empty());
}

#[cfg(unix)]
#[test]
fn a_run_that_is_killed_goes_on_where_it_was_without_a_row_lost_or_twice() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    learn(here);
    drive(here, "a");
    for night in 0..24 {
        let to = here.join(format!("hall/a/{night:02}"));
        fs::create_dir_all(&to).unwrap();
        for file in 1..=3 {
            fs::copy(here.join(format!("then/train-{file}.csv")), to.join(format!("{file}.csv"))).unwrap();
        }
    }
    let fleet = |out: &str| ["fleet", "hall", "--upto", "refit", "--threads", "1", "--out", out].map(str::to_owned);
    let arguments = |out: &str| fleet(out).to_vec();
    let whole = arguments("whole");
    done(here, &whole.iter().map(String::as_str).collect::<Vec<_>>());
    let killed = arguments("killed");
    let killed: Vec<&str> = killed.iter().map(String::as_str).collect();
    // Each time as soon as it has written another part, or soon after that.
    let mut interrupted = 0;
    for round in 0..4_u32 {
        let parts = || fs::read_dir(here.join("killed")).map_or(0, |all| all.filter(is_part).count());
        let before = parts();
        let mut child = program(here, &killed).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let began = Instant::now();
        while parts() == before && child.try_wait().unwrap().is_none() && began.elapsed() < Duration::from_mins(1) {
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(u64::from(round) * 70));
        interrupted += u32::from(child.try_wait().unwrap().is_none());
        let _ = child.kill();
        child.wait().unwrap();
    }
    assert!(interrupted > 0, "the run was over before it could be killed");
    done(here, &killed);
    assert_eq!(table(here, "killed"), table(here, "whole"));
}

fn is_part(entry: &std::io::Result<fs::DirEntry>) -> bool {
    entry.as_ref().is_ok_and(|entry| entry.file_name().to_string_lossy().starts_with("part-"))
}

/// The way of docs/fleet.md: drawn, commissioned, judged.
#[test]
fn a_drawn_hall_is_commissioned_and_judged_and_drawn_again_it_is_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for out in ["hall", "again"] {
        done(here, &["testbed", "hall", "--drives", "2", "--nights", "2", "--seed", "7", "--out", out]);
    }
    let truth = |out: &str| fs::read_to_string(here.join(out).join("truth.json")).unwrap();
    assert_eq!(truth("hall"), truth("again").replace("\"again\"", "\"hall\""));
    let one = "drive=drive-001/date=2026-01-02/1.csv";
    assert_eq!(fs::read(here.join("hall").join(one)).unwrap(), fs::read(here.join("again").join(one)).unwrap());
    let full = refused(here, &["testbed", "hall", "--out", "hall"]);
    assert!(full.contains("expected an empty folder"), "{full}");
    for drive in ["hall/drive=drive-000", "hall/drive=drive-001"] {
        let healthy: Vec<String> = (1..=12).map(|k| format!("{drive}/_healthy/{k}.csv")).collect();
        let healthy: Vec<&str> = healthy.iter().map(String::as_str).collect();
        let machine = format!("{drive}/machine.toml");
        let saved = ["--machine", &machine, "--save-machine", &machine];
        done(here, &[&["fit"][..], &healthy[..4], &saved].concat());
        done(here, &[&["watch"][..], &saved, &["--healthy"], &healthy[4..]].concat());
    }
    done(here, &["fleet", "hall", "--upto", "refit", "--out", "table"]);
    let all = table(here, "table");
    assert_eq!(all.len(), 4);
    let is_known = |row: &Row| row.judgement != Judgement::Unusable && row.recordings == 2;
    assert!(all.iter().all(is_known), "{all:#?}");
}

#[test]
fn a_folder_without_nights_and_a_table_of_another_kind_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::create_dir_all(here.join("empty")).unwrap();
    let none = refused(here, &["fleet", "empty", "--out", "table"]);
    assert!(none.contains("no night of any drive") && none.contains("drive=press-1/date=2026-11-30"), "{none}");
    assert!(!here.join("table").exists());
    let absent = refused(here, &["fleet", "nowhere", "--out", "table"]);
    assert!(absent.contains("nowhere"), "{absent}");
    learn(here);
    drive(here, "a");
    fs::create_dir_all(here.join("hall/a/n")).unwrap();
    fs::copy(here.join("then/train-1.csv"), here.join("hall/a/n/1.csv")).unwrap();
    fs::create_dir_all(here.join("other")).unwrap();
    fs::write(here.join("other/mine.parquet"), "no parquet").unwrap();
    let other = refused(here, &["fleet", "hall", "--out", "other"]);
    assert!(other.contains("mine.parquet") && other.contains("expected a part of a table"), "{other}");
    let output = run(here, &["fleet", "hall", "--out", "table", "--upto", "watch", "--exit-code"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}
