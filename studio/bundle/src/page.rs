//! The page with everything in it.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;

use crate::BundleError;
use crate::wasm::Module;

const INDEX: &str = include_str!("../../page/index.html");
const STYLE: &str = include_str!("../../page/style.css");
const WORKER: &str = include_str!("../../page/worker.js");
/// One script for the page; each file uses only those above it.
const SCRIPTS: [&str; 9] = [
    include_str!("../../page/dom.js"),
    include_str!("../../page/engine.js"),
    include_str!("../../page/inputs.js"),
    include_str!("../../page/files.js"),
    include_str!("../../page/machine.js"),
    include_str!("../../page/mapping.js"),
    include_str!("../../page/sheet.js"),
    include_str!("../../page/results.js"),
    include_str!("../../page/app.js"),
];

/// The page of a module.
pub(crate) fn assembled(module: &Module) -> Result<String, BundleError> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(&module.wasm)?;
    let wasm = STANDARD.encode(packed.finish()?);
    let worker = format!("{}\n{WORKER}", module.glue);
    let script = SCRIPTS.concat();
    let parts = [
        ("/*style*/", "style.css", STYLE, "</style"),
        ("/*wasm*/", "the WebAssembly", &wasm, "</script"),
        ("/*worker*/", "the worker", &worker, "</script"),
        ("/*script*/", "the scripts", &script, "</script"),
    ];
    let mut page = INDEX.to_owned();
    for (marker, part, text, end) in parts {
        if text.contains(end) {
            return Err(BundleError::EndsElement { part, found: end });
        }
        let found = INDEX.matches(marker).count();
        if found != 1 {
            return Err(BundleError::Place { marker, found });
        }
        page = page.replacen(marker, text, 1);
    }
    Ok(page)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn module(glue: &str) -> Module {
        Module { wasm: b"\0asm".repeat(100), glue: glue.to_owned() }
    }

    #[test]
    fn the_page_holds_its_parts_and_names_no_other_file() {
        let page = assembled(&module("const hostSim = 1;")).unwrap();
        for part in [STYLE, WORKER, SCRIPTS[0], "const hostSim = 1;"] {
            assert!(page.contains(part), "{part}");
        }
        for of_elsewhere in ["src=", "<link", "http://", "https://", "import(", "importScripts"] {
            assert!(!page.contains(of_elsewhere), "{of_elsewhere}");
        }
    }

    #[test]
    fn what_would_end_its_element_is_refused() {
        let refused = assembled(&module("'</script>'")).unwrap_err();
        assert!(matches!(refused, BundleError::EndsElement { part: "the worker", .. }), "{refused}");
    }
}
