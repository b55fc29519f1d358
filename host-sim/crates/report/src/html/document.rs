//! What every page begins and ends with.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{chart, style};

const POLICY: &str =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'";

/// How charts are read, on pages where that is the first thing to do.
pub(crate) const READING: &str = "Drag over a chart to zoom; a double click or a double tap shows all again. With the keyboard: + − arrows, 0 for all. A click on a name switches its trace off.";

/// A sentence with what stands in backticks as code.
pub(crate) fn prose(text: &str) -> Markup {
    html! { @for (index, part) in text.split('`').enumerate() { @if index % 2 == 1 { code { (part) } } @else { (part) } } }
}

/// A page with this title: what stands at its top, and the rest.
pub(crate) fn document(title: &str, top: &Markup, rest: &Markup) -> String {
    html! {
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
                    (top)
                }
                (rest)
                (chart::scripts())
            }
        }
    }
    .into_string()
}
