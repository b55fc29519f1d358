//! Recorded against simulated, as SVG.
//!
//! A figure is a column of [`Panel`]s over one time axis. Each panel has its traces and, where it is given residuals, a smaller
//! chart of them below. The result is text that depends on its input only: not on a clock or on fonts of the machine.
//!
//! ```
//! use report::plot::{Panel, Style, Trace, svg};
//!
//! let time_s = vec![0.0, 0.1, 0.2];
//! let panel = Panel::new("Position", "mm", time_s)
//!     .trace(Trace::new("recorded", vec![0.0, 1.0, 2.0], Style::Recorded))
//!     .trace(Trace::new("simulated", vec![0.0, 0.9, 2.1], Style::Simulated))
//!     .residuals()
//!     .shade(0.05, 0.1);
//! assert!(svg("Train 1", "press-63-40", &[panel]).starts_with("<svg"));
//! ```

mod axis;
pub(crate) mod bars;
mod canvas;
pub(crate) mod cells;
pub(crate) mod curve;
mod grid;
mod multiple;
mod recorded;
pub(crate) mod rows;
pub(crate) mod scatter;
mod thin;

pub use bars::{Bar, BarGroup, bars};
pub use canvas::svg;
pub use cells::{Cells, cells};
pub use curve::{Mark, Series, curve};
pub use grid::{Cell, Grid, grid};
pub use multiple::{Amount, Multiple, Piece, multiple};
pub use recorded::{panels, panels_of};
pub(crate) use recorded::{title, within_title};
pub use rows::{Row, Rows, rows};
pub use scatter::{Figure, Layer, Marks, RangeBin, scatter};
pub(crate) use thin::kept_rows;

/// What a trace shows, which determines how it is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Style {
    /// What drives the model: thin, grey-brown.
    Input,
    /// A channel by itself, with nothing beside it: thin, blue.
    Channel,
    /// A measurement: broad and light, so that what lies on it stays visible.
    Recorded,
    /// A simulation: thin, blue.
    Simulated,
    /// A simulation before something was changed: thin, orange.
    Before,
    /// A simulation after something was changed: thin, blue.
    After,
    /// One of several simulations, counted from 0: thin, a colour of its own.
    Model(u8),
}

impl Style {
    /// Whether it is a simulation, which has a residual.
    pub(crate) const fn is_simulation(self) -> bool {
        matches!(self, Style::Simulated | Style::Before | Style::After | Style::Model(_))
    }
}

/// One line of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Its name in the legend.
    pub label: String,
    /// One value for each time of the panel, in the panel's unit. A value that is not finite is left out.
    pub values: Vec<f64>,
    /// What it shows, which determines how it is drawn.
    pub style: Style,
}

impl Trace {
    /// A line of a chart.
    #[must_use]
    pub fn new(label: &str, values: Vec<f64>, style: Style) -> Self {
        Self { label: label.to_owned(), values, style }
    }
}

/// One signal: a chart of its traces and, where there are residuals, one of these below.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// What is shown: `Position`.
    pub title: String,
    /// The unit of all values, as people read it: `mm`.
    pub unit: String,
    /// A remark after the title: `NRMSE fit 98.71 %`.
    pub note: String,
    /// The times of all traces, s, rising.
    pub time_s: Vec<f64>,
    /// The lines, drawn in this order.
    pub traces: Vec<Trace>,
    /// Recorded minus simulated, one line for each simulation; without any, there is no lower chart.
    pub residuals: Vec<Trace>,
    /// Stretches of time that are shaded, (from, to) in s.
    pub intervals: Vec<(f64, f64)>,
    /// Most points of a trace; 2000 if not given.
    pub points: Option<usize>,
}

impl Panel {
    /// A panel without traces.
    #[must_use]
    pub fn new(title: &str, unit: &str, time_s: Vec<f64>) -> Self {
        Self { title: title.to_owned(), unit: unit.to_owned(), time_s, ..Self::default() }
    }

    /// The panel with one more trace.
    #[must_use]
    pub fn trace(mut self, trace: Trace) -> Self {
        self.traces.push(trace);
        self
    }

    /// The panel with a remark after its title.
    #[must_use]
    pub fn note(mut self, note: &str) -> Self {
        note.clone_into(&mut self.note);
        self
    }

    /// The panel with a stretch of time shaded, s.
    #[must_use]
    pub fn shade(mut self, from_s: f64, to_s: f64) -> Self {
        self.intervals.push((from_s, to_s));
        self
    }

    /// The panel with the residuals of its simulations: the recorded trace minus each of them.
    #[must_use]
    pub fn residuals(mut self) -> Self {
        let recorded = self.traces.iter().find(|trace| trace.style == Style::Recorded);
        self.residuals = recorded.map_or_else(Vec::new, |recorded| {
            let simulations = |trace: &&Trace| trace.style.is_simulation();
            let minus = |trace: &Trace| -> Vec<f64> {
                recorded.values.iter().zip(&trace.values).map(|(measured, model)| measured - model).collect()
            };
            self.traces
                .iter()
                .filter(simulations)
                .map(|trace| Trace::new(&trace.label, minus(trace), trace.style))
                .collect()
        });
        self
    }
}
