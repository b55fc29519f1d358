//! Says whether the processor is an ARMv8-M, and whether it has a limit of its stack.

use std::env;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-check-cfg=cfg(armv8m, armv8m_main)");
    let target = env::var("TARGET").unwrap_or_default();
    if target.starts_with("thumbv8m") {
        println!("cargo:rustc-cfg=armv8m");
    }
    if target.starts_with("thumbv8m.main") {
        println!("cargo:rustc-cfg=armv8m_main");
    }
}
