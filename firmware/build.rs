//! Takes in the drive's values.

use std::path::PathBuf;
use std::{env, fs};

/// The variable that names the file with the values, and the file without it; its name in the code.
const VARIABLE: &str = "FIRMWARE_MACHINE";
const NAME: &str = "machine.rs";

fn main() {
    let folder = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed={VARIABLE}");
    let file = env::var_os(VARIABLE).map_or_else(|| NAME.into(), PathBuf::from);
    println!("cargo:rerun-if-changed={}", file.display());
    if let Err(error) = fs::copy(&file, folder.join(NAME)) {
        println!(
            "cargo::error={}: cannot be taken in: {error}; expected what `host-sim export` writes",
            file.display()
        );
    }
}
