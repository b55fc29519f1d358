//! The effect's own picture: what the recordings show of it, and over that what the models before and after show.
//!
//! One measurement, three drives: the recorded drive, the model before and the model after are each treated as a drive on the bench,
//! and the same balance over short windows is drawn for all three. So the curve of the model after is the law that was
//! fitted, measured in the same way as the data. What cannot be measured with the recorded channels is drawn for the models only, beside the
//! motion that the model before lacks.

mod families;
mod view;

use families::{Family, PRESSURES, lacking_motion, of};
use view::{Law, Moment, is_entered_at_force, moments};

use diagnosis::Diagnosis;
use diagnosis::catalogue::Hypothesis;
use model_core::machine::{Fallback, Machine, MachineError};
use recording::{Recording, Signal};
use simulation::signal::noise::quantile;

use crate::plot::{Figure, Layer, Marks, RangeBin, Style};

/// A picture of one effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The effect.
    pub effect: &'static str,
    /// How to read it.
    pub caption: String,
    /// What is drawn.
    pub figure: Figure,
}

/// The pictures of every effect accepted. `recordings` are all that the diagnosis shows, in its order.
pub(super) fn pictures(diagnosis: &Diagnosis, recordings: &[&Recording]) -> Result<Vec<Picture>, MachineError> {
    let mut found = Vec::new();
    for finding in &diagnosis.findings {
        found.extend(pictures_of(finding.effect, diagnosis, recordings)?);
    }
    Ok(found)
}

/// The pictures of one effect, whether accepted or not.
pub(super) fn pictures_of(
    effect: &'static Hypothesis,
    diagnosis: &Diagnosis,
    recordings: &[&Recording],
) -> Result<Vec<Picture>, MachineError> {
    let law = Law::of(&without(&diagnosis.machine_after, effect), &diagnosis.machine_after);
    let has = |signal| {
        diagnosis.shown.iter().all(|shown| shown.prepared.channels.iter().any(|channel| channel.signal == signal))
    };
    let family = of(effect, &diagnosis.machine_after);
    // A force that drives the model, and where the rod goes, tell the balance of forces without pressures.
    let knows_force = has(Signal::Position) && diagnosis.shown.iter().all(is_entered_at_force);
    let measured = family.needs.iter().all(|signal| has(*signal) || (knows_force && PRESSURES.contains(signal)));
    let drives = moments(&law, diagnosis, recordings)?;
    let mut pictures = vec![picture(effect, &family, &law, &drives, measured)];
    if !measured {
        pictures.push(picture(effect, &lacking_motion(effect), &law, &drives, true));
    }
    pictures.retain(|picture| !picture.figure.layers.is_empty());
    Ok(pictures)
}

/// The machine with every parameter of an effect at its default.
fn without(machine: &Machine<f64>, effect: &Hypothesis) -> Machine<f64> {
    let mut machine = *machine;
    for parameter in effect.parameters() {
        if let Fallback::Value(value) = parameter.description().default {
            machine.set(parameter, value);
        }
    }
    machine
}

/// Moments of the recorded drive, and of the models before and after.
struct Drives {
    recorded: Vec<Moment>,
    before: Vec<Moment>,
    after: Vec<Moment>,
}

fn picture(effect: &'static Hypothesis, family: &Family, law: &Law, drives: &Drives, measured: bool) -> Picture {
    let points = |moments: &[Moment]| -> Vec<(f64, f64, i8)> {
        let points = moments.iter().filter_map(|moment| (family.point)(law, moment));
        points.filter(|(x, y, _)| x.is_finite() && y.is_finite()).collect()
    };
    let model = |name: &str, style, moments: &[Moment]| -> Vec<Layer> {
        let branches = branches(&points(moments)).into_iter().enumerate();
        let label = |index| if index == 0 { name.to_owned() } else { String::new() };
        branches.map(|(index, (_, branch))| Layer { label: label(index), style, marks: curve(branch) }).collect()
    };
    let mut layers = model("model before", Style::Before, &drives.before);
    if measured {
        let recorded = points(&drives.recorded);
        let dots = thinned(recorded.iter().map(|(x, y, _)| (*x, *y)).collect());
        layers.push(Layer { label: "recorded".to_owned(), style: Style::Recorded, marks: Marks::Dots(within(dots)) });
        for (_, branch) in branches(&recorded) {
            layers.push(Layer { label: String::new(), style: Style::Recorded, marks: Marks::Bins(binned(branch)) });
        }
    }
    layers.extend(model("model after", Style::After, &drives.after));
    layers.retain(|layer| match &layer.marks {
        Marks::Dots(points) | Marks::Line(points) => !points.is_empty(),
        Marks::Bins(bins) => !bins.is_empty(),
    });
    let unmeasured =
        if measured { "" } else { " The recordings lack a channel that it takes: the models alone are drawn." };
    let axis = |(title, unit): (&str, &str)| if unit == "1" { title.to_owned() } else { format!("{title} [{unit}]") };
    let figure = Figure { title: family.title.to_owned(), x: axis(family.x), y: axis(family.y), layers, band: None };
    Picture { effect: effect.name, caption: format!("{}{unmeasured}", family.caption), figure }
}

/// A curve whose scatter exceeds this share of its range is not drawn as a curve.
const SCATTERED: f64 = 0.1;
/// Most points of a model that are drawn where they make no curve.
const MOST_OF_MODEL: usize = 400;

/// A line through the medians; where the points of the model make no curve, the points themselves.
fn curve(points: Vec<(f64, f64)>) -> Marks {
    let bins = binned(points.clone());
    let mut spread: Vec<f64> = bins.iter().map(|bin| bin.quartiles[2] - bin.quartiles[0]).collect();
    spread.sort_by(f64::total_cmp);
    let values = || within(points.clone()).into_iter().map(|point| point.1);
    let range = values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min);
    match spread.get(spread.len() / 2) {
        Some(typical) if *typical > SCATTERED * range && *typical > 0.0 => {
            let step = points.len().div_ceil(MOST_OF_MODEL).max(1);
            Marks::Dots(within(points.into_iter().step_by(step).collect()))
        }
        _ => Marks::Line(bins.iter().map(|bin| (bin.x, bin.quartiles[1])).collect()),
    }
}

/// Points of each branch that has any.
fn branches(points: &[(f64, f64, i8)]) -> Vec<(i8, Vec<(f64, f64)>)> {
    let of = |wanted: i8| points.iter().filter(|point| point.2 == wanted).map(|point| (point.0, point.1)).collect();
    [-1, 0, 1]
        .into_iter()
        .map(|branch| (branch, of(branch)))
        .filter(|(_, points): &(i8, Vec<_>)| !points.is_empty())
        .collect()
}

/// Most single points in a picture.
const MOST_DOTS: usize = 1500;

fn thinned(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let step = points.len().div_ceil(MOST_DOTS).max(1);
    points.into_iter().step_by(step).collect()
}

/// Without the few points that lie far from the others in y: they would flatten the picture.
fn within(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let at = |share: f64| quantile(points.iter().map(|point| point.1).collect(), share);
    let (Some(low), Some(high)) = (at(0.02), at(0.98)) else { return points };
    let air = 0.5 * (high - low);
    points.into_iter().filter(|point| point.1 >= low - air && point.1 <= high + air).collect()
}

/// Bins of a curve, each with the same number of points.
const BINS: usize = 40;
/// Least number of points in a bin.
const LEAST_IN_BIN: usize = 5;
/// Bins closer than this share of the whole range are merged.
const CLOSEST: f64 = 0.012;

/// Medians and quartiles over equally filled ranges of x.
fn binned(mut points: Vec<(f64, f64)>) -> Vec<RangeBin> {
    if points.len() < 2 * LEAST_IN_BIN {
        return Vec::new();
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let range = points[points.len() - 1].0 - points[0].0;
    let size = points.len().div_ceil(BINS).max(LEAST_IN_BIN);
    let mut bins = Vec::new();
    let mut from = 0;
    while from < points.len() {
        let mut to = (from + size).min(points.len());
        while to < points.len() && points[to].0 - points[from].0 <= CLOSEST * range {
            to += 1;
        }
        if points.len() - to < LEAST_IN_BIN {
            to = points.len();
        }
        let mut values: Vec<f64> = points[from..to].iter().map(|point| point.1).collect();
        values.sort_by(f64::total_cmp);
        let rank = |quarter: usize| values[quarter * (values.len() - 1) / 4];
        bins.push(RangeBin { x: points[usize::midpoint(from, to - 1)].0, quartiles: [rank(1), rank(2), rank(3)] });
        from = to;
    }
    bins
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_follow_a_law_through_noise_and_outliers() {
        let points: Vec<(f64, f64)> = (0..2000)
            .map(|k| {
                let x = f64::from(k % 400) * 0.01 - 2.0;
                let off = if k % 37 == 0 { 50.0 } else { 0.1 * f64::from(k % 7 - 3) };
                (x, 3.0 * x.signum() + off)
            })
            .collect();
        let bins = binned(points);
        assert!(bins.len() > 20 && bins.len() <= BINS + 1, "{}", bins.len());
        for bin in bins.iter().filter(|bin| bin.x.abs() > 0.2) {
            assert!((bin.quartiles[1] - 3.0 * bin.x.signum()).abs() < 0.2, "{bin:?}");
            assert!(bin.quartiles[0] <= bin.quartiles[1] && bin.quartiles[1] <= bin.quartiles[2]);
        }
        assert!(binned(vec![(0.0, 1.0); 3]).is_empty());
        assert_eq!(binned(vec![(0.0, 1.0); 300]).len(), 1, "one place, one bin");
    }
}
