//! What a page was made of, when and by which command.

use maud::{Markup, html};

/// What only who runs the tool knows of a page. What is not known is left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct About {
    /// Date and time: `2026-05-06 07:08 +02:00`.
    pub written: Option<String>,
    /// The command, as it was typed.
    pub command: Option<String>,
    /// The machine files, as they were named.
    pub machine_files: Vec<String>,
}

/// Recordings by what they were used for.
pub type Used<'a> = [(&'static str, Vec<&'a str>)];

/// As many recordings are named; of more only how many.
const NAMED: usize = 12;

pub(crate) fn about(about: &About, recordings: &Used<'_>) -> Markup {
    let version = env!("CARGO_PKG_VERSION");
    let counted = recordings.iter().map(|(_, names)| names.len()).sum::<usize>();
    html! {
        details class="about" {
            summary { @if let Some(written) = &about.written { (written) " · " } "host-sim " (version) @if counted > 0 { " · " (counted) " recording" @if counted != 1 { "s" } } }
            dl {
                @if let Some(command) = &about.command { dt { "Command" } dd { code { (command) } } }
                @if !about.machine_files.is_empty() { dt { "Machine file" } dd { (about.machine_files.join(", ")) } }
                @for (used, names) in recordings.iter().filter(|(_, names)| !names.is_empty()) {
                    dt { (used) } dd { @if names.len() > NAMED { (names.len()) " recordings" } @else { (names.join(", ")) } }
                }
            }
        }
    }
}
