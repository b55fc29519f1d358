//! Where: the link, the signal, the stretches of time, the states of the drive.

use maud::{Markup, html};

use diagnosis::localisation::error_shape::Shape;
use diagnosis::{Diagnosis, Shown};
use recording::display_unit::{significant, state_unit};

use super::budget::Budget;
use super::chart::{chart, in_rows, on_map, over_time};
use crate::evidence::Exhibits;
use crate::plot::{Figure, Layer, Marks, Style};
use crate::terminal::{SUSPECTED, when};
use crate::wording;

pub(crate) fn located(diagnosis: &Diagnosis, exhibits: &Exhibits, budget: Budget) -> Markup {
    let Some(location) = &diagnosis.located else { return html! {} };
    html! {
        section {
            h2 { "Where" }
            div class="fact" {
                p { "In the " strong { (location.subsystem) } " link, seen most in " strong { (location.signal.name()) } ": " (wording::region(location.region)) "." }
                @if let Some(effect) = diagnosis.suspected { p { "Suspected: " strong { (effect.name) } ", " (SUSPECTED) "." } }
                p { "When: " (when(location)) "." }
                p { "How it looks: " (wording::error_shape(&location.shape)) "." }
                @for habit in &location.spool { p { (wording::spool_habit(habit)) "." } }
            }
            @if let Some(timeline) = &exhibits.timeline {
                h3 { "When" }
                (in_rows(timeline))
                p class="soft" { "Training recordings, one row each. Shaded: the located intervals." }
            }
            @if !exhibits.maps.is_empty() {
                h3 { "Operating regions" }
                div class="pair" { @for map in &exhibits.maps { (on_map(map)) } }
                p class="soft" { "Mean size over all training recordings, in standard deviations of the noise. Blank: not visited." }
            }
            @if let Some(figure) = of_shape(&location.shape) { (chart(&figure)) }
            @if !diagnosis.findings.is_empty() || matches!(location.shape, Shape::Once { .. }) {
                @if let Some(shown) = where_it_is(diagnosis) {
                    h3 { "The recording that shows it most" }
                    (over_time(diagnosis, shown, &[location.signal], budget))
                    p class="soft" { "Shaded: where the error before is made." }
                }
            }
            details {
                summary { "The intervals, and every signal" }
                table {
                    tr { th { "recording" } th { "from, s" } th { "to, s" } th { "of the error, %" } }
                    @for interval in &location.intervals {
                        tr { td { (interval.recording) } td { (significant(interval.from_s, 4)) } td { (significant(interval.to_s, 4)) }
                            td { (significant(100.0 * interval.share, 2)) } }
                    }
                }
                table {
                    tr { th { "signal" } th { "error before, in standard deviations of its noise" } }
                    @for miss in &location.misses { tr { td { (miss.signal.name()) } td { (significant(miss.over_noise, 3)) } } }
                }
            }
        }
    }
}

/// The recording that holds the interval with most of the error.
pub(crate) fn where_it_is(diagnosis: &Diagnosis) -> Option<&Shown> {
    let named = &diagnosis.located.as_ref()?.intervals.first()?.recording;
    diagnosis.shown.iter().find(|shown| shown.prepared.name == *named && !shown.held_out)
}

/// The error over the state that it depends on.
fn of_shape(shape: &Shape) -> Option<Figure> {
    let Shape::Over { state, unit, bins, .. } = shape else { return None };
    let (unit, scale) = state_unit(unit);
    let steps = bins.iter().flat_map(|bin| [(scale * bin.from, bin.mean), (scale * bin.to, bin.mean)]).collect();
    Some(Figure {
        title: format!("What the model before misses, over the {state}"),
        x: format!("{state} [{unit}]"),
        y: "mean error [standard deviations of the noise]".to_owned(),
        layers: vec![Layer { label: "before".to_owned(), style: Style::Before, marks: Marks::Line(steps) }],
        band: Some(1.0),
    })
}
