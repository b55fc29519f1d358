//! Takes in the drive: what `host-sim export --bake --out drive.rs` wrote, named by the variable `DRIVE`; without it, the firmware's own.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    println!("cargo:rerun-if-env-changed=DRIVE");
    println!("cargo:rerun-if-changed=build.rs");
    let named = env::var_os("DRIVE").map(PathBuf::from);
    if named.is_none() {
        println!("cargo::warning=DRIVE names no drive: this is the library of firmware/baked.rs");
    }
    let file = named.unwrap_or_else(|| "../firmware/baked.rs".into());
    println!("cargo:rerun-if-changed={}", file.display());
    let folder = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    if let Err(error) = fs::copy(&file, folder.join("drive.rs")) {
        let expected = "what `host-sim export --bake` writes; DRIVE is a path from the root of the file system";
        println!("cargo::error={}: cannot be taken in: {error}; expected {expected}", file.display());
    }
}
