//! A drawing with the numbers behind it: the drawing remains on paper and where no script runs.

use maud::{Markup, PreEscaped, html};
use serde_json::Value;

use diagnosis::{Diagnosis, Shown};
use recording::Signal;

use super::budget::Budget;
use super::data;
use super::overlay::{named, panels};
use crate::plot::{Cells, Figure, Panel, Rows, cells, rows, scatter, svg};

/// The page's chart library, and its licence, which must be kept with it.
const LIBRARY: &str = include_str!("assets/uplot/uPlot.iife.min.js");
const LICENCE: &str = include_str!("assets/uplot/LICENSE");
/// The page's own scripts as one: what they name is theirs alone.
const SCRIPT: &str = concat!(
    "(function () {\n\"use strict\";\n\n",
    include_str!("assets/charts/numbers.js"),
    include_str!("assets/charts/looks.js"),
    include_str!("assets/charts/zoom.js"),
    include_str!("assets/charts/over_time.js"),
    include_str!("assets/charts/over_state.js"),
    include_str!("assets/charts/rows.js"),
    include_str!("assets/charts/map.js"),
    include_str!("assets/charts/page.js"),
    "})();\n",
);
pub(crate) const LOOKS: &str = include_str!("assets/uplot/uPlot.min.css");

/// The scripts at the end of the page.
pub(crate) fn scripts() -> Markup {
    html! {
        script { (PreEscaped(format!("/*\nuPlot\n\n{LICENCE}\n*/\n{LIBRARY}"))) }
        script { (PreEscaped(SCRIPT)) }
    }
}

/// A chart that is as wide as it is readable.
pub(crate) fn chart(figure: &Figure) -> Markup {
    with_data("chart", &scatter(figure), &data::figure(figure))
}

/// One row for each recording.
pub(crate) fn in_rows(figure: &Rows) -> Markup {
    with_data("overlay", &rows(figure), &data::rows(figure))
}

/// Cells over two states.
pub(crate) fn on_map(figure: &Cells) -> Markup {
    with_data("chart", &cells(figure), &data::cells(figure))
}

/// Some signals of a recording over time.
pub(crate) fn over_time(diagnosis: &Diagnosis, shown: &Shown, signals: &[Signal], budget: Budget) -> Markup {
    under_its_name(shown, &panels(diagnosis, shown, signals, budget.points), budget)
}

/// Panels of a recording, under its name and what it was used for.
pub(crate) fn under_its_name(shown: &Shown, panels: &[Panel], budget: Budget) -> Markup {
    let (title, subtitle) = named(shown);
    html! {
        p class="recording" { strong { (title) } " · " (subtitle) }
        (in_panels(panels, budget.rows))
    }
}

/// Panels over one time axis, each with at most this number of rows for the script.
pub(crate) fn in_panels(panels: &[Panel], rows: usize) -> Markup {
    with_data("overlay", &svg("", "", panels), &data::time(panels, rows))
}

fn with_data(class: &str, drawing: &str, numbers: &Value) -> Markup {
    html! {
        figure class={ (class) " data" } {
            (PreEscaped(drawing))
            script type="application/json" { (PreEscaped(data::for_page(numbers))) }
        }
    }
}
