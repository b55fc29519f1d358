//! Drives with a worn part that their machine file holds, recorded again later: with more or less of it, or with as much as before.
//!
//! The file of then is what a diagnosis of then saved. Later the drive is driven differently and read with other noise.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use rayon::prelude::*;

use diagnosis::{Diagnosis, diagnose_since};
use recording::seeded_noise::Noise;
use virtual_plant::hall::{Change, RECORDINGS, Worn, recorded, runs, stays_inside, times};

use super::super::bed::Case;
use super::{Matter, keep, named};

/// Pairs of each part: with a change, and without.
const CHANGED: u64 = 12;
const SAME: u64 = 4;
/// Draws of what is recorded later before a pair counts as one that cannot be drawn.
const ATTEMPTS: u64 = 60;
/// A ratio counts as right within this share.
const RATIO_WITHIN: f64 = 0.2;

/// What was said of a pair.
#[derive(serde::Serialize, serde::Deserialize)]
pub(super) struct Pair {
    name: String,
    part: String,
    /// How much there is later of what there was.
    ratio: f64,
    /// What was found then; the pair counts only if that is right.
    then: bool,
    /// Ratio that was found of the part, if it was found to have changed.
    found: Option<f64>,
    /// What else was named.
    falsely: Vec<String>,
    unchanged: bool,
    /// Whether the part is said to act otherwise than then.
    #[serde(default)]
    otherwise: bool,
}

impl Pair {
    /// Whether the change was found with its ratio, and nothing else.
    pub(super) fn is_right(&self) -> bool {
        self.has_ratio() && self.falsely.is_empty()
    }

    /// Whether it was found then, and nothing is said to have changed or to be new.
    pub(super) fn claims_nothing(&self) -> bool {
        self.then && self.found.is_none() && self.falsely.is_empty()
    }

    /// Whether its part is said to act otherwise than then.
    pub(super) fn acts_otherwise(&self) -> bool {
        self.otherwise
    }

    fn has_ratio(&self) -> bool {
        self.found.is_some_and(|found| (found / self.ratio - 1.0).abs() < RATIO_WITHIN)
    }

    pub(super) fn line(&self) -> String {
        let found = self.found.map_or_else(|| "no change".to_owned(), |ratio| format!("{ratio:.2}"));
        let then = if self.then { "" } else { ", not found then" };
        format!("{}: {found} for {:.2}, also {:?}{then}", self.name, self.ratio, self.falsely)
    }
}

/// Where `HALL_RESUME` names a folder, what was said of a pair before is read there, and what is said of another is written there: one folder for one
/// program.
fn pair(worn: Worn, number: u64) -> Pair {
    let Some(folder) = std::env::var_os("HALL_RESUME") else { return pair_now(worn, number) };
    let path = Path::new(&folder).join(format!("{}-{number}-later.json", worn.name()));
    if let Ok(before) = std::fs::read_to_string(&path) {
        return serde_json::from_str(&before).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    let pair = pair_now(worn, number);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(path, serde_json::to_string(&pair).unwrap()).unwrap();
    pair
}

/// A pair: the first ones of a part have changed, those after them have not.
pub(super) fn pair_now(worn: Worn, number: u64) -> Pair {
    let (mut hall, made) = super::drawn(Matter::Within(worn), number);
    let begun = Instant::now();
    let mut training = named(&made);
    let held_out = training.split_off(RECORDINGS - 1);
    let then = Case { file: hall.file.clone(), training, held_out }.diagnose();
    let name = format!("{}-{number}", worn.name());
    let right = |diagnosis: &Diagnosis| {
        let is_right = |name: &str| worn.right().contains(&name);
        !diagnosis.findings.is_empty() && diagnosis.findings.iter().all(|finding| is_right(finding.effect.name))
    };
    let mut pair = Pair {
        name,
        part: worn.name().to_owned(),
        ratio: 1.0,
        then: right(&then),
        found: None,
        falsely: Vec::new(),
        unchanged: false,
        otherwise: false,
    };
    if !pair.then {
        return pair;
    }
    let effect = *hall.effects.last().unwrap();
    let later = (0..ATTEMPTS).find_map(|attempt| {
        let mut dice = Noise::new(1_000_000 + number, attempt);
        let ratio = match (number < CHANGED, dice.happens(0.6)) {
            (false, _) => 1.0,
            (true, true) => dice.decades(1.4, 2.5),
            (true, false) => dice.decades(0.4, 0.7),
        };
        *hall.effects.last_mut()? = times(effect, ratio)?;
        let runs = runs(&hall, &mut dice)?;
        let whole = runs.iter().map(|run| Some((run, run.whole(&hall, &Change::default())?)));
        let whole: Vec<_> = whole.collect::<Option<_>>()?;
        let inside = whole.iter().all(|(_, whole)| stays_inside(&hall, whole));
        inside.then(|| (ratio, whole.iter().map(|(run, whole)| recorded(&hall, run, whole)).collect::<Vec<_>>()))
    });
    let (ratio, made) = later.unwrap_or_else(|| panic!("{} cannot be recorded again", pair.name));
    let mut training = named(&made);
    let held_out = training.split_off(RECORDINGS - 1);
    let file = then.machine_file(&hall.file);
    if let Some(folder) = std::env::var_os("HALL_KEEP") {
        let mut kept = hall.clone();
        kept.toml = file.to_text(&pair.name).unwrap();
        kept.file.name = format!("{}-later", pair.name);
        keep(Path::new(&folder), &kept, &made);
    }
    let now = diagnose_since(&file, &training, &held_out, None, &|_| {}).unwrap();
    pair.ratio = ratio;
    pair.unchanged = now.is_unchanged();
    pair.otherwise = now.otherwise.iter().any(|effect| worn.right().contains(&effect.name));
    for finding in &now.findings {
        match report::wording::most_changed(finding) {
            Some((estimate, before)) => pair.found = Some(estimate.value / before),
            None => pair.falsely.push(finding.effect.name.to_owned()),
        }
    }
    let pressed = now.tolerances().into_iter().filter(|one| one.left_then.is_some()).map(|one| one.parameter);
    let pressed = pressed.collect::<Vec<_>>();
    eprintln!(
        "{}, {:?}, {:.0} s, at the end of what was left: {pressed:?}",
        pair.line(),
        now.verdict,
        begun.elapsed().as_secs_f64()
    );
    eprintln!("    {}", report::terminal::sentence(&now));
    pair
}

/// Every pair of the study, one of each part after the other: what is done of it says something of every part.
pub(super) fn study() -> Vec<(Worn, u64)> {
    (0..CHANGED + SAME).flat_map(|number| Worn::that_grow().map(move |worn| (worn, number))).collect()
}

pub(super) fn all(pairs: &[(Worn, u64)]) -> Vec<Pair> {
    pairs.par_iter().map(|&(worn, number)| pair(worn, number)).collect()
}

/// Of pairs whose part was found then: of those that changed, how many are named, with the right ratio, and with something else; of the others how many
/// are said to be unchanged, and of how many something is claimed.
pub(super) struct Counts {
    pub(super) changed: usize,
    pub(super) named: usize,
    pub(super) ratio: usize,
    pub(super) same: usize,
    pub(super) unchanged: usize,
    pub(super) claimed: usize,
    pub(super) falsely: usize,
}

impl Counts {
    pub(super) fn of<'a>(pairs: impl IntoIterator<Item = &'a Pair>) -> Self {
        let (same, changed): (Vec<&Pair>, Vec<&Pair>) =
            pairs.into_iter().filter(|pair| pair.then).partition(|pair| (pair.ratio - 1.0).abs() < 1e-9);
        Self {
            changed: changed.len(),
            named: changed.iter().filter(|pair| pair.found.is_some()).count(),
            ratio: changed.iter().filter(|pair| pair.has_ratio()).count(),
            same: same.len(),
            unchanged: same.iter().filter(|pair| pair.unchanged).count(),
            claimed: same.iter().filter(|pair| pair.found.is_some() || !pair.falsely.is_empty()).count(),
            falsely: changed.iter().filter(|pair| !pair.falsely.is_empty()).count(),
        }
    }
}

/// A row for each part, and one for all.
pub(super) fn table(pairs: &[Pair]) -> String {
    let mut text = format!(
        "{:<24}{:>9}{:>8}{:>8}{:>12}{:>8}{:>11}{:>9}\n",
        "part", "changed", "named", "ratio", "false beside", "same", "unchanged", "claimed"
    );
    let mut row = |name: &str, of: Counts| {
        let Counts { changed, named, ratio, same, unchanged, claimed, falsely } = of;
        let _ = writeln!(
            text,
            "{name:<24}{changed:>9}{named:>8}{ratio:>8}{falsely:>12}{same:>8}{unchanged:>11}{claimed:>9}"
        );
    };
    for part in Worn::that_grow().map(Worn::name) {
        let of: Vec<&Pair> = pairs.iter().filter(|pair| pair.part == part).collect();
        if !of.is_empty() {
            row(part, Counts::of(of));
        }
    }
    row("all", Counts::of(pairs));
    text
}
