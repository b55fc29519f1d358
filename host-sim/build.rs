//! With the feature `studio`: the page that `host-sim studio` writes. It is the file that `HOST_SIM_STUDIO` names, or is built here by the workspace's
//! `studio-page`, in a folder of its own.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    println!("cargo::rerun-if-changed=build.rs");
    if env::var_os("CARGO_FEATURE_STUDIO").is_none() {
        return ExitCode::SUCCESS;
    }
    println!("cargo::rerun-if-env-changed=HOST_SIM_STUDIO");
    match page() {
        Ok(page) => {
            println!("cargo::rustc-env=HOST_SIM_STUDIO_PAGE={}", page.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            println!("cargo::error={}", error.replace('\n', " "));
            ExitCode::FAILURE
        }
    }
}

fn page() -> Result<PathBuf, String> {
    if let Some(given) = env::var_os("HOST_SIM_STUDIO") {
        let page = PathBuf::from(given);
        println!("cargo::rerun-if-changed={}", page.display());
        return page.canonicalize().map_err(|cause| {
            format!("HOST_SIM_STUDIO={}: cannot be read: {cause}; expected a page of the studio", page.display())
        });
    }
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let builder = workspace.join("studio/bundle/Cargo.toml");
    if !builder.exists() {
        return Err("feature studio: the studio's source is not here; expected a checkout of the repository, or HOST_SIM_STUDIO \
                    with the path of a page from a release"
            .to_owned());
    }
    for source in ["studio", "host-sim/crates", "model-core/src", "Cargo.toml", "Cargo.lock", ".cargo/config.toml"] {
        println!("cargo::rerun-if-changed={}", workspace.join(source).display());
    }
    let folder = PathBuf::from(env::var_os("OUT_DIR").ok_or("there is no OUT_DIR; expected cargo to run this")?);
    let (page, target) = (folder.join("studio.html"), folder.join("studio"));
    let cargo = env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(&cargo)
        .args(["run", "--quiet", "--locked", "--manifest-path"])
        .arg(builder)
        .arg("--target-dir")
        .arg(&target)
        .arg("--")
        .args([&page, &target.join("wasm")])
        // Those of this build are for another program.
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .env_remove("RUSTFLAGS")
        .env_remove("RUSTC_WORKSPACE_WRAPPER")
        .env_remove("CARGO_BUILD_TARGET")
        .output()
        .map_err(|cause| format!("{cargo} cannot be started: {cause}; expected cargo"))?;
    if output.status.success() { Ok(page) } else { Err(String::from_utf8_lossy(&output.stderr).into_owned()) }
}
