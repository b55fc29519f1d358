//! Which link has the largest misfit, and which signals would have to be measured to identify it where it cannot be identified.

use machine_file::LoadSource;
use recording::Signal;
use simulation::figures_of_merit::SignalFit;

use super::{Comparison, Section, SectionFit};

/// The part of the model that follows its recordings least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weakest {
    /// The part.
    pub section: Section,
    /// The signal with the largest misfit.
    pub signal: Signal,
    /// The NRMSE fit of this signal from the part's measured input, %; over several recordings the mean.
    pub nrmse_percent: f64,
    /// Its RMSE over its noise, which is that of the signal and the input noise from the part's measured input; over several
    /// recordings the mean.
    pub over_noise: f64,
    /// The part with the next largest misfit, its lowest fit, %, and whether it follows; `None` when no other could be judged by itself.
    pub runner_up: Option<RunnerUp>,
}

/// The part with the largest misfit after the weakest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunnerUp {
    /// The part.
    pub section: Section,
    /// Its lowest fit, %.
    pub nrmse_percent: f64,
    /// Whether it follows its recordings within the noise.
    pub follows: bool,
}

/// A part whose error is less than twice its noise follows the signal. Noise that a position integrates makes a random
/// walk: its RMS is more than twice the usual in one case of fifty.
const FOLLOWS: f64 = 2.0;
/// A part whose fit is better than this, %, also follows, because a part alone cannot be simulated better: the load from
/// the pressures leaves inertia out, and rows are joined by straight lines.
const FOLLOWS_PERCENT: f64 = 99.5;

impl Weakest {
    /// Whether even this part follows its recordings within the noise, so that nothing indicates missing physics.
    #[must_use]
    pub fn follows(&self) -> bool {
        follows(self.nrmse_percent, self.over_noise)
    }

    /// Another part whose misfit is nearly as large (at least four fifths) and above the noise: the order of the two then means little.
    #[must_use]
    pub fn rival(&self) -> Option<(Section, f64)> {
        let near = |other: &RunnerUp| 100.0 - other.nrmse_percent >= 0.8 * (100.0 - self.nrmse_percent);
        self.runner_up.filter(|other| !other.follows && near(other)).map(|other| (other.section, other.nrmse_percent))
    }
}

fn follows(nrmse_percent: f64, over_noise: f64) -> bool {
    over_noise < FOLLOWS || nrmse_percent > FOLLOWS_PERCENT
}

/// What prevents the links from being judged separately.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Obstacle {
    /// Command to rod cannot be divided: no spool is recorded.
    NoSpool,
    /// Flow, chambers and mechanics cannot be divided: no pressures are recorded.
    NoPressures,
    /// The pressures are recorded, but no motion that they could be compared with.
    NoMotion,
    /// The load is taken from the recorded pressures, so that the mechanics follow them by construction.
    LoadFromPressures,
}

/// The parts that a comparison is divided into: links, and what could not be divided further.
fn parts(comparison: &Comparison) -> impl Iterator<Item = (Section, SignalFit)> + '_ {
    let cut = |wanted: Section| comparison.sections.iter().any(|section| section.section == wanted);
    let below = cut(Section::FlowAndChambers) || cut(Section::Mechanics);
    let alone = !(below || cut(Section::Valve));
    comparison
        .sections
        .iter()
        .filter(move |section| match section.section {
            Section::BelowSpool => !below,
            Section::EndToEnd => alone,
            other => other.is_link(),
        })
        .flat_map(|section| noise_counted(section).map(move |fit| (section.section, fit)))
}

/// The fits of a section over noise: the signal's own noise, and the input noise from the section's input.
fn noise_counted(section: &SectionFit) -> impl Iterator<Item = SignalFit> + '_ {
    section.fits.iter().zip(&section.input_noise).map(|(fit, input_noise)| {
        let noise = (fit.rmse / fit.over_noise).hypot(*input_noise);
        SignalFit { over_noise: fit.rmse / noise, ..*fit }
    })
}

/// The part with the lowest fit over all the comparisons. Parts with an error above the noise come first, if there are
/// any; for a part that is in several comparisons, its mean counts.
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
    let followed = |part: &(Section, Signal, f64, f64)| follows(part.2, part.3);
    means.sort_by(|a, b| followed(a).cmp(&followed(b)).then(a.2.total_cmp(&b.2)));
    let &(section, signal, nrmse_percent, over_noise) = means.first()?;
    let runner_up = means.iter().find(|other| other.0 != section).map(|other| RunnerUp {
        section: other.0,
        nrmse_percent: other.2,
        follows: followed(other),
    });
    Some(Weakest { section, signal, nrmse_percent, over_noise, runner_up })
}

/// The signal with the lowest fit of the whole model among those with an error above the noise, and its fit, %; over several recordings the worst.
#[must_use]
pub fn missed_by_the_whole(comparisons: &[Comparison]) -> Option<(Signal, f64)> {
    let fits = comparisons.iter().filter_map(|comparison| comparison.sections.first()).flat_map(noise_counted);
    let missed = fits.filter(|fit| !follows(fit.nrmse_percent, fit.over_noise));
    let worst = missed.min_by(|a, b| a.nrmse_percent.total_cmp(&b.nrmse_percent));
    worst.map(|fit| (fit.signal, fit.nrmse_percent))
}

/// What prevents the links of a comparison from being judged separately; empty when each stands alone.
#[must_use]
pub fn obstacles(comparison: &Comparison, load: LoadSource) -> Vec<Obstacle> {
    let judged = |wanted: Section| comparison.sections.iter().any(|section| section.section == wanted);
    let first = comparison.sections.first();
    let computes = |signal| first.is_some_and(|section| section.trajectory.signal(signal).is_some());
    let measures =
        |signals: &[Signal]| first.is_some_and(|section| section.fits.iter().any(|fit| signals.contains(&fit.signal)));
    let mut found = Vec::new();
    if computes(Signal::Spool) && !judged(Section::Valve) {
        found.push(Obstacle::NoSpool);
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

#[cfg(test)]
mod tests {
    use simulation::{InputPoint, Trajectory};

    use super::*;

    fn comparison(sections: &[(Section, Signal, f64)]) -> Comparison {
        // Ten times the noise each.
        let fit = |signal, nrmse_percent| SignalFit {
            signal,
            nrmse_percent,
            r_squared: 0.0,
            rmse: 10.0,
            max_error: 30.0,
            max_at_s: 0.0,
            over_noise: 10.0,
        };
        let section = |&(section, signal, percent): &(Section, Signal, f64)| SectionFit {
            section,
            input_point: InputPoint::Command,
            fits: vec![fit(signal, percent)],
            input_noise: vec![0.0],
            trajectory: Trajectory { series: vec![(Signal::Spool, Vec::new()), (Signal::PressureA, Vec::new())] },
        };
        Comparison { recording: "r".into(), sections: sections.iter().map(section).collect() }
    }

    #[test]
    fn end_to_end_is_no_culprit_while_there_are_links() {
        let one = comparison(&[
            (Section::EndToEnd, Signal::Position, 10.0),
            (Section::Valve, Signal::Spool, 99.0),
            (Section::BelowSpool, Signal::Position, 50.0),
            (Section::FlowAndChambers, Signal::Position, 95.0),
            (Section::Mechanics, Signal::Position, 90.0),
        ]);
        let found = weakest(std::slice::from_ref(&one)).unwrap();
        assert_eq!((found.section, found.signal), (Section::Mechanics, Signal::Position));
        let runner_up = RunnerUp { section: Section::FlowAndChambers, nrmse_percent: 95.0, follows: false };
        assert_eq!((found.runner_up, found.rival()), (Some(runner_up), None));
        assert_eq!(obstacles(&one, LoadSource::Constant), [Obstacle::NoPressures]);
    }

    #[test]
    fn what_noise_explains_is_neither_weakest_nor_a_rival() {
        let mut one = comparison(&[
            (Section::Valve, Signal::Spool, 99.0),
            (Section::FlowAndChambers, Signal::Position, 95.0),
            (Section::Mechanics, Signal::Position, 94.9),
        ]);
        let found = weakest(std::slice::from_ref(&one)).unwrap();
        assert_eq!((found.section, found.rival()), (Section::Mechanics, Some((Section::FlowAndChambers, 95.0))));
        // The integrated noise of the pressures is as large.
        one.sections[2].input_noise = vec![8.0];
        let found = weakest(std::slice::from_ref(&one)).unwrap();
        assert_eq!((found.section, found.rival(), found.follows()), (Section::FlowAndChambers, None, false));
        for section in &mut one.sections {
            section.input_noise = vec![8.0];
        }
        let found = weakest(std::slice::from_ref(&one)).unwrap();
        assert_eq!((found.section, found.follows()), (Section::Mechanics, true));
    }

    #[test]
    fn parts_that_follow_do_not_speak_for_the_whole() {
        let mut one =
            comparison(&[(Section::EndToEnd, Signal::Position, 76.0), (Section::Mechanics, Signal::Position, 97.0)]);
        one.sections[1].input_noise = vec![8.0];
        assert!(weakest(std::slice::from_ref(&one)).unwrap().follows());
        assert_eq!(missed_by_the_whole(std::slice::from_ref(&one)), Some((Signal::Position, 76.0)));
        one.sections[0].input_noise = vec![8.0];
        assert_eq!(missed_by_the_whole(std::slice::from_ref(&one)), None);
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
        assert_eq!(obstacles(&whole, LoadSource::Constant), [Obstacle::NoSpool, Obstacle::NoPressures]);
        assert_eq!(weakest(&[]), None);
    }
}
