//! Which link has the largest misfit, and which signals would have to be measured to identify it where it cannot be identified.

use machine_file::LoadSource;
use recording::Signal;
use simulation::figures_of_merit::SignalFit;

use super::open_loop::Sway;
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
    /// Whether its misfit is larger than what small errors of sensors and parameters cause in it, so that it says something about physics.
    pub is_judged: bool,
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
    /// As [`Weakest::is_judged`].
    pub is_judged: bool,
}

/// A part with a misfit that says nothing about its physics: small errors of sensors and parameters move its output as far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unjudged {
    /// The part.
    pub section: Section,
    /// The signal.
    pub signal: Signal,
    /// Its RMSE, SI; over several recordings the mean.
    pub rmse: f64,
    /// How far it moves; of several recordings the one in which it moves most.
    pub sway: Sway,
}

/// A part whose error is less than twice its noise follows the signal. Noise that a position integrates makes a random
/// walk: its RMS is more than twice the usual in one case of fifty.
const FOLLOWS: f64 = 2.0;
/// A part whose fit is better than this, %, also follows, because a part alone cannot be simulated better: the load from
/// the pressures leaves inertia out, and rows are joined by straight lines.
const FOLLOWS_PERCENT: f64 = 99.5;
/// A misfit of less than this many times what small errors cause is no sign of missing physics: each of them is larger than its standard deviation
/// in one drive of three.
const BEYOND_SWAY: f64 = 2.0;

impl Weakest {
    /// Whether it is a part by itself whose misfit says nothing about physics: small errors of sensors and parameters cause as much.
    #[must_use]
    pub fn cannot_be_judged(&self) -> bool {
        !self.is_judged && self.section != Section::EndToEnd
    }

    /// Whether even this part follows its recordings within the noise, so that nothing indicates missing physics.
    #[must_use]
    pub fn follows(&self) -> bool {
        follows(self.nrmse_percent, self.over_noise)
    }

    /// Another part whose misfit is nearly as large (at least four fifths) and above the noise: the order of the two then means little.
    #[must_use]
    pub fn rival(&self) -> Option<(Section, f64)> {
        let near = |other: &RunnerUp| 100.0 - other.nrmse_percent >= 0.8 * (100.0 - self.nrmse_percent);
        self.runner_up
            .filter(|other| !other.follows && other.is_judged && near(other))
            .map(|other| (other.section, other.nrmse_percent))
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

/// One signal of a part in one recording.
#[derive(Clone, Copy, Debug)]
struct Part {
    section: Section,
    /// Over its noise, with the input noise from the section's input.
    fit: SignalFit,
    sway: Option<Sway>,
}

impl Part {
    /// The error over the noise and the sway together.
    fn over_sway(&self) -> f64 {
        let sway = self.sway.map_or(0.0, |sway| sway.rms);
        self.fit.rmse / libm::hypot(self.fit.rmse / self.fit.over_noise, sway)
    }
}

/// The parts that a comparison is divided into: links, and what could not be divided further.
fn parts(comparison: &Comparison) -> impl Iterator<Item = Part> + '_ {
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
        .flat_map(noise_counted)
}

/// The signals of a section, their fits over noise: the signal's own noise, and the input noise from the section's input.
fn noise_counted(section: &SectionFit) -> impl Iterator<Item = Part> + '_ {
    section.fits.iter().zip(&section.input_noise).enumerate().map(|(index, (fit, input_noise))| {
        let noise = libm::hypot(fit.rmse / fit.over_noise, *input_noise);
        let sway = section.sways.get(index).copied().flatten();
        Part { section: section.section, fit: SignalFit { over_noise: fit.rmse / noise, ..*fit }, sway }
    })
}

/// Whether a section does not follow its recording, so that it matters how far it sways.
pub(super) fn needs_sway(section: &SectionFit) -> bool {
    noise_counted(section).any(|part| !follows(part.fit.nrmse_percent, part.fit.over_noise))
}

/// One signal of a part over all recordings that have it: the means.
#[derive(Clone, Debug)]
struct Mean {
    section: Section,
    signal: Signal,
    nrmse_percent: f64,
    over_noise: f64,
    is_judged: bool,
    parts: Vec<Part>,
}

impl Mean {
    fn of(parts: Vec<Part>) -> Option<Self> {
        let Part { section, fit: SignalFit { signal, .. }, .. } = *parts.first()?;
        let mean = |of: &dyn Fn(&Part) -> f64| parts.iter().map(of).sum::<f64>() / parts.len() as f64;
        Some(Self {
            section,
            signal,
            nrmse_percent: mean(&|part| part.fit.nrmse_percent),
            over_noise: mean(&|part| part.fit.over_noise),
            is_judged: mean(&Part::over_sway) > BEYOND_SWAY,
            parts,
        })
    }

    fn follows(&self) -> bool {
        follows(self.nrmse_percent, self.over_noise)
    }
}

/// The means of every signal of every part, the weakest first: parts that do not follow and can be judged, those that cannot, those that follow.
fn means(comparisons: &[Comparison]) -> Vec<Mean> {
    let mut parts_of: Vec<Vec<Part>> = Vec::new();
    for part in comparisons.iter().flat_map(parts) {
        let same = |known: &Part| known.section == part.section && known.fit.signal == part.fit.signal;
        match parts_of.iter_mut().find(|known| same(&known[0])) {
            Some(known) => known.push(part),
            None => parts_of.push(vec![part]),
        }
    }
    let mut means: Vec<Mean> = parts_of.into_iter().filter_map(Mean::of).collect();
    let rank = |mean: &Mean| (mean.follows(), !mean.is_judged);
    means.sort_by(|a, b| rank(a).cmp(&rank(b)).then(a.nrmse_percent.total_cmp(&b.nrmse_percent)));
    means
}

/// The part with the lowest fit over all the comparisons. Parts with an error above the noise come first, if there are
/// any, and of these the ones that can be judged; for a part that is in several comparisons, its mean counts.
#[must_use]
pub fn weakest(comparisons: &[Comparison]) -> Option<Weakest> {
    let means = means(comparisons);
    let first = means.first()?;
    let runner_up = means.iter().find(|other| other.section != first.section).map(|other| RunnerUp {
        section: other.section,
        nrmse_percent: other.nrmse_percent,
        follows: other.follows(),
        is_judged: other.is_judged,
    });
    Some(Weakest {
        section: first.section,
        signal: first.signal,
        nrmse_percent: first.nrmse_percent,
        over_noise: first.over_noise,
        is_judged: first.is_judged,
        runner_up,
    })
}

/// The parts whose misfit says nothing about their physics, each with the signal that is off most.
#[must_use]
pub fn unjudged(comparisons: &[Comparison]) -> Vec<Unjudged> {
    let mut found: Vec<Unjudged> = Vec::new();
    for mean in means(comparisons).iter().filter(|mean| !mean.follows() && !mean.is_judged) {
        let sways = mean.parts.iter().filter_map(|part| part.sway);
        let Some(sway) = sways.max_by(|a, b| a.rms.total_cmp(&b.rms)) else { continue };
        if found.iter().all(|known| known.section != mean.section) {
            let rmse = mean.parts.iter().map(|part| part.fit.rmse).sum::<f64>() / mean.parts.len() as f64;
            found.push(Unjudged { section: mean.section, signal: mean.signal, rmse, sway });
        }
    }
    found
}

/// The signal with the lowest fit of the whole model among those with an error above the noise, and above what small errors cause, and its fit, %;
/// over several recordings the worst.
#[must_use]
pub fn missed_by_the_whole(comparisons: &[Comparison]) -> Option<(Signal, f64)> {
    let parts = comparisons.iter().filter_map(|comparison| comparison.sections.first()).flat_map(noise_counted);
    let missed = parts
        .filter(|part| !follows(part.fit.nrmse_percent, part.fit.over_noise) && part.over_sway() > BEYOND_SWAY)
        .map(|part| part.fit);
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

    use super::super::open_loop::Mover;
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
            sways: Vec::new(),
            trajectory: Trajectory { series: vec![(Signal::Spool, Vec::new()), (Signal::PressureA, Vec::new())] },
        };
        Comparison {
            recording: "r".into(),
            unsettled_s: 0.0,
            ends: Vec::new(),
            sections: sections.iter().map(section).collect(),
        }
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
        let runner_up =
            RunnerUp { section: Section::FlowAndChambers, nrmse_percent: 95.0, follows: false, is_judged: true };
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
    fn what_a_small_offset_moves_as_far_is_not_accused() {
        let mut one = comparison(&[
            (Section::FlowAndChambers, Signal::Position, 95.0),
            (Section::Mechanics, Signal::Position, 53.0),
        ]);
        assert_eq!(weakest(std::slice::from_ref(&one)).unwrap().section, Section::Mechanics);
        assert_eq!(unjudged(std::slice::from_ref(&one)), []);
        let sway = Sway { rms: 6.0, most: Mover::Offset(Signal::PressureA), by_most: 5.5 };
        one.sections[1].sways = vec![Some(sway)];
        let found = weakest(std::slice::from_ref(&one)).unwrap();
        assert_eq!((found.section, found.is_judged, found.rival()), (Section::FlowAndChambers, true, None));
        let unjudged = unjudged(std::slice::from_ref(&one));
        assert_eq!(unjudged, [Unjudged { section: Section::Mechanics, signal: Signal::Position, rmse: 10.0, sway }]);
        // Where nothing else misses, it is still the weakest, but not judged.
        one.sections[0].sways = vec![Some(sway)];
        assert!(!weakest(std::slice::from_ref(&one)).unwrap().is_judged);
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
