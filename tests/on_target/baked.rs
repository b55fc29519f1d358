//! Baked drives compute what drives that are built from SI values compute, bit for bit: the coefficients' words, every word of the state, every output; on
//! the host and on the target.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use model_core::machine::{Machine, Tick};
use model_core::number::{PerUnit, Single};
use model_export::rust::{BakedNumber, Constants};
use mps2::trial::{Case, Input, SETS, Traced, cases, every_effect, press};
use system_tests::emulator::{Processor, run_on_host};
use tempfile::TempDir;

/// Baked drives as files, and the list of them that binaries of the firmware take in.
pub(crate) struct Exports {
    folder: TempDir,
    list: String,
    files: String,
    count: usize,
}

impl Exports {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self { folder, list: String::new(), files: String::new(), count: 0 }
    }

    /// Adds a drive in a number type with the inputs that it is tried under; returns its file.
    pub(crate) fn add<N: BakedNumber>(
        &mut self,
        name: &str,
        machine: &Machine<f64>,
        inputs: &[(Input, String)],
    ) -> PathBuf {
        let number = self.count;
        self.count += 1;
        let file = self.folder.path().join(format!("drive_{number}.rs"));
        let constants = Constants::of(name, machine, Tick::OneMillisecond).unwrap();
        std::fs::write(&file, constants.baked::<N>().unwrap()).unwrap();
        write!(self.list, "    drive_{number} {name:?}:").unwrap();
        for (input, case) in inputs {
            write!(self.list, " ({input:?}, {case:?})").unwrap();
        }
        self.list.push_str(";\n");
        writeln!(
            self.files,
            "#[allow(dead_code, unreachable_pub)]\nmod drive_{number} {{\n    include!({:?});\n}}",
            file.to_string_lossy()
        )
        .unwrap();
        file
    }

    /// The file of the list.
    pub(crate) fn list(&self) -> PathBuf {
        let list = self.folder.path().join("trials.rs");
        std::fs::write(&list, format!("drives! {{\n{}}}\n{}", self.list, self.files)).unwrap();
        list
    }
}

/// The baked drives whose cost is counted, by their names: the paper's model, what installed drives have, everything.
pub(crate) fn counted() -> impl Iterator<Item = (&'static str, Machine<f64>)> {
    let plain = press();
    let several = SETS.iter().map(move |set| (set.name, set.on(&plain)));
    [("paper's model", plain)].into_iter().chain(several).chain([("every effect", every_effect(&plain))])
}

/// Of which drives: each is compiled by itself, which takes long.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Of {
    /// All of the press and of the mass, and of the pump those with several effects or none.
    EachEffect,
    /// Those with several effects or none alone.
    Several,
}

/// Trials of baked drives, by their machines.
fn trials(of: Of) -> Vec<(Machine<f64>, Vec<Case>)> {
    let mut trials: Vec<(String, Machine<f64>, Vec<Case>)> = Vec::new();
    for case in cases() {
        let name = case.to_string();
        let is_several = ["no effect", "effects", "every effect"].iter().any(|set| name.contains(set));
        if !is_several && (of == Of::Several || case.input() == Input::Pump) {
            continue;
        }
        // Not a number is not equal to itself, its text is.
        let machine = case.machine();
        let text = format!("{machine:?}");
        match trials.iter_mut().find(|(known, ..)| *known == text) {
            Some((.., cases)) => cases.push(case),
            None => trials.push((text, machine, vec![case])),
        }
    }
    trials.into_iter().map(|(_, machine, cases)| (machine, cases)).collect()
}

/// Compares the traces of a binary that takes in the list with those of the drives that are built, in a number type.
fn assert_traces<N: Traced + BakedNumber>(of: Of, traced: impl Fn(&Path) -> String) {
    let (mut exports, mut built) = (Exports::new(), String::new());
    for (machine, cases) in trials(of) {
        let inputs: Vec<(Input, String)> =
            cases.iter().map(|case| (case.input(), format!("{}{case}", N::PREFIX))).collect();
        exports.add::<N>(&inputs[0].1, &machine, &inputs);
        for case in &cases {
            case.trace::<N>(&mut built).unwrap_or_else(|error| panic!("{case}: {error:?}"));
        }
    }
    let baked = traced(&exports.list());
    for (number, (built, baked)) in built.lines().zip(baked.lines()).enumerate() {
        assert_eq!(built, baked, "line {} of the trace: built, then baked", number + 1);
    }
    assert_eq!(built.lines().count(), baked.lines().count());
    let least = if of == Of::EachEffect { 50 } else { 10 };
    assert!(exports.count > least, "{}", exports.count);
}

#[test]
fn a_baked_drive_computes_what_the_built_one_does_on_the_host() {
    let traced = |list: &Path| run_on_host(&[("FIRMWARE_BAKED_TRIALS", list)], "baked_trials");
    assert_traces::<PerUnit>(Of::EachEffect, traced);
    assert_traces::<Single>(Of::EachEffect, traced);
}

#[test]
fn a_baked_drive_computes_what_the_built_one_does_on_the_target() {
    for processor in Processor::ALL {
        if processor.can_be_emulated() {
            let traced = |list: &Path| processor.run_with(&[("FIRMWARE_BAKED_TRIALS", list)], "baked_trials");
            match processor {
                Processor::M4F => {
                    assert_traces::<PerUnit>(Of::EachEffect, traced);
                    assert_traces::<Single>(Of::EachEffect, traced);
                }
                // Each effect by itself is compared as it is built (parity.rs). No FPU, no single precision.
                Processor::M3 => assert_traces::<PerUnit>(Of::Several, traced),
            }
        }
    }
}

#[test]
fn the_firmwares_own_baked_drive_is_the_export_of_the_preset() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let preset = machine_file::read(&root.join("presets/press-63-40.toml")).unwrap();
    let written =
        Constants::of(&preset.name, &preset.machine, Tick::OneMillisecond).unwrap().baked::<PerUnit>().unwrap();
    let kept = root.join("firmware/baked.rs");
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(&kept, &written).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&kept).unwrap(), written, "RENEW=1 writes firmware/baked.rs anew");
}
