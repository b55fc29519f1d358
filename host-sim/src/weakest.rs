//! Which link misses most, and what would have to be measured to say it where it cannot be said.

use crate::compare::{Comparison, Section};
use crate::machine_file::LoadSource;
use crate::recording::Signal;
use crate::residual::SignalFit;

/// The part of the chain that follows its recordings least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weakest {
    /// The part.
    pub section: Section,
    /// The signal that it misses most.
    pub signal: Signal,
    /// The NRMSE fit of this signal from the part's measured input, %; over several recordings the mean.
    pub nrmse_percent: f64,
    /// Its RMSE over the signal's noise; over several recordings the mean.
    pub over_noise: f64,
    /// The part that misses most after it, and its lowest fit, %; `None` when no other could be judged by itself.
    pub runner_up: Option<(Section, f64)>,
}

/// A part that misses its signal by less than twice the noise follows it: its inputs have noise as well.
const FOLLOWS: f64 = 2.0;
/// And one that fits better than this, %, follows as well as a part alone can be simulated: the load from the pressures leaves
/// inertia out, and rows are joined by straight lines.
const FOLLOWS_PERCENT: f64 = 99.5;

impl Weakest {
    /// Whether even this part follows its recordings within the noise, so that nothing says that physics is missing.
    #[must_use]
    pub fn follows(&self) -> bool {
        self.over_noise < FOLLOWS || self.nrmse_percent > FOLLOWS_PERCENT
    }

    /// Whether another part misses nearly as much (at least four fifths), so that the order of the two means little.
    #[must_use]
    pub fn rival(&self) -> Option<(Section, f64)> {
        self.runner_up.filter(|(_, fit)| 100.0 - fit >= 0.8 * (100.0 - self.nrmse_percent))
    }
}

/// What keeps links from being told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// Command to rod cannot be cut: no slider is recorded.
    NoSlider,
    /// Flow, chambers and mechanics cannot be cut: no pressures are recorded.
    NoPressures,
    /// The pressures are recorded, but no motion that they could be held against.
    NoMotion,
    /// The load is taken from the recorded pressures, so that the mechanics follow them by construction.
    LoadFromPressures,
}

/// The parts that a comparison is cut into: links, and what could not be cut further.
fn parts(comparison: &Comparison) -> impl Iterator<Item = (Section, SignalFit)> + '_ {
    let cut = |wanted: Section| comparison.sections.iter().any(|section| section.section == wanted);
    let below = cut(Section::FlowAndChambers) || cut(Section::Mechanics);
    let alone = !(below || cut(Section::Valve));
    comparison
        .sections
        .iter()
        .filter(move |section| match section.section {
            Section::BelowSlider => !below,
            Section::EndToEnd => alone,
            other => other.is_link(),
        })
        .flat_map(|section| section.fits.iter().map(move |fit| (section.section, *fit)))
}

/// The part with the lowest fit over all the comparisons; where a part is in several, its mean counts.
#[must_use]
pub fn weakest(comparisons: &[Comparison]) -> Option<Weakest> {
    let mut parts_of: Vec<(Section, Vec<SignalFit>)> = Vec::new();
    for (section, fit) in comparisons.iter().flat_map(parts) {
        match parts_of.iter_mut().find(|(known, fits)| *known == section && fits[0].signal == fit.signal) {
            Some((_, fits)) => fits.push(fit),
            None => parts_of.push((section, vec![fit])),
        }
    }
    let mean = |fits: &[SignalFit], of: fn(&SignalFit) -> f64| fits.iter().map(of).sum::<f64>() / fits.len() as f64;
    let mut means: Vec<(Section, Signal, f64, f64)> = parts_of
        .iter()
        .map(|(section, fits)| {
            (*section, fits[0].signal, mean(fits, |fit| fit.nrmse_percent), mean(fits, |fit| fit.over_noise))
        })
        .collect();
    means.sort_by(|a, b| a.2.total_cmp(&b.2));
    let &(section, signal, nrmse_percent, over_noise) = means.first()?;
    let runner_up = means.iter().find(|other| other.0 != section).map(|other| (other.0, other.2));
    Some(Weakest { section, signal, nrmse_percent, over_noise, runner_up })
}

/// What keeps the links of a comparison from being told apart; empty when each stands alone.
#[must_use]
pub fn obstacles(comparison: &Comparison, load: LoadSource) -> Vec<Obstacle> {
    let judged = |wanted: Section| comparison.sections.iter().any(|section| section.section == wanted);
    let first = comparison.sections.first();
    let computes = |signal| first.is_some_and(|section| section.trajectory.signal(signal).is_some());
    let measures =
        |signals: &[Signal]| first.is_some_and(|section| section.fits.iter().any(|fit| signals.contains(&fit.signal)));
    let mut found = Vec::new();
    if computes(Signal::Spool) && !judged(Section::Valve) {
        found.push(Obstacle::NoSlider);
    }
    let pressures = measures(&[Signal::PressureA]) && measures(&[Signal::PressureB]);
    if load == LoadSource::RecordedPressures {
        found.push(Obstacle::LoadFromPressures);
    } else if computes(Signal::PressureA) && !pressures {
        found.push(Obstacle::NoPressures);
    }
    if !measures(&[Signal::Position, Signal::Velocity]) {
        found.push(Obstacle::NoMotion);
    }
    found
}

impl std::fmt::Display for Obstacle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Obstacle::NoSlider => {
                "the valve cannot be told from the links below it: that takes a recorded slider (`spool`)"
            }
            Obstacle::NoPressures => {
                "flow, chambers and mechanics cannot be told apart: that takes both chamber pressures (`pressure_a`, `pressure_b`)"
            }
            Obstacle::NoMotion => "the links below the valve are not judged by their motion: that takes `position` or `velocity`",
            Obstacle::LoadFromPressures => {
                "the mechanics cannot be judged: the load is taken from the recorded pressures, which takes a measured \
                 `load_force` to avoid"
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::SectionFit;
    use crate::simulate::{EntryPoint, Trajectory};

    fn comparison(sections: &[(Section, Signal, f64)]) -> Comparison {
        let fit = |signal, nrmse_percent| SignalFit { nrmse_percent, ..SignalFit::of(signal, &[0.0], &[0.0], &[0.0]) };
        let section = |&(section, signal, percent): &(Section, Signal, f64)| SectionFit {
            section,
            entry: EntryPoint::Command,
            fits: vec![fit(signal, percent)],
            trajectory: Trajectory { series: vec![(Signal::Spool, Vec::new()), (Signal::PressureA, Vec::new())] },
        };
        Comparison { recording: "r".into(), sections: sections.iter().map(section).collect() }
    }

    #[test]
    fn end_to_end_is_no_culprit_while_there_are_links() {
        let one = comparison(&[
            (Section::EndToEnd, Signal::Position, 10.0),
            (Section::Valve, Signal::Spool, 99.0),
            (Section::BelowSlider, Signal::Position, 50.0),
            (Section::FlowAndChambers, Signal::Position, 95.0),
            (Section::Mechanics, Signal::Position, 90.0),
        ]);
        let found = weakest(std::slice::from_ref(&one)).unwrap();
        assert_eq!((found.section, found.signal), (Section::Mechanics, Signal::Position));
        assert_eq!((found.runner_up, found.rival()), (Some((Section::FlowAndChambers, 95.0)), None));
        assert_eq!(obstacles(&one, LoadSource::Constant), [Obstacle::NoPressures]);
    }

    #[test]
    fn means_over_recordings_count() {
        let recording = |valve, mechanics| {
            comparison(&[(Section::Valve, Signal::Spool, valve), (Section::Mechanics, Signal::Position, mechanics)])
        };
        let found = weakest(&[recording(80.0, 90.0), recording(99.0, 80.0)]).unwrap();
        assert_eq!(found.section, Section::Mechanics);
        assert!((found.nrmse_percent - 85.0).abs() < 1e-12);
    }

    #[test]
    fn without_a_cut_the_whole_is_named_and_what_is_missing() {
        let whole = comparison(&[(Section::EndToEnd, Signal::Position, 80.0)]);
        assert_eq!(weakest(std::slice::from_ref(&whole)).unwrap().section, Section::EndToEnd);
        assert_eq!(obstacles(&whole, LoadSource::Constant), [Obstacle::NoSlider, Obstacle::NoPressures]);
        assert_eq!(weakest(&[]), None);
    }
}
