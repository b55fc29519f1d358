//! Builds the studio: the crate `host-sim-studio` as WebAssembly, and with its page, style and scripts one HTML file that needs nothing else.
//!
//! The WebAssembly stands in the page packed (gzip) and as text (Base64); a browser unpacks it by itself. Nothing has to be installed for this but the
//! target `wasm32-unknown-unknown`.
#![forbid(unsafe_code)]
// What it does is told by whoever calls it.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]

mod page;
mod wasm;

use std::io;
use std::path::{Path, PathBuf};

/// The target that browsers run.
pub const TARGET: &str = "wasm32-unknown-unknown";

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum BundleError {
    /// Cargo cannot be started.
    #[error("{program} cannot be started: {cause}; expected cargo, from https://rustup.rs")]
    Cargo {
        /// The program.
        program: String,
        /// What the system says.
        cause: io::Error,
    },
    /// The crate does not compile.
    #[error(
        "the studio was not built for {TARGET}; expected that target: `rustup target add {TARGET}`. Cargo said:\n{said}"
    )]
    NotBuilt {
        /// The end of what cargo said.
        said: String,
    },
    /// What was built does not become a module of JavaScript.
    #[error("{}: {said}; expected the library of wasm-bindgen in the version that the lock file has", wasm.display())]
    NotBound {
        /// The library.
        wasm: PathBuf,
        /// Why.
        said: String,
    },
    /// The system refuses what takes no more than memory and a current folder.
    #[error(transparent)]
    System(#[from] io::Error),
    /// A part of the page that would end the element that it stands in.
    #[error("{part}: it holds `{found}`, which would end its element in the page; expected none")]
    EndsElement {
        /// The part.
        part: &'static str,
        /// What it holds.
        found: &'static str,
    },
    /// The page has no place for a part, or several.
    #[error("index.html: {found} places {marker}; expected one")]
    Place {
        /// Where the part belongs.
        marker: &'static str,
        /// How many there are.
        found: usize,
    },
}

/// The page. Cargo builds the crate in `target`, a folder of its own: the one of a cargo that runs meanwhile would be locked.
///
/// # Errors
/// If the crate cannot be built for browsers.
pub fn html(target: &Path) -> Result<String, BundleError> {
    page::assembled(&wasm::built(target)?)
}
