//! Takes in the drive's values, and the planned excitation.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// Each file that is taken in: the variable that names it, the file without it, which is also its name in the code, and what writes it.
const TAKEN: [(&str, &str, &str); 2] = [
    ("FIRMWARE_MACHINE", "machine.rs", "`host-sim export`"),
    ("FIRMWARE_PLAN", "plan.rs", "`host-sim plan --firmware`"),
];

fn main() {
    let folder = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    println!("cargo:rerun-if-changed=build.rs");
    for (variable, name, writer) in TAKEN {
        println!("cargo:rerun-if-env-changed={variable}");
        let file = env::var_os(variable).map_or_else(|| name.into(), PathBuf::from);
        println!("cargo:rerun-if-changed={}", file.display());
        take(&file, &folder.join(name), writer);
    }
}

fn take(file: &Path, to: &Path, writer: &str) {
    if let Err(error) = fs::copy(file, to) {
        println!("cargo::error={}: cannot be taken in: {error}; expected what {writer} writes", file.display());
    }
}
