//! Takes in baked drives and commands that are to be counted, and links the binaries for the emulated boards: the start-up's linker script, with the memory of
//! `memory.x` at the root, and that of the log's texts where there is a log.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// A file that is compiled in: the variable that names it, where it is if that is not set (its name is also that in the code), what it should be.
type Taken = (&'static str, &'static str, &'static str);

const TAKEN: [Taken; 3] = [
    ("FIRMWARE_BAKED", "../../baked.rs", "what `host-sim export --bake` writes"),
    ("FIRMWARE_BAKED_TRIALS", "baked_trials.rs", "a list of baked drives, as in firmware/boards/mps2/baked_trials.rs"),
    ("FIRMWARE_COMMANDS", "commands.rs", "a list of names and commands, as in firmware/boards/mps2/commands.rs"),
];

fn main() {
    let folder = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    println!("cargo:rerun-if-changed=build.rs");
    for (variable, name, expected) in TAKEN {
        println!("cargo:rerun-if-env-changed={variable}");
        let file = env::var_os(variable).map_or_else(|| name.into(), PathBuf::from);
        println!("cargo:rerun-if-changed={}", file.display());
        if let Err(error) = fs::copy(&file, folder.join(Path::new(name).file_name().unwrap_or_default())) {
            println!("cargo::error={}: cannot be taken in: {error}; expected {expected}", file.display());
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    println!("cargo:rerun-if-changed={}", root.join("memory.x").display());
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        println!("cargo:rustc-link-arg-bins=-L{}", root.display());
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
        if env::var_os("CARGO_FEATURE_DEFMT").is_some() {
            println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
        }
    }
}
