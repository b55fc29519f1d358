//! Gives the linker the names of the interrupts and the memory of the boards.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    let folder = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    println!("cargo:rerun-if-changed=build.rs");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for file in [root.join("device.x"), root.join("../../../memory.x")] {
        println!("cargo:rerun-if-changed={}", file.display());
        if let Err(error) = fs::copy(&file, folder.join(file.file_name().unwrap_or_default())) {
            println!("cargo::error={}: {error}; expected a linker script", file.display());
        }
    }
    println!("cargo:rustc-link-search={}", folder.display());
}
