//! Takes in commands that are to be counted, and links the binaries for the emulated boards: the start-up's linker script, with the memory of
//! `memory.x` at the root, and that of the log's texts where there is a log.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// The variable that names the file with the commands, and the file without it; its name in the code.
const VARIABLE: &str = "FIRMWARE_COMMANDS";
const NAME: &str = "commands.rs";

fn main() {
    let folder = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed={VARIABLE}");
    let file = env::var_os(VARIABLE).map_or_else(|| NAME.into(), PathBuf::from);
    println!("cargo:rerun-if-changed={}", file.display());
    if let Err(error) = fs::copy(&file, folder.join(NAME)) {
        let expected = "a list of names and commands, as in firmware/boards/mps2/commands.rs";
        println!("cargo:error={}: cannot be taken in: {error}; expected {expected}", file.display());
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
