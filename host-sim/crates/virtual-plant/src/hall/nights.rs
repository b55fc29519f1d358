//! A hall of drives, night by night: most stay healthy, in some a part wears, oil is warmer in one season than in another, drives are off, loggers change.
//!
//! A drive is commissioned with four motions on each of three days, and then repeats two of those motions each night. It is what its data sheet can mean and no more is known of it. A part that wears
//! does so from one night on, by as much every night.

use model_core::machine::Parameter;
use recording::seeded_noise::Noise;

use super::drive::Hall;
use super::recordings::{Change, Run, recorded, runs, stays_inside};
use super::worn::{Worn, amount, made, times};
use crate::effect::PlantEffect;
use crate::effect::oil::OilGrade;
use crate::rig::recorded::SyntheticRecording;

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shop {
    /// The same seed draws the same hall; a drive does not depend on how many others there are.
    pub seed: u64,
    /// How many nights.
    pub nights: usize,
}

/// One drive of a hall, with everything that was recorded of it.
#[derive(Clone, Debug)]
pub struct OfHall {
    /// The drive as it was commissioned.
    pub hall: Hall,
    /// Recordings of its commissioning, day by day.
    pub healthy: Vec<SyntheticRecording>,
    /// Its nights.
    pub nights: Vec<OneNight>,
    /// What wears.
    pub wear: Option<Wear>,
    /// The night from which on its logger writes another format.
    pub logger_changes: Option<usize>,
}

/// A part that wears.
#[derive(Clone, Copy, Debug)]
pub struct Wear {
    /// The part, by the names that are right for it.
    pub worn: Worn,
    /// From which night on.
    pub from: usize,
    /// The amounts of a machine file that say how much there is of it; none where its form shares no number with it.
    pub amounts: &'static [Parameter],
    /// How much there is of it while nothing wears, SI: what is installed.
    pub before: f64,
}

/// What one night of a drive is.
#[derive(Clone, Debug)]
pub struct OneNight {
    /// What was recorded; nothing where the drive was off and the logger too.
    pub recordings: Vec<SyntheticRecording>,
    /// Whether the drive was off.
    pub is_off: bool,
    /// How much of the worn part there is, as a share of what there is of it in the last night.
    pub worn: f64,
    /// How much of it there is, SI, where a machine file has an amount of it.
    pub amount: Option<f64>,
    /// Temperature of the oil, °C.
    pub oil_c: f64,
}

/// Share of drives of which a part wears.
const WEARS: f64 = 0.2;
/// Share of nights in which a drive is off.
const IS_OFF: f64 = 0.05;
/// Share of drives whose logger changes its format.
const LOGGER_CHANGES: f64 = 0.1;
/// Draws of one drive before it counts as one that cannot be drawn.
const ATTEMPTS: u64 = 60;
/// Days of a commissioning.
const COMMISSIONED: usize = 3;
/// Temperature at which a hall's oil is commissioned, °C, how far a season takes it, and how far a night, K.
const OIL_C: f64 = 45.0;
const SEASON_K: f64 = 6.0;
const NIGHT_K: f64 = 1.5;

/// The drive of this number; `None` where none stays inside its stroke.
#[must_use]
pub fn of_hall(shop: &Shop, number: u64) -> Option<OfHall> {
    (0..ATTEMPTS).find_map(|attempt| attempted(shop, number, &mut Noise::new(shop.seed ^ (number << 20), attempt)))
}

fn attempted(shop: &Shop, number: u64, dice: &mut Noise) -> Option<OfHall> {
    let mut hall = Hall::draw(&format!("drive-{number:03}"), dice)?;
    // Oil of grade 46, whose viscosity the file's values hold at the temperature of the commissioning.
    let oil = OilGrade { at_40_mm2_per_s: 46.0, at_100_mm2_per_s: 6.8, reference_c: OIL_C, temperature_c: OIL_C };
    hall.effects.push(PlantEffect::OilGrade(oil));
    let runs = runs(&hall, dice)?;
    let sees_oil = dice.happens(0.5);
    let at = |oil_c| Change { oil_c: Some(oil_c), sees_oil, ..Change::default() };
    let mut healthy = Vec::new();
    for day in 0..COMMISSIONED {
        let oil_c = OIL_C + if day == 0 { 0.0 } else { dice.gaussian(NIGHT_K) };
        for run in &runs {
            let run = if day == 0 { run.clone() } else { run.again(dice.uniform(0.0, 1e9).to_bits()) };
            healthy.push(recorded(&hall, &run, &run.whole(&hall, &at(oil_c))?));
        }
    }

    let wears = dice.happens(WEARS).then(|| Worn::that_grow().nth(dice.below(Worn::that_grow().count()))).flatten();
    let wear = match wears {
        None => None,
        Some(worn) => {
            let mut later = hall.clone();
            // As much as shows in the end.
            made(&mut later, worn, &runs, dice)?;
            Some((worn, later, dice.below((shop.nights / 2).max(1))))
        }
    };
    let logger_changes = dice.happens(LOGGER_CHANGES).then(|| dice.below(shop.nights.max(1)));
    let season = dice.uniform(0.0, std::f64::consts::TAU);
    // At an opening of 0.4 and half the supply, m³/s.
    let usual_m3_per_s =
        0.4 * hall.truth.get(Parameter::FlowCoefficient) * (0.5 * hall.truth.get(Parameter::SupplyPressure)).sqrt();
    let mut nights = Vec::new();
    for night in 0..shop.nights {
        let turned = season + std::f64::consts::TAU * night as f64 / 60.0;
        let oil_c = OIL_C + SEASON_K * (libm::sin(turned) - libm::sin(season)) + dice.gaussian(NIGHT_K);
        let is_off = dice.happens(IS_OFF);
        let mut now = hall.clone();
        let worn = wear.as_ref().map_or(0.0, |(.., from)| {
            // From this night on, by as much every night, to all of it in the last.
            (night as f64 + 1.0 - *from as f64).max(0.0) / (shop.nights - from) as f64
        });
        let mut there = None;
        if let Some((_, later, _)) = wear.as_ref().filter(|_| worn > 0.0) {
            now.effects.clone_from(&later.effects);
            let effect = now.effects.last_mut()?;
            *effect = grown(*effect, &hall, worn, usual_m3_per_s)?;
            there = amount(effect, usual_m3_per_s);
        }
        let first = dice.below(runs.len());
        let chosen = [first, (first + 1) % runs.len()].map(|index| &runs[index]);
        let mut recordings = Vec::new();
        for run in chosen {
            let run = run.again(dice.uniform(0.0, 1e9).to_bits());
            recordings.extend(night_of(&now, &run, &at(oil_c), is_off));
        }
        nights.push(OneNight { recordings, is_off, worn, amount: there.map(|(_, value)| value), oil_c });
    }
    let wear = wear.and_then(|(worn, later, from)| {
        let effect = later.effects.last()?;
        let amounts = amount(effect, usual_m3_per_s).map_or(&[][..], |of| of.0);
        Some(Wear { worn, from, amounts, before: installed(&hall, effect, usual_m3_per_s) })
    });
    Some(OfHall { hall, healthy, nights, wear, logger_changes })
}

/// A run of a night; none where the rod would not have stayed inside its stroke: then that motion is left out.
fn night_of(hall: &Hall, run: &Run, change: &Change, is_off: bool) -> Option<SyntheticRecording> {
    let run = if is_off { run.resting(hall.tick_s) } else { run.clone() };
    let whole = run.whole(hall, change)?;
    (is_off || stays_inside(hall, &whole)).then(|| recorded(hall, &run, &whole))
}

/// How much of an effect is installed, SI; 0 where nothing is of its kind.
fn installed(hall: &Hall, effect: &PlantEffect, usual_m3_per_s: f64) -> f64 {
    let of = |one: &PlantEffect| amount(one, usual_m3_per_s);
    let same =
        |one: &PlantEffect| of(one).zip(of(effect)).filter(|(own, other)| own.0 == other.0).map(|(own, _)| own.1);
    if matches!(effect, PlantEffect::Sensing(_)) { 0.0 } else { hall.effects.iter().find_map(same).unwrap_or(0.0) }
}

/// A worn part at a share of the way from what is installed to what there is of it in the end.
fn grown(effect: PlantEffect, hall: &Hall, share: f64, usual_m3_per_s: f64) -> Option<PlantEffect> {
    let before = installed(hall, &effect, usual_m3_per_s);
    let by = match amount(&effect, usual_m3_per_s) {
        Some((_, after)) => (before + share * (after - before)) / after,
        None => share,
    };
    times(effect, by)
}
