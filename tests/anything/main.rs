//! The readers, the coefficients and the step get once more the inputs that the search of `fuzz/` began with and those that it kept,
//! with no more memory and time than a small file may take.

use std::alloc::System;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;
use std::{fs, thread};

use cap::Cap;
use serde::Serialize;

use model_core::drive::{Drive, DriveState};
use model_core::machine::Tick;
use model_core::number::{PerUnit, Scalar, Single};
use model_core::ports::ChamberState;
use system_tests::anything::{TARGETS, machine_file, recording};
use system_tests::drives;
use system_tests::simulate::DELAY;

/// Memory beyond this limit is refused, which ends the process: that is a failure. All threads share it.
#[global_allocator]
static MEMORY: Cap<System> = Cap::new(System, 1 << 30);

/// Longest time for a file: three times what the search (`fuzz/run`) allows, because other tests run beside it.
const LONGEST: Duration = Duration::from_mins(1);

fn corpus(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/corpus").join(target)
}

#[test]
fn nothing_that_was_kept_breaks_anything() {
    if std::env::var_os("RENEW").is_some() {
        write_seeds();
    }
    for (target, feed) in TARGETS {
        let folder = fs::read_dir(corpus(target)).unwrap_or_else(|error| panic!("{target}: {error}"));
        let mut files: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
        files.sort();
        assert!(files.len() >= 4, "{target}: {} files", files.len());
        for file in files {
            feed_file(feed, &file);
        }
    }
}

/// Feeds a file in a thread of its own, which is left running if it does not end; the failed test then ends it with the process.
fn feed_file(feed: fn(&[u8]), file: &Path) {
    let bytes = fs::read(file).unwrap();
    let (done, ended) = mpsc::channel();
    thread::spawn(move || {
        feed(&bytes);
        done.send(())
    });
    let name = file.display();
    match ended.recv_timeout(LONGEST) {
        Ok(()) => {}
        Err(RecvTimeoutError::Timeout) => panic!("{name} takes more than {} s", LONGEST.as_secs()),
        // The thread has panicked and dropped its end.
        Err(RecvTimeoutError::Disconnected) => panic!("cargo test … -- --nocapture says what is wrong with {name}"),
    }
}

#[test]
fn nothing_is_nested_too_deeply_for_the_stack() {
    let deep = 100_000;
    for text in [
        format!("a{} = 1\n", ".a".repeat(deep)),
        format!("[a{}]\n", ".a".repeat(deep)),
        format!("a = {}\n", "[".repeat(deep)),
        format!("a = {}\n", "{a=".repeat(deep)),
        format!("a = {}{}\n", "[".repeat(deep), "]".repeat(deep)),
        "[[a]]\n".repeat(deep),
    ] {
        machine_file(text.as_bytes());
    }
    recording(format!("time [s],{}\n0,0\n", "[".repeat(deep)).as_bytes());
    recording(format!("time [s],x\n0,{}\n", "\"".repeat(deep)).as_bytes());
}

/// An element of a MAT-file.
fn element(kind: u32, content: &[u8]) -> Vec<u8> {
    let length = u32::try_from(content.len()).unwrap();
    let padding = vec![0; content.len().next_multiple_of(8) - content.len()];
    [&kind.to_le_bytes(), &length.to_le_bytes(), content, &padding].concat()
}

#[test]
fn a_long_name_is_not_held_once_for_each_structure() {
    let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    // 4096 structures of one field, whose name is a megabyte: four gigabytes, if each had its own copy.
    let name = vec![b'n'; 1 << 20];
    let fields = element(14, &[]).repeat(4096);
    let parts = [
        element(6, &words(&[2, 0])),
        element(5, &words(&[1, 4096])),
        element(1, b"run"),
        element(5, &words(&[1 << 20])),
        element(1, &name),
        fields,
    ];
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend([0, 1, b'I', b'M']);
    file.extend(element(14, &parts.concat()));
    recording(&file);
}

/// Appends a block to an MDF file; returns its position.
fn block(file: &mut Vec<u8>, id: [u8; 2], links: &[u64], data: &[u8]) -> u64 {
    let at = file.len() as u64;
    let length = 24 + 8 * links.len() as u64 + data.len() as u64;
    file.extend([b'#', b'#', id[0], id[1], 0, 0, 0, 0]);
    file.extend(length.to_le_bytes());
    file.extend((links.len() as u64).to_le_bytes());
    file.extend(links.iter().flat_map(|link| link.to_le_bytes()));
    file.extend(data);
    file.resize(file.len().next_multiple_of(8), 0);
    at
}

#[test]
fn a_long_table_is_not_held_once_for_each_channel() {
    let mut file = b"MDF     4.10    ".to_vec();
    file.resize(64, 0);
    let head = block(&mut file, *b"HD", &[0; 6], &[0; 32]);
    // A table of 65534 numbers, which 4000 channels share: two gigabytes, if each had its own copy.
    let mut table = vec![4, 0, 0, 0, 0, 0, 0xfe, 0xff];
    table.resize(24 + 8 * 0xfffe, 0);
    let table = block(&mut file, *b"CC", &[0; 4], &table);
    let mut channel = 0;
    for _ in 0..4000 {
        channel = block(&mut file, *b"CN", &[channel, 0, 0, 0, table, 0, 0, 0], &[0; 72]);
    }
    let group = [[0; 8], 5_u64.to_le_bytes(), [0; 8], [0; 8]].concat();
    let group = block(&mut file, *b"CG", &[0, channel, 0, 0, 0, 0], &group);
    let first = block(&mut file, *b"DG", &[0, group, 0, 0], &[0; 8]);
    let link = usize::try_from(head).unwrap() + 24;
    file[link..link + 8].copy_from_slice(&first.to_le_bytes());
    recording(&file);
}

/// The first inputs of the search that are in the tests' own coding: drives at rest, unchanged and with changed parameters, and a few
/// entries of every kind.
fn write_seeds() {
    // Kind of drive and tick, number of changes, then each change: parameter, kind of change, and size.
    let machines: [&[u8]; 4] =
        [&[0, 0], &[1, 0], &[2, 2, 3, 3, 4, 9, 1], &[4, 2, 20, 2, 128, 40, 4, 0, 0, 0, 0, 0, 0, 0xf8, 0x7f]];
    for (number, machine) in machines.iter().enumerate() {
        seed("coefficients", number, machine);
        let drive = if machine[0] & 1 == 0 { drives::press() } else { drives::pump() };
        let entries = (0_u8..6).flat_map(|kind| [vec![kind], vec![0x55; 4 * 8 + 2 * 8]].concat()).collect::<Vec<u8>>();
        seed("step_fixed", number, &[machine, at_rest::<PerUnit>(&drive).as_slice(), &entries].concat());
        seed("step_float", number, &[machine, at_rest::<f64>(&drive).as_slice(), &entries].concat());
        seed("step_single", number, &[machine, at_rest::<Single>(&drive).as_slice(), &entries].concat());
    }
}

fn at_rest<N: Scalar<Real = f64> + Serialize>(machine: &model_core::machine::Machine<f64>) -> Vec<u8>
where
    N::Travel: Serialize,
{
    let drive = Drive::<N>::new::<DELAY>(machine, Tick::OneMillisecond).unwrap();
    let pressures = ChamberState { a: N::saturated(0.4), b: N::saturated(0.6) };
    let state: DriveState<N, DELAY> = drive.at_rest(N::saturated(0.1), pressures, N::travel(0.3));
    postcard::to_stdvec(&state).unwrap()
}

fn seed(target: &str, number: usize, bytes: &[u8]) {
    let folder = corpus(target);
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join(format!("seed-{number}")), bytes).unwrap();
}
