//! The diagnosis on the terminal.

mod tables;

use std::fmt::Write;

use diagnosis::catalogue::short_name;
use diagnosis::localisation::{Interval, Location, Miss};
use diagnosis::{Diagnosis, Verdict};
use identification::fit::{CORRELATED, Correlation};
use recording::display_unit::{in_si, significant};

use crate::evidence::{Exhibits, whiteness};
use crate::size::size;
use crate::wording;
use tables::{fits, trials, waterfall};

pub use tables::{held_out_fits, parameters, tolerances, uncertainty};

/// The whole text.
#[must_use]
#[expect(clippy::too_many_lines, reason = "the whole text, part by part")]
pub fn text(diagnosis: &Diagnosis, exhibits: &Exhibits) -> String {
    let mut text = sentence(diagnosis);
    text.push('\n');
    for shown in wording::structure_shown(diagnosis) {
        let _ = writeln!(text, "structure  {shown}");
    }
    text += &unfinished(diagnosis);
    text += &doubtful(diagnosis);
    if exhibits.preprocessing.iter().any(|of| of.taken_as_absolute) {
        let _ = writeln!(text, "{}", wording::taken_as_absolute());
    }
    // Of a model that is wrong as a whole no part is to blame.
    if let Some(location) = diagnosis.located.as_ref().filter(|_| !is_structure_wrong(diagnosis)) {
        let (link, signal, region) = (location.subsystem, location.signal, wording::region(location.region));
        let _ = writeln!(text, "\nlocated    {link} · {signal} · {region}");
        let _ = writeln!(text, "           {}\n           {}", when(location), wording::error_shape(&location.shape));
        for habit in &location.spool {
            let _ = writeln!(text, "           {}", wording::spool_habit(habit));
        }
    }
    if let Some(effect) = diagnosis.suspected {
        let _ = writeln!(text, "suspected  {}: {SUSPECTED}", effect.name);
    }
    for finding in &diagnosis.findings {
        let _ = writeln!(text, "\nfinding    {} (confidence {:.3})", finding.effect.name, finding.confidence);
        if let Some(change) = wording::change(&diagnosis.machine_after, finding) {
            let _ = writeln!(text, "changed    {change}");
        }
        let _ = writeln!(text, "equation   {}", finding.effect.equation);
        for estimate in &finding.parameters {
            let unit = estimate.parameter.description().unit;
            let _ = writeln!(
                text,
                "parameter  {} = {} ± {} {unit}",
                short_name(estimate.parameter),
                in_si(estimate.value, 5),
                uncertainty(estimate)
            );
            if let Some(size) = size(&diagnosis.machine_after, estimate.parameter, estimate.value) {
                let _ = writeln!(text, "size       {size}");
            }
        }
        if let Some(jumps) = finding.jumps {
            let _ = writeln!(text, "source     {}", wording::jumps(jumps));
        }
        for (effect, confidence) in &finding.alternatives {
            let _ = writeln!(text, "or         {} (probability {confidence:.3})", effect.name);
        }
        let mut rivals = exhibits.rivals(finding).peekable();
        if rivals.peek().is_none() {
            let _ =
                writeln!(text, "to be sure {}", wording::separated_by(finding.effect, diagnosis.machine_after.source));
        }
        for rival in rivals {
            let _ = writeln!(text, "to exclude {}: {}", rival.rival, wording::advice(rival));
        }
    }
    for effect in &diagnosis.not_confirmed {
        let _ = writeln!(
            text,
            "\nnot confirmed: {} was chosen on the training recordings, but the held-out recordings do not confirm it: they gain nothing, or too little of what it promised",
            effect.name
        );
    }
    if let Some(outside) = &diagnosis.outside {
        let (cause, explains) = (wording::outside_cause(&outside.cause), wording::outside_explains(outside));
        let _ = writeln!(text, "\noutside    {cause}\nexplains   {explains}");
    }
    if let Some(unnamed) = &diagnosis.unnamed {
        let _ = writeln!(text, "\n{}", wording::correction_table(unnamed));
    }
    let _ = write!(text, "\n{}\n", fits(diagnosis));
    if let Some(linear) = wording::yardstick(diagnosis) {
        let _ = writeln!(text, "{linear}");
    }
    let _ = write!(text, "\n{}\n", waterfall(exhibits));
    if let Some(told) = whiteness::in_words(&exhibits.whiteness) {
        let _ = writeln!(text, "residual   {told}");
    }
    let _ = writeln!(text, "{}", prepared(exhibits));
    if !diagnosis.refitted.is_empty() {
        let _ = write!(text, "\n{}\n", parameters(&diagnosis.base_values()));
    }
    if let Some(tolerances) = tolerances(&diagnosis.machine_after, &diagnosis.tolerances()) {
        let _ = writeln!(text, "{tolerances}");
    }
    if let Some(pairs) = correlated(&diagnosis.correlated) {
        let _ = writeln!(text, "{pairs}");
    }
    if let Some(level) = diagnosis.level_at_rest {
        let _ = writeln!(
            text,
            "start      {} % of supply pressure in B at rest (mean of the training recordings); each held-out recording starts from the level that fits it best",
            significant(100.0 * level, 3)
        );
    }
    let _ = write!(text, "\n{}\n", trials(diagnosis));
    if diagnosis.verdict == Verdict::MissingPhysics && !diagnosis.left.is_empty() {
        let _ = writeln!(text, "{}", still_missing(diagnosis));
    }
    if !diagnosis.not_testable.is_empty() {
        let names: Vec<_> = diagnosis.not_testable.iter().map(|effect| effect.name).collect();
        let _ = writeln!(text, "not testable with these recordings: {}", names.join(", "));
    }
    text
}

/// Whether nothing that the refit says of the machine means anything, because the position does not come about as it does in the model.
pub(crate) fn is_structure_wrong(diagnosis: &Diagnosis) -> bool {
    diagnosis.verdict == Verdict::Unexplained && diagnosis.structure.follows()
}

/// What a search that its limit has ended did not try, and what was slow.
fn unfinished(diagnosis: &Diagnosis) -> String {
    let (mut text, searched) = (String::new(), &diagnosis.selection.searched);
    if searched.left_out.is_empty() {
        return text;
    }
    let _ = writeln!(text, "not tried  {} (or not to the end)", wording::not_tried(searched).join(", "));
    let _ = writeln!(text, "slow       {}; --time-limit gives it longer", wording::slow(searched));
    if let Some(best) = wording::best_so_far(&diagnosis.selection).filter(|_| !searched.is_finished()) {
        let _ = writeln!(text, "best so far {best}");
    }
    text
}

/// What is doubtful about the recordings for this drive, and values that the refit has moved far or not brought to rest.
fn doubtful(diagnosis: &Diagnosis) -> String {
    let mut text = String::new();
    for doubt in &diagnosis.doubts {
        let _ = writeln!(text, "doubt      {}", wording::doubt(doubt));
    }
    if let Some(oil) = &diagnosis.other_oil {
        let _ = writeln!(text, "oil        {}", wording::other_oil(oil));
    }
    for effect in &diagnosis.untested {
        let _ = writeln!(text, "untested   {}: these recordings cannot show whether it has changed", effect.name);
    }
    for effect in &diagnosis.otherwise {
        let _ = writeln!(
            text,
            "otherwise  {}: {}; recordings over the whole range of then would tell",
            effect.name,
            wording::TRADED
        );
    }
    if is_structure_wrong(diagnosis) {
        return text;
    }
    for far in wording::far_values(&diagnosis.far_values()) {
        let _ = writeln!(text, "far value  {far}");
    }
    if let Some(moving) = &diagnosis.unsettled {
        let _ = writeln!(text, "moving     the refit did not converge: {}", wording::still_moving(moving));
    }
    for used in wording::used_up(&diagnosis.machine_after, &diagnosis.tolerances()) {
        let _ = writeln!(text, "tolerance  {used}");
    }
    text
}

/// When the error is made, how much of it, and the stretches that hold most of it.
#[must_use]
pub fn when(location: &Location) -> String {
    /// Stretches that are listed one by one.
    const TOLD: usize = 3;
    let percent = |share: f64| significant(100.0 * share, 2);
    let intervals = &location.intervals;
    if intervals.is_empty() {
        return "no time stands out: no interval has twice the error of the rest".to_owned();
    }
    let each = |interval: &Interval| {
        let (from_s, to_s) = (significant(interval.from_s, 3), significant(interval.to_s, 3));
        format!("{} from {from_s} to {to_s} s ({} %)", interval.recording, percent(interval.share))
    };
    let told = intervals.iter().take(TOLD).map(each).collect::<Vec<_>>().join(", ");
    let most = if intervals.len() > TOLD { "; most in " } else { ": " };
    let stretches = if intervals.len() == 1 {
        "1 interval holds".to_owned()
    } else {
        format!("{} intervals hold", intervals.len())
    };
    format!(
        "{stretches} {} % of the error in {} % of the time{most}{told}",
        percent(location.share),
        percent(location.of_time)
    )
}

/// What "suspected" means.
pub const SUSPECTED: &str =
    "likelier than no effect on the training recordings, but not enough to accept it; every signal is within its noise";

/// The verdict in a sentence.
#[must_use]
pub fn sentence(diagnosis: &Diagnosis) -> String {
    format!("{}{}", verdict(diagnosis), wording::doubt_of_then(diagnosis))
}

fn verdict(diagnosis: &Diagnosis) -> String {
    let name = &diagnosis.machine;
    match diagnosis.verdict {
        Verdict::MissingPhysics => {
            let found = |finding| wording::found(diagnosis, finding);
            let effects: Vec<String> = diagnosis.findings.iter().map(found).collect();
            let what = if diagnosis.since.is_some() { "changed" } else { "missing physics" };
            let confirmed = match &diagnosis.confirmation {
                Some(confirmation) => {
                    format!("confirmed on {} of {} held-out recordings", confirmation.improved, confirmation.recordings)
                }
                None => "not confirmed: no recording was held out".to_owned(),
            };
            let outside = diagnosis.outside.as_ref().map(|outside| wording::outside_kind(&outside.cause));
            let outside =
                outside.map_or_else(String::new, |cause| format!("; beside it, from outside the drive: {cause}"));
            let effects = effects.join(" and ");
            match worst(&diagnosis.left) {
                Some(left) => format!(
                    "{name}: {what}, partly explained: {effects}; {} is still off by {} times its noise; {confirmed}{outside}",
                    left.signal,
                    significant(left.over_noise, 2)
                ),
                None => format!("{name}: {what}: {effects}; {confirmed}{}{outside}", held_out(diagnosis)),
            }
        }
        Verdict::NothingMissing if diagnosis.training_is_too_narrow => {
            let nothing = match diagnosis.since {
                Some(_) => wording::unchanged(diagnosis, "follows the training recordings, which leave values open"),
                None => "nothing missing, but the training recordings leave values open".to_owned(),
            };
            format!(
                "{name}: {nothing}: the model follows them all if it is refitted to all{}; give the held-out recordings to --train as well, and hold out others",
                held_out(diagnosis)
            )
        }
        Verdict::NothingMissing => {
            let noise = if diagnosis.left.is_empty() { "their noise" } else { "twice their noise" };
            let follows = format!("follows the recordings within {noise}");
            let nothing = match diagnosis.since {
                Some(_) => wording::unchanged(diagnosis, &follows),
                None => format!("nothing missing: the refitted model {follows}"),
            };
            format!("{name}: {nothing}{}", held_out(diagnosis))
        }
        Verdict::Unexplained if let Some(reached) = wording::limit_reached(&diagnosis.selection.searched) => {
            let misfit = if diagnosis.left.is_empty() {
                "the refitted model follows the training recordings within their noise"
            } else {
                "there is a misfit above the noise"
            };
            format!("{name}: unexplained so far: {misfit}; {reached}")
        }
        Verdict::Unexplained if let Some(outside) = &diagnosis.outside => format!(
            "{name}: unexplained by the drive itself; probable cause outside it: {}; no effect of the catalogue explains as much",
            wording::outside_kind(&outside.cause)
        ),
        Verdict::Unexplained if let Some(structure) = wording::structure(diagnosis) => {
            format!("{name}: unexplained: {structure}")
        }
        Verdict::Unexplained => {
            format!("{name}: unexplained: {}, and no effect of the catalogue explains it", unexplained(diagnosis))
        }
    }
}

/// What is unexplained.
fn unexplained(diagnosis: &Diagnosis) -> String {
    if !diagnosis.left.is_empty() {
        return "there is a misfit above the noise".to_owned();
    }
    let far = diagnosis.far_values();
    if let Some(far) = far.iter().find(|far| far.is_impossible) {
        return format!("the model follows the recordings only with {}", wording::moved(far));
    }
    format!("the model follows the recordings that it was fitted to, but not others{}", held_out(diagnosis))
}

/// How far the model is off in recordings that it was not fitted to, where that is more than noise.
fn held_out(diagnosis: &Diagnosis) -> String {
    worst(&diagnosis.left_held_out).map_or_else(String::new, |left| {
        format!("; held out, {} is off by {} times its noise", left.signal, significant(left.over_noise, 2))
    })
}

/// The signal that is furthest off.
fn worst(misses: &[Miss]) -> Option<&Miss> {
    misses.iter().max_by(|a, b| a.over_noise.total_cmp(&b.over_noise))
}

/// The misfit above noise that the accepted effects leave.
#[must_use]
pub fn still_missing(diagnosis: &Diagnosis) -> String {
    format!("something is still missing: with these effects the model is off in {}", missed(&diagnosis.left))
}

/// How far signals are off, in multiples of their noise.
#[must_use]
pub fn missed(misses: &[Miss]) -> String {
    let signal = |miss: &Miss| format!("{} ({:.1} times its noise)", miss.signal, miss.over_noise);
    misses.iter().map(signal).collect::<Vec<_>>().join(", ")
}

/// What the preprocessing found, in a line, and a line for each failure and clock that is worth reporting.
fn prepared(exhibits: &Exhibits) -> String {
    let found = &exhibits.preprocessing;
    let failed: usize = found.iter().flat_map(|of| &of.channels).map(|channel| channel.spikes).sum();
    let noise: Vec<String> = found
        .iter()
        .take(1)
        .flat_map(|of| &of.channels)
        .map(|channel| {
            format!("{} {}", channel.signal, recording::display_unit::difference(channel.signal, channel.noise))
        })
        .collect();
    let dither = found.iter().find_map(|of| of.dither);
    let dither = dither.map_or_else(String::new, |line| {
        format!("; dither {} V at {} Hz", significant(line.amplitude, 2), significant(line.hz, 3))
    });
    let mut text = format!("prepared   noise: {}; {failed} spikes not judged{dither}", noise.join(", "));
    for of in found {
        for (failure, fate) in of.failures() {
            let _ = write!(text, "\n           {}: {failure}; {fate}", of.recording);
        }
        for said in of.of_start_and_clock() {
            let _ = write!(text, "\n           {}: {said}", of.recording);
        }
    }
    text
}

/// Pairs of parameters of which the recordings determine only the combination, in a sentence; `None` where there are none.
#[must_use]
pub fn correlated(pairs: &[Correlation]) -> Option<String> {
    let limit = significant(CORRELATED, 1);
    let listed = pairs.iter().map(wording::correlation).collect::<Vec<_>>().join("; ");
    (!pairs.is_empty())
        .then(|| format!("strongly correlated (|r| > {limit}), only their combination is well determined: {listed}"))
}
