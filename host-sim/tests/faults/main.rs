//! Failures while the program works: a full disk, a folder without permission to write, a file that ends while it is read, a
//! process that is killed. Existing files stay, nothing is half-written, and the same command works when it is run again.
#![cfg(unix)]

#[allow(dead_code, reason = "no recording of others is needed here")]
#[path = "../at_hand/mod.rs"]
mod at_hand;
mod names;
#[path = "../process/mod.rs"]
mod process;

use std::collections::BTreeMap;
use std::fs::{self, Permissions};
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use process::{MACHINE, PRESS, done, example, listing, program, refused, run, streamed, text};

/// Commands that write files or a folder; the target follows one of [`RESULTS`].
const WRITING: [&str; 16] = [
    "simulate --machine machine.toml --recording run.csv --out simulated.csv",
    "simulate --machine machine.toml --recording run.csv --out simulated.mat",
    "simulate --machine machine.toml --recording run.csv --out simulated.parquet",
    "simulate --machine machine.toml --recording run.csv --out - --plot simulated.svg",
    "compare --machine machine.toml --recording run.csv --plot compared.svg",
    "statics --recording run.csv --input command --output position --json statics.json --plot statics.svg",
    "inspect run.csv --machine machine.toml --json held.json",
    "export --machine machine.toml --out params.rs",
    "export --machine machine.toml --out drive.h",
    "export --machine machine.toml --library library.so --out drive.fmu",
    "import --frames frames.bin --out taken.csv",
    "fit --machine machine.toml --train run.csv --save-machine fitted.toml",
    "diagnose --machine machine.toml --train run.csv --holdout held.csv --json found.json --save-machine found.toml \
     --report found.html --plot found.svg",
    "plan --machine machine.toml --sensors position --seconds 6 --out excitation.csv --json plan.json --plot plan.svg",
    "testbed --machine machine.toml --train step:4V,0.1s --holdout zero:0.1s --out case",
    "testbed draw --count 1 --effects none --out cases",
];

/// The options that name the target.
const RESULTS: [&str; 5] = ["--out", "--json", "--plot", "--report", "--save-machine"];

/// A folder with a machine, two recordings, a stream of a recorder, and a file that passes for an FMU's library.
fn bench() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    // The shortest recordings of the example: with them a diagnosis takes about a second.
    for (from, name) in [("machine.toml", "machine.toml"), ("train-3.csv", "run.csv"), ("train-4.csv", "held.csv")] {
        fs::copy(example(from), folder.path().join(name)).unwrap();
    }
    fs::write(folder.path().join("frames.bin"), streamed()).unwrap();
    fs::write(folder.path().join("library.so"), "fmi2Instantiate fmi3InstantiateCoSimulation").unwrap();
    folder
}

/// Runs the program from a line of the shell that ends with `exec "$0" "$@"`.
fn behind(shell: &str, folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new("sh");
    command.args(["-c", shell, env!("CARGO_BIN_EXE_host-sim")]).args(arguments).current_dir(folder);
    command.output().unwrap()
}

/// The arguments of all of [`WRITING`], and of `init`.
fn writing() -> Vec<Vec<&'static str>> {
    let init = [&PRESS[..], &["--force"]].concat();
    WRITING.iter().map(|command| command.split(' ').collect()).chain([init]).collect()
}

/// The targets of a command with these arguments, except standard output.
fn results<'a>(arguments: &[&'a str]) -> impl Iterator<Item = &'a str> {
    arguments.windows(2).filter(|pair| RESULTS.contains(&pair[0])).map(|pair| pair[1]).filter(|result| *result != "-")
}

type Files = BTreeMap<PathBuf, Vec<u8>>;

/// Every file in a folder and below it, with its content.
fn files(folder: &Path) -> Files {
    let inside = |path: PathBuf| {
        if path.is_dir() {
            return files(&path);
        }
        let content = fs::read(&path).unwrap();
        Files::from([(path, content)])
    };
    listing(folder).into_iter().flat_map(inside).collect()
}

/// Replaces each file that was not there before by an old file; returns the files that are there then.
fn aged(folder: &Path, before: &Files) -> Files {
    for path in files(folder).keys().filter(|path| !before.contains_key(*path)) {
        fs::write(path, "old").unwrap();
    }
    files(folder)
}

#[test]
fn where_a_file_cannot_grow_the_old_one_stays_and_none_is_cut() {
    for arguments in writing() {
        let folder = bench();
        let before = files(folder.path());
        done(folder.path(), &arguments);
        let new = files(folder.path());
        let old = aged(folder.path(), &before);
        // No file may become longer than this number of blocks: as on a full disk, writing fails, at once or in the middle.
        for blocks in [0, 1, 16] {
            let shell = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
            let output = behind(&shell, folder.path(), &arguments);
            let (message, code) = (text(&output.stderr), output.status.code());
            let names_one = results(&arguments).any(|result| message.contains(result));
            let refused = code == Some(2) && names_one && message.contains("cannot be written");
            assert!(refused || blocks > 0 && code == Some(0), "{arguments:?}, {blocks}: {message}");
            let found = files(folder.path());
            assert!(found.keys().eq(old.keys()), "{arguments:?}, {blocks}: {:?}", found.keys());
            let is_whole = |(path, bytes)| bytes == &old[path] || blocks > 0 && bytes == &new[path];
            assert!(found.iter().all(is_whole), "{arguments:?}, {blocks}");
        }
    }
}

/// A file system of its own, where the user is allowed to mount one.
#[test]
fn a_disk_that_is_full_keeps_what_it_has() {
    let folder = bench();
    let disk = folder.path().join("disk");
    fs::create_dir(&disk).unwrap();
    let mounted = "mount -t tmpfs -o size=16k none disk && printf old >disk/simulated.csv || exit 77; \
        \"$0\" \"$@\"; code=$?; [ \"$(ls -A disk)\" = simulated.csv ] && [ \"$(cat disk/simulated.csv)\" = old ] && exit $code; exit 78";
    let simulate = ["simulate", "--machine", "machine.toml", "--recording", "run.csv", "--out", "disk/simulated.csv"];
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
fn a_folder_for_a_file_or_a_file_for_a_folder_is_refused_before_anything_is_done() {
    for arguments in writing() {
        for result in results(&arguments) {
            let folder = bench();
            let place = folder.path().join(result);
            let expected = if arguments[0] == "testbed" {
                fs::write(place, "old").unwrap();
                "a folder that can be written to"
            } else {
                fs::create_dir(place).unwrap();
                "this is a folder"
            };
            let before = files(folder.path());
            let message = refused(folder.path(), &arguments);
            assert!(message.contains(result) && message.contains(expected), "{arguments:?}: {message}");
            assert!(files(folder.path()) == before, "{arguments:?}");
        }
    }
}

/// Runs a command as a user with no privileges: the tests may run as root.
const NOBODY: &str = "exec setpriv --reuid 65534 --regid 65534 --clear-groups --no-new-privs \"$0\" \"$@\"";

#[test]
fn without_permission_nothing_is_written_or_read() {
    let folder = bench();
    let path = |name: &str| folder.path().join(name);
    let rights = |name: &str, mode: u32| fs::set_permissions(path(name), Permissions::from_mode(mode)).unwrap();
    fs::write(path("secret.csv"), "time [s],command [V]\n0,0\n1,1\n").unwrap();
    for file in listing(folder.path()) {
        fs::set_permissions(&file, Permissions::from_mode(if file.is_dir() { 0o755 } else { 0o644 })).unwrap();
    }
    rights("secret.csv", 0);
    rights("", 0o555);
    let may = fs::write(path("try"), "").is_ok();
    if may {
        fs::remove_file(path("try")).unwrap();
    }
    let shell = if may { NOBODY } else { "exec \"$0\" \"$@\"" };
    if behind(shell, folder.path(), &["--version"]).status.code() != Some(0) {
        rights("", 0o755);
        return at_hand::skipped("this user may do everything, and nobody cannot run the program");
    }
    let before = listing(folder.path());
    for arguments in writing() {
        let output = behind(shell, folder.path(), &arguments);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.to_lowercase().contains("permission denied"), "{message}");
        let names_one = results(&arguments).any(|result| message.contains(result));
        assert!(names_one && message.contains("cannot be written"), "{arguments:?}: {message}");
        assert_eq!(listing(folder.path()), before, "{arguments:?}");
    }
    let output = behind(shell, folder.path(), &["inspect", "secret.csv"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("secret.csv"), "{}", text(&output.stderr));
    rights("", 0o755);
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
        let output = run(folder.path(), &simulate);
        let _ = writer.join().unwrap();
        let message = text(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 2)) && !message.contains("panicked"), "{share}: {message}");
        assert_eq!(folder.path().join("simulated.csv").exists(), output.status.code() == Some(0), "{share}");
    }
    // A file that shrinks while it is read.
    let long = folder.path().join("long.csv");
    let rows = whole.iter().position(|&byte| byte == b'\n').unwrap() + 1;
    for attempt in 0..4 {
        let further: Vec<u8> = (0..400_000).flat_map(|row| format!("{row},0,0,0,0,0\n").into_bytes()).collect();
        let head = [&whole[..rows], &further].concat();
        fs::write(&long, head).unwrap();
        let mut child = program(folder.path(), &["inspect", "long.csv"]);
        let child = child.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(20 * attempt));
        fs::OpenOptions::new().write(true).open(&long).unwrap().set_len(20_000).unwrap();
        let output = child.wait_with_output().unwrap();
        let message = text(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 2)) && !message.contains("panicked"), "{message}");
    }
}

/// Kills commands after several shares of the time that they take: each file is afterwards the old one or the new one.
fn killed_in_the_middle(shares: &[f64]) {
    let is_temporary = |path: &Path| path.file_name().unwrap().to_string_lossy().starts_with(".host-sim-");
    for arguments in writing() {
        let folder = bench();
        let before = files(folder.path());
        let started = Instant::now();
        done(folder.path(), &arguments);
        let takes = started.elapsed();
        let whole = files(folder.path());
        // A command that was killed while it wrote may leave a temporary file, and nothing else.
        let found = || {
            let mut found = files(folder.path());
            found.retain(|path, _| !is_temporary(path));
            found
        };
        for share in shares {
            let old = aged(folder.path(), &before);
            let mut command = program(folder.path(), &arguments);
            let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            thread::sleep(takes.mul_f64(*share));
            // SIGKILL; the command may have ended by then.
            let _ = child.kill();
            child.wait().unwrap();
            let found = found();
            assert!(found.keys().eq(whole.keys()), "{arguments:?} at {share}: {:?}", found.keys());
            for (path, content) in &found {
                let is_old_or_new = *content == old[path] || *content == whole[path];
                assert!(is_old_or_new, "{arguments:?} at {share}: {}: {} bytes", path.display(), content.len());
            }
        }
        done(folder.path(), &arguments);
        assert!(found() == whole, "{arguments:?}: once more");
    }
}

#[test]
fn a_command_that_is_killed_leaves_old_files_or_new_ones() {
    killed_in_the_middle(&[0.3, 0.7, 0.95]);
}

#[test]
#[ignore = "minutes: cargo test -p host-sim --features virtual-plant --test faults killed -- --ignored"]
fn a_command_that_is_killed_at_any_moment_leaves_old_files_or_new_ones() {
    killed_in_the_middle(&[0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.93, 0.96, 0.98, 0.99, 1.0, 1.01]);
}

#[test]
fn a_reader_that_leaves_takes_nothing_from_the_results() {
    for arguments in writing() {
        let folder = bench();
        let mut command = program(folder.path(), &arguments);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {message}");
        assert!(!message.contains("panicked"), "{message}");
        assert!(results(&arguments).all(|result| folder.path().join(result).exists()), "{arguments:?}");
        assert!(files(folder.path()).values().all(|content| !content.is_empty()), "{arguments:?}");
    }
}

#[test]
fn a_lot_is_whole_and_an_exit_code_true_for_a_reader_that_leaves() {
    let left = |folder: &Path, arguments: &[&str]| {
        let mut child = program(folder, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
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

/// A pipe in the folder into which at most this number of rows is written; returns how many were written when it was closed.
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
#[ignore = "3 GB through a pipe, some minutes: cargo test -p host-sim --features virtual-plant --test faults hundred_million -- --ignored"]
fn hundred_million_rows_are_simulated_in_the_memory_of_one() {
    let (folder, rows) = (bench(), 100_000_000);
    let writer = piped(folder.path(), rows);
    let simulate = ["simulate", "--machine", "machine.toml", "--recording", "pipe.csv", "--out", "-"];
    // 600 MB of address space.
    let counted = "ulimit -v 600000; \"$0\" \"$@\" | awk 'END { print NR; print }'";
    let output = behind(counted, folder.path(), &simulate);
    let (message, found) = (text(&output.stderr), text(&output.stdout));
    assert_eq!(writer.join().unwrap(), rows as usize, "{message}");
    let (lines, last) = found.trim_end().split_once('\n').unwrap_or_default();
    assert_eq!(lines, (rows + 1).to_string(), "{message}");
    assert!(last.starts_with("99999.999,1.5,"), "{last}");
}

#[test]
#[ignore = "1 GB through a pipe: cargo test -p host-sim --features virtual-plant --test faults hundred_million -- --ignored"]
fn hundred_million_rows_that_would_have_to_be_held_are_refused_before_memory_is_gone() {
    let folder = bench();
    let writer = piped(folder.path(), 100_000_000);
    let simulate = ["simulate", "--machine", "machine.toml", "--recording", "pipe.csv", "--out", "simulated.parquet"];
    // 4 GB of address space: twenty million rows of six columns take one of them, and two while the memory grows.
    let output = behind("ulimit -v 4000000; exec \"$0\" \"$@\"", folder.path(), &simulate);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("more than 20000000 rows") && message.contains("a part of it"), "{message}");
    assert!(!folder.path().join("simulated.parquet").exists());
    let written = writer.join().unwrap();
    assert!(written < 21_000_000, "{written} rows were taken");
}
