//! The program on an emulated processor that it was not built for.
#![cfg(all(target_os = "linux", target_arch = "x86_64", target_feature = "avx2"))]

use std::process::Command;

use super::{at_hand, text};

/// Exit status and standard error of the program, asked for its version.
fn on(processor: &str) -> std::io::Result<(Option<i32>, String)> {
    let program = env!("CARGO_BIN_EXE_host-sim");
    let output = Command::new("qemu-x86_64").args(["-cpu", processor, program, "--version"]).output()?;
    Ok((output.status.code(), text(&output.stderr)))
}

#[test]
fn without_avx2_it_says_what_it_was_built_for_and_how_to_build_it_for_any() {
    let Ok((status, said)) = on("max") else {
        at_hand::skipped("there is no qemu-x86_64; Debian: apt-get install qemu-user");
        return;
    };
    assert_eq!(status, Some(0), "{said}");
    let (status, said) = on("Nehalem").unwrap();
    assert_eq!(status, Some(2), "{said}");
    assert!(
        said.starts_with("error: the processor has no AVX2") && said.contains("RUSTFLAGS=-Ctarget-cpu=x86-64"),
        "{said}"
    );
}
