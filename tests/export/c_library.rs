//! A baked drive in C, as a stranger uses it: header and library from the commands of docs/export.md, compiled with every warning, and compared with the drive
//! that is built from SI values, bit for bit; on the host, and on the emulated target where there is a C compiler for it.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use machine_file::MachineFile;
use model_core::drive::{Drive, DriveInput, DriveState};
use model_core::machine::{Machine, Source, Tick};
use model_core::number::{Number, PerUnit};
use model_core::ports::ChamberState;
use mps2::trial::{Input, Moment, SETS, mass, press, pump};
use system_tests::at_hand::skipped;
use system_tests::emulator::{builds_for, built_in};

use super::{done, text};

const TICKS: usize = 2000;
const STRICT: [&str; 8] =
    ["-std=c99", "-O1", "-Wall", "-Wextra", "-Wconversion", "-Wstrict-prototypes", "-pedantic", "-Werror"];

/// A drive, its folder with header and Rust source, and its inputs.
struct Exported {
    folder: tempfile::TempDir,
    machine: Machine<f64>,
    moments: Vec<Moment>,
}

fn exported(machine: &Machine<f64>, input: Input) -> Exported {
    let folder = tempfile::tempdir().unwrap();
    let [file, header, source] = ["machine.toml", "drive.h", "drive.rs"].map(|name| folder.path().join(name));
    MachineFile::from_machine("drive \"ü\" ??/", *machine).save(&file).unwrap();
    for out in [&header, &source] {
        done(&["export", "--machine", text(&file), "--bake", "--out", text(out)]);
    }
    let moments: Vec<Moment> = input.moments().take(TICKS).collect();
    let exported = Exported { folder, machine: *machine, moments };
    std::fs::write(exported.folder.path().join("inputs.h"), exported.inputs()).unwrap();
    exported
}

impl Exported {
    /// The inputs as C; the load at the tick's start is held over it.
    fn inputs(&self) -> String {
        let mut inputs = format!("#define TICKS {TICKS}U\nstatic const drive_input_t inputs[TICKS] = {{\n");
        let word = |signal: PerUnit| match signal.to_bits() {
            i32::MIN => "INT32_MIN".to_owned(),
            bits => bits.to_string(),
        };
        for moment in &self.moments {
            let load = word(moment.load.from);
            let line = match moment.drive_input {
                DriveInput::Command(command) => format!("{}, {load}", word(command)),
                DriveInput::Pump(pump) => format!("{}, {}, {load}", word(pump.speed), pump.direction),
                DriveInput::Force { .. } => load,
                other => panic!("not an input of C: {other:?}"),
            };
            writeln!(inputs, "    {{ {line} }},").unwrap();
        }
        let [a, b] = pressures();
        let middle = PerUnit::travel(0.5).to_bits();
        writeln!(inputs, "}};\nstatic const drive_rest_t rest = {{ INT64_C({middle}), 0, {}, {} }};", word(a), word(b))
            .unwrap();
        inputs
    }

    /// What the drive's sensors read that is built from SI values.
    fn readings(&self) -> String {
        let drive = Drive::<PerUnit>::new::<64>(&self.machine, Tick::OneMillisecond).unwrap();
        let [a, b] = pressures();
        let mut state: DriveState<PerUnit, 64> =
            drive.at_rest(PerUnit::ZERO, ChamberState { a, b }, PerUnit::travel(0.5));
        let mut readings = String::new();
        for moment in &self.moments {
            let mut load = moment.load;
            load.to = load.from;
            let drive_input = match moment.drive_input {
                DriveInput::Force { .. } => DriveInput::Force { from: PerUnit::ZERO, to: PerUnit::ZERO },
                other => other,
            };
            drive.step(&mut state, drive_input, load);
            let read = drive.sensed(&state);
            write!(readings, "{:016x}", read.position.to_bits()).unwrap();
            for signal in [read.velocity, read.spool, read.pressure_a, read.pressure_b] {
                write!(readings, "{:08x}", signal.to_bits()).unwrap();
            }
            readings.push('\n');
        }
        readings
    }

    /// The static library for a target, or for the host.
    fn library(&self, target: Option<&str>) -> PathBuf {
        assert_well(&build(&self.folder.path().join("drive.rs"), target));
        let library = self.folder.path().join("libdrive.a");
        std::fs::copy(built_in(BUILT).join(target.unwrap_or("")).join("release/libdrive.a"), &library).unwrap();
        library
    }

    fn compile(&self, compiler: &str, source: &Path, options: &[&str], after: &[&str]) -> PathBuf {
        let program = self.folder.path().join("program");
        let mut command = Command::new(compiler);
        command.args(STRICT).args(options).arg("-I").arg(self.folder.path()).arg(source);
        command.arg(self.folder.path().join("libdrive.a")).args(after).arg("-o").arg(&program);
        assert_well(&command.output().unwrap());
        program
    }
}

fn pressures() -> [PerUnit; 2] {
    [0.3, 0.5].map(PerUnit::saturated)
}

/// The name of the folder where libraries are built: that of the images, in which `tests/run` has built the model for the targets.
const BUILT: &str = "on_target";

/// Builds the library of an exported drive for a target, or for the host.
fn build(drive: &Path, target: Option<&str>) -> Output {
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .args(["build", "--quiet", "--release", "--locked", "--package", "drive-c", "--target-dir"])
        .arg(built_in(BUILT));
    cargo.args(target.iter().flat_map(|target| ["--target", *target])).env("DRIVE", drive);
    cargo.current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).output().unwrap()
}

/// The library of another drive is never left in its place.
#[test]
fn a_drive_that_cannot_be_read_ends_the_build_with_its_path() {
    let output = build(Path::new("/nowhere/drive.rs"), None);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && errors.contains("/nowhere/drive.rs: cannot be taken in"), "{errors}");
}

fn assert_well(output: &Output) {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn assert_same(built: &str, in_c: &str, name: &str) {
    assert_eq!(built.lines().count(), TICKS);
    for (tick, (built, in_c)) in built.lines().zip(in_c.lines()).enumerate() {
        assert_eq!(built, in_c, "{name}, tick {tick}: built, then in C");
    }
    assert_eq!(in_c.lines().count(), TICKS, "{name}");
}

fn is_there(program: &str) -> bool {
    let there = Command::new(program).arg("--version").output().is_ok();
    if !there {
        skipped(&format!("there is no {program}"));
    }
    there
}

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// What Rust's standard library asks the host's linker for.
const HOST: [&str; 3] = ["-lpthread", "-ldl", "-lm"];

#[test]
fn a_c_program_on_the_host_reads_what_the_built_drive_reads() {
    if !is_there("cc") {
        return;
    }
    let several = SETS.iter().map(|set| (set.name, set.on(&press()), Input::Random));
    let plain = [("press", press(), Input::Random), ("pump", pump(), Input::Pump), ("mass", mass(), Input::Force)];
    for (name, machine, input) in plain.into_iter().chain(several) {
        let exported = exported(&machine, input);
        exported.library(None);
        let program = exported.compile("cc", &here("export/trace.c"), &[], &HOST);
        let printed = Command::new(program).output().unwrap();
        assert_well(&printed);
        assert_same(&exported.readings(), &String::from_utf8(printed.stdout).unwrap(), name);
    }
}

#[test]
fn a_c_program_on_the_emulated_target_reads_what_the_built_drive_reads() {
    let targets = ["thumbv6m-none-eabi", "thumbv7m-none-eabi", "thumbv7em-none-eabihf"];
    if !is_there("arm-none-eabi-gcc")
        || !is_there("qemu-system-arm")
        || !targets.iter().all(|target| builds_for(target))
    {
        return;
    }
    let boards = [
        (
            "thumbv7em-none-eabihf",
            "mps2-an386",
            "cortex-m4",
            &["-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"][..],
        ),
        ("thumbv7m-none-eabi", "mps2-an385", "cortex-m3", &["-mcpu=cortex-m3"]),
        ("thumbv6m-none-eabi", "mps2-an385", "cortex-m3", &["-mcpu=cortex-m0"]),
    ];
    let exported = exported(&SETS[0].on(&press()), Input::Random);
    let script = text(&here("export/target.ld")).to_owned();
    for (target, machine, processor, options) in boards {
        exported.library(Some(target));
        let options: Vec<&str> =
            options.iter().copied().chain(["-mthumb", "-ffreestanding", "-nostdlib", "-T", &script]).collect();
        let program = exported.compile("arm-none-eabi-gcc", &here("export/trace.c"), &options, &[]);
        let printed = Command::new("qemu-system-arm")
            .args(["-machine", machine, "-cpu", processor, "-nographic"])
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(program)
            .output()
            .unwrap();
        assert_well(&printed);
        assert_same(&exported.readings(), &String::from_utf8(printed.stderr).unwrap(), target);
    }
}

#[test]
fn the_library_is_built_for_every_family_of_cortex_m() {
    let exported = exported(&press(), Input::Random);
    for target in ["thumbv6m-none-eabi", "thumbv7m-none-eabi", "thumbv7em-none-eabihf", "thumbv8m.main-none-eabihf"] {
        if !builds_for(target) {
            continue;
        }
        assert!(exported.library(Some(target)).metadata().unwrap().len() > 0);
    }
}

#[test]
fn the_examples_compile_with_every_warning_and_move_the_rod() {
    if !is_there("cc") {
        return;
    }
    let exported = exported(&press(), Input::Random);
    exported.library(None);
    for example in ["superloop.c", "plc.c"] {
        let program = exported.compile("cc", &here("../drive-c/examples").join(example), &[], &HOST);
        let printed = Command::new(program).output().unwrap();
        assert_well(&printed);
        let printed = String::from_utf8(printed.stdout).unwrap();
        let positions: Vec<f64> = printed
            .lines()
            .map(|line| line.split_once("ms").unwrap().1.split_once("mm").unwrap().0.trim().parse().unwrap())
            .collect();
        // From the middle of 300 mm outwards, and on no farther once the valve has closed.
        assert!(positions.len() >= 4 && positions[0] > 150.5 && positions[1] > positions[0], "{example}: {printed}");
        let [.., before, last] = positions[..] else { panic!("{printed}") };
        assert!(before > 155.0 && (last - before).abs() < 1.0, "{example}: {printed}");
    }
}

#[test]
fn the_header_has_the_inputs_of_its_source_and_no_other() {
    for (machine, input, has, has_not) in [
        (press(), Input::Random, "int32_t command_q28;", "pump_speed_q28"),
        (pump(), Input::Pump, "int32_t pump_speed_q28;", "int32_t command_q28; /* command"),
        (mass(), Input::Force, "int32_t force_q28;", "load_q28"),
    ] {
        let exported = exported(&machine, input);
        let header = std::fs::read_to_string(exported.folder.path().join("drive.h")).unwrap();
        assert!(header.contains(has) && !header.contains(has_not), "{header}");
        assert_eq!(header.contains("DRIVE_PRESSURE_BASE_PA"), exported.machine.source != Source::Force, "{header}");
        assert!(!header.contains("oil_temperature"), "{header}");
    }
}
