//! Takes in the drive's values, and links binaries for the emulated boards: the start-up's linker script, with the memory of
//! `memory.x` at the root, and that of the log's texts where there is a log.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// The file with the drive's values, which `host-sim export` wrote.
const MACHINE: &str = "FIRMWARE_MACHINE";

fn main() {
    println!("cargo:rerun-if-env-changed={MACHINE}");
    let machine = env::var_os(MACHINE).map_or_else(|| "machine.rs".into(), PathBuf::from);
    println!("cargo:rerun-if-changed={}", machine.display());
    let taken = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default()).join("machine.rs");
    if let Err(error) = fs::copy(&machine, &taken) {
        println!(
            "cargo:error={}: cannot be taken in: {error}; expected what `host-sim export` writes",
            machine.display()
        );
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    println!("cargo:rerun-if-changed={}", root.join("memory.x").display());
    println!("cargo:rerun-if-changed=build.rs");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        // For this crate's binaries alone: a board that uses the library has a memory of its own.
        println!("cargo:rustc-link-arg-bins=-L{}", root.display());
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
        if env::var_os("CARGO_FEATURE_DEFMT").is_some() {
            println!("cargo:rustc-link-arg-bins=-Tdefmt.x");
        }
    }
}
