//! Builds binaries of the firmware for the targets and runs them under QEMU, where both tools are installed.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use object::{Object, ObjectSection};

use crate::at_hand::skipped;

/// An emulated processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Processor {
    /// Cortex-M4F, `mps2-an386`.
    M4F,
    /// Cortex-M3, `mps2-an385`.
    M3,
}

impl Processor {
    /// Both.
    pub const ALL: [Self; 2] = [Self::M4F, Self::M3];

    /// Its name in a table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Processor::M4F => "Cortex-M4F",
            Processor::M3 => "Cortex-M3",
        }
    }

    const fn target(self) -> &'static str {
        match self {
            Processor::M4F => "thumbv7em-none-eabihf",
            Processor::M3 => "thumbv7m-none-eabi",
        }
    }

    /// QEMU's arguments for it.
    #[must_use]
    pub const fn machine(self) -> [&'static str; 4] {
        match self {
            Processor::M4F => ["-machine", "mps2-an386", "-cpu", "cortex-m4"],
            Processor::M3 => ["-machine", "mps2-an385", "-cpu", "cortex-m3"],
        }
    }

    /// Whether binaries can be built for it; if not, prints that a test is skipped.
    #[must_use]
    pub fn can_be_built_for(self) -> bool {
        builds_for(self.target())
    }

    /// Whether binaries can be built for it and run; if not, prints that a test is skipped.
    #[must_use]
    pub fn can_be_emulated(self) -> bool {
        let emulator = Command::new("qemu-system-arm").arg("--version").stdout(Stdio::null()).status();
        if emulator.is_err() {
            skipped("there is no qemu-system-arm");
            return false;
        }
        self.can_be_built_for()
    }

    fn cargo(self, verb: &str, binary: &str, features: &str) -> Command {
        let mut cargo = cargo(verb, "release", binary);
        cargo.args(["--features", features, "--target", self.target()]);
        cargo
    }

    /// What a binary prints.
    ///
    /// # Panics
    /// It cannot be built, or it fails.
    #[must_use]
    pub fn run(self, binary: &str) -> String {
        self.run_with(&[], binary)
    }

    /// What a binary prints that takes in these files, each in place of its own (`firmware/boards/mps2/build.rs`, `firmware/build.rs`).
    ///
    /// # Panics
    /// It cannot be built, or it fails.
    #[must_use]
    pub fn run_with(self, taken: &[Taken<'_>], binary: &str) -> String {
        printed(self.cargo("run", binary, "").envs(taken.iter().copied()))
    }

    /// What a program prints that has a lock file of its own, in a folder of `firmware/boards`.
    ///
    /// # Panics
    /// It cannot be built, or it fails.
    #[must_use]
    pub fn run_program(self, folder: &str) -> String {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["run", "--quiet", "--release", "--locked", "--target", self.target(), "--target-dir"]);
        cargo.arg(built_in("boards")).stdin(Stdio::null());
        let boards = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware/boards");
        printed(cargo.current_dir(boards.join(folder)))
    }

    /// The image of a binary that logs by defmt, and the bytes of its log.
    ///
    /// # Panics
    /// It cannot be built, or it fails.
    #[must_use]
    pub fn log(self, binary: &str) -> (Vec<u8>, Vec<u8>) {
        let log = output(&mut self.cargo("run", binary, "defmt"));
        (read(&self.file(binary)), log)
    }

    /// The image of a binary.
    ///
    /// # Panics
    /// It cannot be built.
    #[must_use]
    pub fn image(self, binary: &str) -> Vec<u8> {
        self.image_with(&[], binary)
    }

    /// The image of a binary that takes in these files, each in place of its own.
    ///
    /// # Panics
    /// It cannot be built.
    #[must_use]
    pub fn image_with(self, taken: &[Taken<'_>], binary: &str) -> Vec<u8> {
        read(&self.built_with(taken, binary))
    }

    /// The same with the names of its functions, the inlined ones too, at a level of optimisation of its own crate.
    ///
    /// # Panics
    /// It cannot be built.
    #[must_use]
    pub fn described(self, taken: &[Taken<'_>], binary: &str, level: &str) -> Vec<u8> {
        let mut cargo = self.cargo("build", binary, "");
        cargo.args(["--config", "profile.release.debug=1", "--config", "profile.release.strip=false", "--config"]);
        output(cargo.arg(format!("profile.release.package.mps2.opt-level={level}")).envs(taken.iter().copied()));
        read(&self.file(binary))
    }

    /// Code and constants of a binary, bytes; they include the processor's start-up code, some 200.
    ///
    /// # Panics
    /// It cannot be built.
    #[must_use]
    pub fn flash(self, binary: &str) -> u64 {
        size(&self.image(binary), &[".text", ".rodata"])
    }

    /// RAM that a binary occupies from start to end, bytes.
    ///
    /// # Panics
    /// It cannot be built.
    #[must_use]
    pub fn statics(self, binary: &str) -> u64 {
        size(&self.image(binary), &[".data", ".bss"])
    }

    /// The file of a binary that holds the values of a drive from `host-sim export` instead of its own.
    ///
    /// # Panics
    /// It cannot be built.
    #[must_use]
    pub fn built(self, binary: &str, values: Option<&Path>) -> PathBuf {
        let taken: Vec<Taken<'_>> = values.into_iter().map(|values| ("FIRMWARE_MACHINE", values)).collect();
        self.built_with(&taken, binary)
    }

    /// The file of a binary that takes in these files, each in place of its own.
    ///
    /// # Panics
    /// It cannot be built.
    #[must_use]
    pub fn built_with(self, taken: &[Taken<'_>], binary: &str) -> PathBuf {
        output(self.cargo("build", binary, "").envs(taken.iter().copied()));
        self.file(binary)
    }

    fn file(self, binary: &str) -> PathBuf {
        built_in("on_target").join(self.target()).join("release").join(binary)
    }
}

/// A file that a binary takes in: the variable that names it, and where it is.
pub type Taken<'a> = (&'a str, &'a Path);

/// What a binary of the firmware prints on the host, with these files in place of its own. It is built as tests are: quicker, and its sums are checked.
///
/// # Panics
/// It cannot be built, or it fails.
#[must_use]
pub fn run_on_host(taken: &[Taken<'_>], binary: &str) -> String {
    printed(cargo("run", "dev", binary).envs(taken.iter().copied()))
}

/// Bytes of these sections of an image.
///
/// # Panics
/// It is no ELF file.
#[must_use]
pub fn size(image: &[u8], sections: &[&str]) -> u64 {
    let image = object::File::parse(image).expect("cargo links ELF for this target");
    sections.iter().filter_map(|name| image.section_by_name(name)).map(|section| section.size()).sum()
}

fn cargo(verb: &str, profile: &str, binary: &str) -> Command {
    let mut cargo = Command::new(env!("CARGO"));
    // A folder of its own: the cargo that runs this test locks the usual one.
    cargo
        .args([verb, "--quiet", "--profile", profile, "--locked", "--package", "mps2", "--bin", binary, "--target-dir"])
        .arg(built_in("on_target"))
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
        .stdin(Stdio::null());
    cargo
}

/// Whether Rust can build for a target; if not, prints that a test is skipped.
#[must_use]
pub fn builds_for(target: &str) -> bool {
    let folder = Command::new("rustc").args(["--print", "target-libdir", "--target", target]).output();
    let there = folder.is_ok_and(|folder| PathBuf::from(String::from_utf8_lossy(&folder.stdout).trim()).is_dir());
    if !there {
        skipped(&format!("Rust has no {target}; rustup target add {target}"));
    }
    there
}

/// A folder for what a test builds: beside what cargo has built of the test itself, `target/<profile>/deps/<test>`.
///
/// # Panics
/// The test does not run from a file.
#[must_use]
pub fn built_in(name: &str) -> PathBuf {
    let test = std::env::current_exe().expect("a test runs from a file");
    test.ancestors().nth(3).unwrap_or(&test).join("tmp").join(name)
}

fn output(cargo: &mut Command) -> Vec<u8> {
    let output = cargo.output().expect("cargo runs this test, so it is there");
    let (text, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{cargo:?}: {}\n{text}\n{errors}", output.status);
    output.stdout
}

fn printed(cargo: &mut Command) -> String {
    String::from_utf8_lossy(&output(cargo)).into_owned()
}

fn read(file: &Path) -> Vec<u8> {
    std::fs::read(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}
