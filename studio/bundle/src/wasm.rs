//! The crate as WebAssembly, and the JavaScript that calls it.

use std::path::Path;
use std::process::Command;

use wasm_bindgen_cli_support::Bindgen;

use crate::{BundleError, TARGET};

/// The crate, and what its library is called.
const PACKAGE: &str = "host-sim-studio";
const LIBRARY: &str = "studio.wasm";
/// Fast and in one piece; the workspace's manifest says how.
const PROFILE: &str = "studio";
/// The name under which a worker finds the module.
const GLOBAL: &str = "hostSim";
/// How much of cargo's output an error shows.
const LINES_SHOWN: usize = 30;

/// A module of WebAssembly, and the JavaScript around it.
pub(crate) struct Module {
    pub(crate) wasm: Vec<u8>,
    pub(crate) glue: String,
}

pub(crate) fn built(target: &Path) -> Result<Module, BundleError> {
    let target = std::path::absolute(target)?;
    let program = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(&program)
        .args(["build", "--locked", "--lib", "--package", PACKAGE, "--profile", PROFILE, "--target", TARGET])
        .arg("--target-dir")
        .arg(&target)
        // Where cargo finds the workspace's settings for the target.
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        // Those of an outer cargo are for another processor, as are its wrappers.
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .env_remove("RUSTC_WORKSPACE_WRAPPER")
        .output()
        .map_err(|cause| BundleError::Cargo { program, cause })?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let lines: Vec<&str> = said.lines().collect();
        let said = lines[lines.len().saturating_sub(LINES_SHOWN)..].join("\n");
        return Err(BundleError::NotBuilt { said });
    }
    let wasm = target.join(TARGET).join(PROFILE).join(LIBRARY);
    bound(&wasm).map_err(|said| BundleError::NotBound { wasm, said })
}

fn bound(wasm: &Path) -> Result<Module, String> {
    let mut bindgen = Bindgen::new();
    let told = |error: &dyn std::fmt::Display| format!("{error:#}");
    bindgen.no_modules(true).and_then(|bindgen| bindgen.no_modules_global(GLOBAL)).map_err(|error| told(&error))?;
    bindgen.input_path(wasm).typescript(false).remove_name_section(true).remove_producers_section(true);
    let mut output = bindgen.generate_output().map_err(|error| told(&error))?;
    let glue = output.js().to_owned();
    Ok(Module { wasm: output.wasm_mut().emit_wasm(), glue })
}
