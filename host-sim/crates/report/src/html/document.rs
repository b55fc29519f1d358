//! What every page begins and ends with.

use std::fmt::Write;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::about::{About, Used, about};
use super::spoken::spoken;
use super::{chart, style};

const POLICY: &str =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'";

/// How charts are read, on pages where that is the first thing to do.
pub(crate) const READING: &str = "Drag over a chart to zoom; a double click or a double tap shows all again. With the keyboard: + − arrows, 0 for all. A click on a name switches its trace off.";

/// A sentence with what stands in backticks as code.
pub(crate) fn prose(text: &str) -> Markup {
    html! { @for (index, part) in text.split('`').enumerate() { @if index % 2 == 1 { code { (part) } } @else { (part) } } }
}

/// A page with this title: what stands at its top, and the rest, with a list of the rest's headings before it.
#[must_use]
pub fn document(title: &str, (made, recordings): (&About, &Used<'_>), top: &Markup, rest: &Markup) -> String {
    let rest = with_contents(&rest.0);
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                // Whatever a page holds, it must load nothing.
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { (title) }
                style { (PreEscaped(chart::LOOKS)) (PreEscaped(style::STYLE)) }
            }
            body {
                header {
                    p class="over" { (title) }
                    (about(made, recordings))
                    (top)
                }
                (PreEscaped(rest))
                (chart::scripts())
            }
        }
    };
    spoken(&page.0, &recordings.iter().flat_map(|(_, names)| names.iter().copied()).collect::<Vec<_>>())
}

/// What stands before and behind a heading of the first level below the page's own.
const HEADING: (&str, &str) = ("<h2>", "</h2>");

/// A text with a place to go to at each of its headings, and with their list behind what stands before the first section.
fn with_contents(text: &str) -> String {
    let mut parts = text.split(HEADING.0);
    let mut result = parts.next().unwrap_or_default().to_owned();
    let mut headings = Vec::new();
    for (index, part) in parts.enumerate() {
        // A heading is text alone, escaped already.
        headings.push(part.split_once(HEADING.1).map_or(part, |(heading, _)| heading));
        let _ = write!(result, "<h2 id=\"part-{index}\">{part}");
    }
    let contents = html! {
        @if headings.len() > 1 {
            nav class="contents" aria-label="Contents" {
                ul { @for (index, heading) in headings.iter().enumerate() { li { a href=(format!("#part-{index}")) { (PreEscaped(heading)) } } } }
            }
        }
    };
    let first = result.find("<section").unwrap_or(0);
    result.insert_str(first, &contents.0);
    result
}
