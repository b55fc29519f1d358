//! Doubts about the cylinder: the pressures that balance a load tell the ratio of its areas, whatever flows.
//!
//! `pa = ρ·pb + (load + m·a + D·v + friction)/Aa` with `ρ = Ab/Aa`. Regression over all rows gives ρ; friction, which changes sign with the velocity as
//! both pressures do, is held to what seals have. How large both areas are together no pressure tells: of cylinders with this ratio the one nearest to the
//! file's comes first.

use model_core::machine::{Machine, Parameter};
use nalgebra::{Matrix5, Vector5};
use recording::{Recording, Signal};
use simulation::signal::slope::slopes;
use simulation::signal::window::rows_in;

use super::change::Change;

/// Bores and rods that cylinders are made with, mm (ISO 3320).
const BORES_MM: [f64; 10] = [25.0, 32.0, 40.0, 50.0, 63.0, 80.0, 100.0, 125.0, 160.0, 200.0];
const RODS_MM: [f64; 22] = [
    12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 25.0, 28.0, 32.0, 36.0, 40.0, 45.0, 50.0, 56.0, 63.0, 70.0, 80.0, 90.0, 100.0,
    110.0, 125.0, 140.0,
];
/// A rod is between these shares of its bore.
const RODS: std::ops::RangeInclusive<f64> = 0.4..=0.75;
/// The ratio is doubtful from this share off …
const OFF: f64 = 0.08;
/// … and from so many standard deviations.
const CLEARLY: f64 = 5.0;
/// A cylinder is tried if its ratio is within this share of what was found …
const NEAR: f64 = 0.08;
/// … and its bore within this factor of the file's; most that are tried.
const BORE_WITHIN: f64 = 1.7;
const MOST_TRIED: usize = 5;
/// The velocity is taken over this time, s.
const SLOPE_S: f64 = 0.04;
/// Friction of good seals and what the regression misses, as shares of the supply pressure on the piston.
const FRICTION: f64 = 0.02;
const MISSED: f64 = 0.01;
/// Rows for each independent one: what the regression misses lasts.
const ROWS_EACH: f64 = 25.0;

/// Changes to try, the nearest cylinder first, and the signals that raise the doubt.
pub(super) fn changes(machine: &Machine<f64>, recording: &Recording) -> (Vec<Vec<Change>>, Vec<Signal>) {
    let none = (Vec::new(), Vec::new());
    if !has_areas(machine) {
        return none;
    }
    let stated = machine.get(Parameter::AreaB) / machine.get(Parameter::AreaA);
    let Some((ratio, std)) = ratio(machine, recording) else { return none };
    let is_cylinder = (1.0 - RODS.end().powi(2) - NEAR..1.0).contains(&ratio);
    if !is_cylinder || (ratio / stated - 1.0).abs() < OFF || (ratio - stated).abs() < CLEARLY * std {
        return none;
    }
    (of_ratio(machine, ratio), vec![Signal::PressureA, Signal::PressureB])
}

/// Cylinders of another size with the same ratio, where both pressures are recorded: with them mass and flow tell the size.
pub(super) fn of_other_size(machine: &Machine<f64>, recordings: &[&Recording]) -> (Vec<Vec<Change>>, Vec<Signal>) {
    let signals = vec![Signal::PressureA, Signal::PressureB];
    let are_recorded = |recording: &&Recording| signals.iter().all(|signal| recording.has(*signal));
    if !has_areas(machine) || !recordings.iter().all(are_recorded) {
        return (Vec::new(), Vec::new());
    }
    (of_ratio(machine, machine.get(Parameter::AreaB) / machine.get(Parameter::AreaA)), signals)
}

/// A mass that a force moves has none, unless the pressures are that force.
fn has_areas(machine: &Machine<f64>) -> bool {
    machine.get(Parameter::AreaA).min(machine.get(Parameter::AreaB)) > 0.0
}

/// Cylinders with this ratio, the nearest to the file's first.
fn of_ratio(machine: &Machine<f64>, ratio: f64) -> Vec<Vec<Change>> {
    let stated_mm = 1e3 * (4.0 / std::f64::consts::PI * machine.get(Parameter::AreaA)).sqrt();
    let mut tried: Vec<(f64, Change)> = Vec::new();
    for bore_mm in
        BORES_MM.into_iter().filter(|bore_mm| (1.0 / BORE_WITHIN..=BORE_WITHIN).contains(&(bore_mm / stated_mm)))
    {
        for rod_mm in RODS_MM.into_iter().filter(|rod_mm| RODS.contains(&(rod_mm / bore_mm))) {
            let off = (1.0 - (rod_mm / bore_mm).powi(2)) / ratio - 1.0;
            if off.abs() < NEAR {
                tried.push((libm::log(bore_mm / stated_mm).abs() + off.abs(), Change::Cylinder { bore_mm, rod_mm }));
            }
        }
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    tried.into_iter().take(MOST_TRIED).map(|(_, change)| vec![change]).collect()
}

/// Ratio of the areas, B over A, with its standard deviation; `None` where both pressures and the position are not recorded, or do not tell.
fn ratio(machine: &Machine<f64>, recording: &Recording) -> Option<(f64, f64)> {
    let supply_pa = machine.get(Parameter::SupplyPressure);
    let [a, b] = [Signal::PressureA, Signal::PressureB].map(|signal| recording.signal(signal));
    let (a, b, position) = (a?, b?, recording.signal(Signal::Position)?);
    let reach = (rows_in(recording.time_s(), SLOPE_S) / 2).max(1);
    let velocity = slopes(recording.time_s(), position, reach);
    let acceleration = slopes(recording.time_s(), &velocity, reach);
    let most = |values: &[f64]| values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let (fastest, quickest) = (most(&velocity), most(&acceleration));
    if !(fastest > 0.0 && quickest > 0.0 && supply_pa > 0.0) {
        return None;
    }
    let mut matrix = Matrix5::<f64>::identity() * 1e-9;
    let mut told = Vector5::<f64>::zeros();
    let (mut square, mut rows) = (0.0, 0.0);
    for (((a, b), v), acceleration) in a.iter().zip(b).zip(&velocity).zip(&acceleration) {
        let slides = v / (v.abs() + 0.02 * fastest);
        let by = Vector5::new(b / supply_pa, 1.0, v / fastest, acceleration / quickest, slides);
        if !(by.iter().all(|value| value.is_finite()) && a.is_finite()) {
            continue;
        }
        let here = a / supply_pa;
        matrix += by * by.transpose();
        told += by * here;
        square += here * here;
        rows += 1.0;
    }
    matrix[(4, 4)] += rows * (MISSED / FRICTION).powi(2);
    let inverse = matrix.try_inverse()?;
    let found = inverse * told;
    let missed = ((square - found.dot(&told)) / f64::max(rows - 5.0, 1.0)).max(0.0);
    let std = (inverse[(0, 0)] * missed * ROWS_EACH).sqrt();
    (rows > 5.0 * ROWS_EACH && found[0].is_finite()).then_some((found[0], std))
}
