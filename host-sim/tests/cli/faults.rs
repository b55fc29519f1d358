//! What goes wrong while the program works: a full disk, a folder that may not be written to, a file that ends while it is read, a
//! process that is killed. What was there stays, nothing is half-written, and the same again works.
#![cfg(unix)]

use std::fs::{self, Permissions};
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use super::import::streamed;
use super::init::PRESS;
use super::{at_hand, done, example, listing, refused, text};

/// Commands that write a file, each with the option for it last; its name goes before it here, and follows there.
const WRITING: [(&str, &[&str]); 11] = [
    ("simulated.csv", &["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out"]),
    ("simulated.mat", &["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out"]),
    ("simulated.parquet", &["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out"]),
    ("plot.svg", &["compare", "--machine", "machine.toml", "--recording", "run.csv", "--plot"]),
    ("simulated.svg", &["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out", "-", "--plot"]),
    ("statics.json", &["statics", "--recording", "run.csv", "--input", "command", "--output", "position", "--json"]),
    ("held.json", &["inspect", "run.csv", "--machine", "machine.toml", "--json"]),
    ("params.rs", &["export", "--machine", "machine.toml", "--out"]),
    ("drive.h", &["export", "--machine", "machine.toml", "--out"]),
    ("taken.csv", &["import", "--frames", "frames.bin", "--out"]),
    ("fitted.toml", &["fit", "--machine", "machine.toml", "--train", "run.csv", "--save-machine"]),
];

/// Those that take longer: a diagnosis, a plan.
const LONG: [(&str, &[&str]); 3] = [
    ("found.json", &["diagnose", "--machine", "machine.toml", "--train", "run.csv", "--holdout", "held.csv", "--json"]),
    (
        "found.html",
        &["diagnose", "--machine", "machine.toml", "--train", "run.csv", "--holdout", "held.csv", "--report"],
    ),
    ("plan.json", &["plan", "--machine", "machine.toml", "--recording", "run.csv", "--seconds", "6", "--json"]),
];

/// A folder with a machine, two recordings and what a recorder has streamed out.
fn bench() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (from, name) in [("machine.toml", "machine.toml"), ("train-1.csv", "run.csv"), ("train-2.csv", "held.csv")] {
        fs::copy(example(from), folder.path().join(name)).unwrap();
    }
    fs::write(folder.path().join("frames.bin"), streamed()).unwrap();
    folder
}

/// The program behind a line of the shell that ends with `exec "$0" "$@"`.
fn behind(shell: &str, folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new("sh");
    command.args(["-c", shell, env!("CARGO_BIN_EXE_host-sim")]).args(arguments).current_dir(folder);
    command.output().unwrap()
}

type Commands = Vec<(&'static str, Vec<&'static str>)>;

/// All of [`WRITING`], and `init`.
fn writing() -> Commands {
    let init = [&PRESS[..1], &PRESS[3..], &["--force", "--out"]].concat();
    WRITING.map(|(target, arguments)| (target, arguments.to_vec())).into_iter().chain([("init.toml", init)]).collect()
}

fn long() -> Commands {
    LONG.map(|(target, arguments)| (target, arguments.to_vec())).into()
}

fn with(arguments: &[&'static str], target: &'static str) -> Vec<&'static str> {
    [arguments, &[target]].concat()
}

#[test]
fn where_nothing_can_be_written_the_old_file_stays() {
    for (target, arguments) in writing() {
        let folder = bench();
        fs::write(folder.path().join(target), "old").unwrap();
        let before = listing(folder.path());
        // No file may grow: as on a full disk, writing fails in the middle.
        let output = behind("trap '' XFSZ; ulimit -f 0; exec \"$0\" \"$@\"", folder.path(), &with(&arguments, target));
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(target) && message.contains("cannot be written"), "{message}");
        assert_eq!(listing(folder.path()), before, "{arguments:?}");
        assert_eq!(fs::read_to_string(folder.path().join(target)).unwrap(), "old", "{arguments:?}");
    }
}

/// A disk of its own, where the user may mount one.
#[test]
fn a_disk_that_is_full_keeps_what_it_has() {
    let folder = bench();
    let disk = folder.path().join("disk");
    fs::create_dir(&disk).unwrap();
    let mounted = "mount -t tmpfs -o size=16k none disk && printf old >disk/simulated.csv || exit 77; \
        \"$0\" \"$@\"; code=$?; [ \"$(ls -A disk)\" = simulated.csv ] && [ \"$(cat disk/simulated.csv)\" = old ] && exit $code; exit 78";
    let simulate = with(WRITING[0].1, "disk/simulated.csv");
    let mut command = Command::new("unshare");
    command.args(["--mount", "sh", "-c", mounted, env!("CARGO_BIN_EXE_host-sim")]).args(simulate);
    let output = command.current_dir(folder.path()).output();
    let Some(output) = output.ok().filter(|output| !matches!(output.status.code(), Some(1 | 77 | 127))) else {
        return at_hand::skipped("this user may not mount a small disk");
    };
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("No space left") && message.contains("room for it on the disk"), "{message}");
}

#[test]
fn a_full_device_at_the_other_end_of_the_output_is_said() {
    let folder = bench();
    for arguments in [
        &["inspect", "run.csv"][..],
        &["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out", "/dev/full"],
    ] {
        let output = behind("exec \"$0\" \"$@\" >/dev/full", folder.path(), arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains("No space left"), "{arguments:?}: {message}");
    }
}

#[test]
fn a_folder_in_the_place_of_a_result_is_refused_before_anything_is_done() {
    for (target, arguments) in writing().into_iter().chain(long()) {
        let folder = bench();
        fs::create_dir(folder.path().join(target)).unwrap();
        let message = refused(folder.path(), &with(&arguments, target));
        assert!(message.contains(target) && message.contains("this is a folder"), "{message}");
        assert_eq!(listing(&folder.path().join(target)), Vec::<std::path::PathBuf>::new());
    }
}

/// Somebody who may not do everything: the tests may run as root.
const NOBODY: &str = "exec setpriv --reuid 65534 --regid 65534 --clear-groups --no-new-privs \"$0\" \"$@\"";

#[test]
fn without_permission_nothing_is_written_or_read() {
    let folder = bench();
    let path = |name: &str| folder.path().join(name);
    let rights = |name: &str, mode: u32| fs::set_permissions(path(name), Permissions::from_mode(mode)).unwrap();
    fs::create_dir(path("closed")).unwrap();
    fs::write(path("secret.csv"), "time [s],command [V]\n0,0\n1,1\n").unwrap();
    rights("closed", 0o555);
    rights("secret.csv", 0);
    rights("", 0o755);
    let may = fs::write(path("closed/try"), "").is_ok();
    if may {
        fs::remove_file(path("closed/try")).unwrap();
    }
    let shell = if may { NOBODY } else { "exec \"$0\" \"$@\"" };
    if behind(shell, folder.path(), &["--version"]).status.code() != Some(0) {
        rights("closed", 0o755);
        return at_hand::skipped("this user may do everything, and nobody cannot run the program");
    }
    for (target, arguments) in writing().into_iter().chain(long()) {
        let target = format!("closed/{target}");
        let output = behind(shell, folder.path(), &[arguments.as_slice(), &[target.as_str()]].concat());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains("Permission denied") || message.contains("permission denied"), "{message}");
        assert!(listing(&path("closed")).is_empty(), "{arguments:?}");
    }
    let output = behind(shell, folder.path(), &["inspect", "secret.csv"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("secret.csv"), "{}", text(&output.stderr));
    rights("closed", 0o755);
}

#[test]
fn a_recording_that_ends_while_it_is_read_is_what_was_there_or_refused() {
    let folder = bench();
    let whole = fs::read(folder.path().join("run.csv")).unwrap();
    assert!(Command::new("mkfifo").arg(folder.path().join("pipe.csv")).status().unwrap().success());
    let simulate = ["simulate", "--machine", "machine.toml", "--recording", "pipe.csv", "--out", "simulated.csv"];
    for share in [0, 1, 30, 500, 999] {
        let _ = fs::remove_file(folder.path().join("simulated.csv"));
        let (path, part) = (folder.path().join("pipe.csv"), whole[..whole.len() * share / 1000].to_vec());
        let writer = thread::spawn(move || fs::OpenOptions::new().write(true).open(path).unwrap().write_all(&part));
        let output = super::run(folder.path(), &simulate);
        let _ = writer.join().unwrap();
        let message = text(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 2)) && !message.contains("panicked"), "{share}: {message}");
        assert_eq!(folder.path().join("simulated.csv").exists(), output.status.code() == Some(0), "{share}");
    }
    // A file that shrinks under the reader's hands.
    let long = folder.path().join("long.csv");
    let rows = whole.iter().position(|&byte| byte == b'\n').unwrap() + 1;
    for attempt in 0..4 {
        let further: Vec<u8> = (0..400_000).flat_map(|row| format!("{row},0,0,0,0,0\n").into_bytes()).collect();
        let head = [&whole[..rows], &further].concat();
        fs::write(&long, head).unwrap();
        let mut child = super::program(folder.path(), &["inspect", "long.csv"]);
        let child = child.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(20 * attempt));
        fs::OpenOptions::new().write(true).open(&long).unwrap().set_len(20_000).unwrap();
        let output = child.wait_with_output().unwrap();
        let message = text(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 2)) && !message.contains("panicked"), "{message}");
    }
}

/// Kills commands at several shares of the time they take: what is there afterwards is the old file or the new one.
fn killed_in_the_middle(commands: &Commands, shares: &[f64]) {
    for (target, arguments) in commands {
        let folder = bench();
        let arguments = with(arguments, target);
        let read = |name: &str| fs::read(folder.path().join(name)).ok();
        let started = Instant::now();
        done(folder.path(), &arguments);
        let takes = started.elapsed();
        let whole = read(target).unwrap();
        let inputs = ["machine.toml", "run.csv", "held.csv", "frames.bin"].map(read);
        for share in shares {
            fs::write(folder.path().join(target), "old").unwrap();
            let mut command = super::program(folder.path(), &arguments);
            let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            std::thread::sleep(takes.mul_f64(*share));
            // SIGKILL; it may have ended by then.
            let _ = child.kill();
            child.wait().unwrap();
            let found = read(target).unwrap();
            assert!(found == b"old" || found == whole, "{arguments:?} at {share}: {} bytes", found.len());
            assert_eq!(
                ["machine.toml", "run.csv", "held.csv", "frames.bin"].map(read),
                inputs,
                "{arguments:?} at {share}"
            );
        }
        done(folder.path(), &arguments);
        assert_eq!(read(target).unwrap(), whole, "{arguments:?}: once more");
        // Of those that were killed while they wrote, a temporary file may be left, and nothing else.
        for path in listing(folder.path()) {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let ours = [target, "machine.toml", "run.csv", "held.csv", "frames.bin"].contains(&name.as_str());
            assert!(ours || name.starts_with(".host-sim-"), "{arguments:?}: {name}");
        }
    }
}

#[test]
fn a_command_that_is_killed_leaves_the_old_file_or_the_new_one() {
    killed_in_the_middle(&writing(), &[0.3, 0.7, 0.95]);
}

#[test]
#[ignore = "minutes: cargo test -p host-sim --test cli killed -- --ignored"]
fn a_long_command_that_is_killed_leaves_the_old_file_or_the_new_one() {
    killed_in_the_middle(&long(), &[0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 0.99, 1.0]);
    killed_in_the_middle(&writing(), &[0.05, 0.2, 0.4, 0.6, 0.8, 0.9, 0.93, 0.96, 0.98, 0.99, 1.0, 1.01]);
}

#[test]
fn a_reader_that_leaves_takes_nothing_from_the_results() {
    for (target, arguments) in writing() {
        let folder = bench();
        let mut command = super::program(folder.path(), &with(&arguments, target));
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {message}");
        assert!(!message.contains("panicked"), "{message}");
        assert!(fs::metadata(folder.path().join(target)).unwrap().len() > 0);
    }
}

#[test]
fn a_lot_is_whole_and_an_exit_code_true_for_a_reader_that_leaves() {
    let left = |folder: &Path, arguments: &[&str]| {
        let mut child =
            super::program(folder, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        (output.status.code(), text(&output.stderr))
    };
    let folder = bench();
    let draw = ["--quiet", "testbed", "draw", "--count", "2", "--effects", "none", "--out", "cases"];
    assert_eq!(left(folder.path(), &draw), (Some(0), String::new()));
    assert_eq!(listing(&folder.path().join("cases")).len(), 3, "two cases and their truth");

    let compare =
        ["compare", "--machine", "machine.toml", "--recording", "run.csv", "--exit-code", "--tolerance", "99.99"];
    assert_eq!(left(folder.path(), &compare).0, Some(1));
}

#[test]
fn a_pipe_whose_reader_leaves_has_not_got_the_result() {
    let folder = bench();
    assert!(Command::new("mkfifo").arg(folder.path().join("pipe.csv")).status().unwrap().success());
    let simulate = ["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out", "pipe.csv"];
    let output = behind("head -c 1 pipe.csv >first & \"$0\" \"$@\"", folder.path(), &simulate);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("pipe.csv: cannot be written"), "{message}");
}

#[test]
fn standard_output_that_is_a_file_is_written_after_what_is_there() {
    let folder = bench();
    let inspect = ["inspect", "run.csv", "--json", "/dev/stdout"];
    let output = behind("echo before; exec \"$0\" \"$@\" >>both", folder.path(), &inspect);
    assert_eq!((output.status.code(), text(&output.stdout)), (Some(0), "before\n".to_owned()));
    let both = fs::read_to_string(folder.path().join("both")).unwrap();
    let (json, table) = both.split_at(both.find("\n}\n").unwrap() + 3);
    assert!(json.starts_with('{') && table.contains("position"), "{both}");
    assert!(fs::symlink_metadata("/dev/stdout").unwrap().is_symlink());
}

#[test]
fn two_results_do_not_get_one_file() {
    let folder = bench();
    let simulate =
        ["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out", "run", "--plot", "./run"];
    let message = refused(folder.path(), &simulate);
    assert!(message.contains("--out and --plot both name ./run; expected two files"), "{message}");
    let diagnose =
        ["diagnose", "--machine", "machine.toml", "--train", "run.csv", "--json", "out", "--save-machine", "out"];
    let message = refused(folder.path(), &diagnose);
    assert!(message.contains("--json and --save-machine both name out"), "{message}");
}

/// A pipe in the folder into which that many rows are written at most; how many were, once it is closed.
fn piped(folder: &Path, rows: u32) -> JoinHandle<usize> {
    let path = folder.join("pipe.csv");
    assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
    thread::spawn(move || {
        let mut pipe = std::io::BufWriter::new(fs::OpenOptions::new().write(true).open(path).unwrap());
        writeln!(pipe, "time [s],command [V],spool,position [m],pressure_a [bar],pressure_b [bar]").unwrap();
        (0..rows).take_while(|row| writeln!(pipe, "{row}e-3,1.5,0.1,0.2,30,40").is_ok()).count()
    })
}

#[test]
#[ignore = "3 GB through a pipe, some minutes: cargo test -p host-sim --test cli hundred_million -- --ignored"]
fn hundred_million_rows_are_simulated_in_the_memory_of_one() {
    let (folder, rows) = (bench(), 100_000_000);
    let writer = piped(folder.path(), rows);
    let simulate = ["simulate", "--machine", "machine.toml", "--recording", "pipe.csv", "--out", "-"];
    // 600 MB of addresses.
    let counted = "ulimit -v 600000; \"$0\" \"$@\" | awk 'END { print NR; print }'";
    let output = behind(counted, folder.path(), &simulate);
    let (message, found) = (text(&output.stderr), text(&output.stdout));
    assert_eq!(writer.join().unwrap(), rows as usize, "{message}");
    let (lines, last) = found.trim_end().split_once('\n').unwrap_or_default();
    assert_eq!(lines, (rows + 1).to_string(), "{message}");
    assert!(last.starts_with("99999.999,1.5,"), "{last}");
}

#[test]
#[ignore = "1 GB through a pipe: cargo test -p host-sim --test cli hundred_million -- --ignored"]
fn hundred_million_rows_that_would_have_to_be_held_are_refused_before_memory_is_gone() {
    let folder = bench();
    let writer = piped(folder.path(), 100_000_000);
    let simulate = ["simulate", "--machine", "machine.toml", "--recording", "pipe.csv", "--out", "simulated.parquet"];
    // 4 GB of addresses: twenty million rows of six columns are one, and two while they grow.
    let output = behind("ulimit -v 4000000; exec \"$0\" \"$@\"", folder.path(), &simulate);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("more than 20000000 rows") && message.contains("a part of it"), "{message}");
    assert!(!folder.path().join("simulated.parquet").exists());
    let written = writer.join().unwrap();
    assert!(written < 21_000_000, "{written} rows were taken");
}
