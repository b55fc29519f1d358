//! The format that a file name's ending stands for, and standard output in place of a file.

use std::path::Path;

use super::error::CliError;

/// What is written into a file, and the endings of names for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kind {
    what: &'static str,
    endings: &'static [&'static str],
}

/// Signals over time, in any format that is written.
pub(crate) const RECORDING: Kind = Kind { what: "signals", endings: &["csv", "txt", "mat", "parquet"] };
/// Signals over time as text.
pub(crate) const TEXT: Kind = Kind { what: "CSV", endings: &["csv", "txt"] };
/// A drawing.
pub(crate) const DRAWING: Kind = Kind { what: "an SVG drawing", endings: &["svg"] };
/// A page for people.
pub(crate) const PAGE: Kind = Kind { what: "an HTML page", endings: &["html", "htm"] };
/// A document for programs; in place of a file it may go to standard output, in place of the command's text.
pub(crate) const DOCUMENT: Kind = Kind { what: "JSON", endings: &["json"] };
/// A machine file.
pub(crate) const MACHINE: Kind = Kind { what: "a machine file", endings: &["toml"] };
/// Source that the firmware takes in.
pub(crate) const SOURCE: Kind = Kind { what: "Rust source", endings: &["rs"] };

/// What is checked elsewhere.
pub(crate) const ANY: Kind = Kind { what: "any format", endings: &[] };

/// Endings of formats that are never written, or by another command.
const OTHERS: [&str; 17] = [
    "gz", "xlsx", "xls", "ods", "mf4", "pdf", "png", "jpg", "jpeg", "doc", "docx", "fmu", "h", "zip", "xml", "yaml",
    "yml",
];

/// Whether the path means standard output.
pub(crate) fn is_standard_output(path: &Path) -> bool {
    path == Path::new("-")
}

/// Checks that a name's ending does not stand for another format. A name without ending is accepted, and so is one whose ending is not a
/// format here, and the name of a pipe: other programs may choose their temporary names.
pub(crate) fn check_ending(option: &'static str, path: &Path, kind: Kind) -> Result<(), CliError> {
    if is_standard_output(path) {
        return if kind == DOCUMENT { Ok(()) } else { Err(CliError::Dash { option }) };
    }
    let is_stream = path.metadata().is_ok_and(|file| !file.is_file() && !file.is_dir());
    let written = [RECORDING, DRAWING, PAGE, DOCUMENT, MACHINE, SOURCE];
    let formats =
        written.iter().flat_map(|kind| kind.endings).chain(&OTHERS).filter(|known| !kind.endings.contains(known));
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    match formats.into_iter().find(|known| known.eq_ignore_ascii_case(ending)) {
        Some(_) if !is_stream => {
            let known: Vec<String> = kind.endings.iter().map(|ending| format!(".{ending}")).collect();
            Err(CliError::Ending { option, path: path.to_owned(), what: kind.what, known: known.join(", ") })
        }
        _ => Ok(()),
    }
}
