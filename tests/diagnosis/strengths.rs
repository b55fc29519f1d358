//! How near the parameters of a named effect come to what was put in, effect by effect: found over put in, over drawn cases in which the
//! effect was named, as a snapshot beside this file (`RENEW=1` writes it anew).
//!
//! The test bed's effects have other forms than the hypotheses, so that most parameters are not the same number in both. The comparison uses
//! what both forms have: the amount itself, or the action of the effect at a stated point. Effects whose forms share no such number are
//! listed with the reason.

use std::collections::BTreeMap;
use std::f64::consts::SQRT_2;
use std::fmt::Write as _;

use rayon::prelude::*;

use diagnosis::catalogue::Hypothesis;
use model_core::machine::{Machine, Parameter as P};
use system_tests::snapshot;
use virtual_plant::concealed::{Concealed, Drawn, Lot, draw};
use virtual_plant::{
    FlowEffect, FrictionLevel, LoadEffect, MeasuredSignal, PlantEffect, SensingEffect, SyntheticRecording, ValveEffect,
};

use super::bed::{Case, accepted};

/// Cases drawn of each effect.
const CASES: u64 = 6;

/// What was put in and what was found, in the same unit.
struct Measured {
    what: &'static str,
    put_in: f64,
    found: f64,
}

/// Flow at an opening of 0.4 and half the supply, m³/s: where pressure losses of lines are compared.
fn usual_flow(machine: &Machine<f64>) -> f64 {
    0.4 * machine.get(P::FlowCoefficient) * (0.5 * machine.get(P::SupplyPressure)).sqrt()
}

/// The numbers that an effect of the test bed and the hypothesis of the same name have in common; none where their forms share none.
fn measured(truth: &PlantEffect, drawn: &Drawn, found: &Machine<f64>) -> Vec<Measured> {
    let get = |parameter| found.get(parameter);
    let of = |what, put_in, found| vec![Measured { what, put_in, found }];
    match *truth {
        PlantEffect::InternalLeakage { conductance_m3_per_s_pa, .. } => {
            of("conductance", conductance_m3_per_s_pa, get(P::InternalLeakage))
        }
        PlantEffect::ExternalLeakage { conductances_m3_per_s_pa: [a, b], .. } => {
            of("conductance of both", a + b, get(P::ExternalLeakageA) + get(P::ExternalLeakageB))
        }
        PlantEffect::EntrainedAir { share, .. } => of("share of air", share, get(P::AirShare)),
        PlantEffect::PositionDependentVolume => of("share of the displacement", 1.0, get(P::VolumeShare)),
        PlantEffect::HoseCompliance { compliance_m3_per_pa, .. } => {
            of("compliance", compliance_m3_per_pa, get(P::HoseCompliance))
        }
        PlantEffect::PumpSlip { conductance_m3_per_s_pa, .. } => {
            of("conductance", conductance_m3_per_s_pa, get(P::PumpSlip))
        }
        PlantEffect::Cavitation(bubbles) => {
            let tank_pa = drawn.file.machine.get(P::TankPressure);
            of("floor below the tank", tank_pa - bubbles.floor_pa, tank_pa - get(P::CavitationFloor))
        }
        PlantEffect::Valve(effect) => valve(effect, drawn, found),
        PlantEffect::Flow(effect) => flow(effect, drawn, found),
        PlantEffect::Friction(friction) => dry(friction.level, friction.stiffness_n_per_m, drawn, found),
        PlantEffect::Load(effect) => load(effect, drawn, found),
        PlantEffect::Sensing(effect) => sensing(effect, found),
        _ => Vec::new(),
    }
}

fn valve(effect: ValveEffect, drawn: &Drawn, found: &Machine<f64>) -> Vec<Measured> {
    let get = |parameter| found.get(parameter);
    let one = |what, put_in, found| Measured { what, put_in, found };
    match effect {
        ValveEffect::WeightedPlays { width } | ValveEffect::BoucWen { width, .. } => {
            vec![one("width", width, get(P::HysteresisWidth))]
        }
        ValveEffect::Stiction { break_away, kinetic_share, .. } => {
            let (band, kept) = (get(P::StictionBand), get(P::StictionKept));
            vec![one("band", break_away, band), one("jump", break_away * (1.0 - kinetic_share), band * (1.0 - kept))]
        }
        ValveEffect::FlowForce { closing_per_pa, .. } => vec![one("closing", closing_per_pa, get(P::FlowForce))],
        ValveEffect::NullDrift { travel, period_s } => {
            let end_s = of_all(drawn, |made| made.time_s.last().copied().into_iter().collect()).1;
            let turns = end_s / period_s;
            let put_in = travel * (turns + 0.25 * (std::f64::consts::TAU * turns).sin());
            let found = get(P::NullDriftTravel) * (1.0 - (-end_s / get(P::NullDriftTime)).exp());
            vec![one("drift at the end", put_in, found)]
        }
        ValveEffect::Saturation { ceiling } => {
            let (low, high) = of_all(drawn, |made| made.command_v.clone());
            let travel = get(P::ValveGain) * high.max(-low);
            let beyond = (travel - get(P::SolenoidOnset)).max(0.0);
            let kept = (1.0 - get(P::SolenoidLoss)) * beyond / (1.0 + get(P::SolenoidCurvature) * beyond);
            let lost = travel - ceiling * (travel / ceiling).tanh();
            vec![one("lost at full command", lost, beyond - kept)]
        }
    }
}

/// Openings between which a curved flow gain is compared.
const LITTLE: f64 = 0.05;
const FAR: f64 = 0.3;

fn flow(effect: FlowEffect, drawn: &Drawn, found: &Machine<f64>) -> Vec<Measured> {
    let get = |parameter| found.get(parameter);
    let of = |what, put_in, found| vec![Measured { what, put_in, found }];
    let flow = usual_flow(&drawn.file.machine);
    match effect {
        FlowEffect::DeadZone { extending, retracting } => {
            of("difference", extending - retracting, get(P::DeadZoneDifference))
        }
        FlowEffect::Metering { sizes: [supply_a, b_tank, supply_b, a_tank] } => {
            // Of the two ways in which unequal edges are drawn, the one with the larger difference is compared.
            let ratio = (b_tank * a_tank / (supply_a * supply_b)).sqrt();
            let ports = (b_tank * supply_b / (supply_a * a_tank)).sqrt();
            if ratio.ln().abs() > ports.ln().abs() {
                of("tank over supply edges", ratio, 1.0 + get(P::MeteringRatio))
            } else {
                of("edges of B over A", ports, 1.0 + get(P::MeteringPorts))
            }
        }
        FlowEffect::SupplyDroop { resistance_pa_s_per_m3, line_pa_s2_per_m6, .. } => {
            let put_in = resistance_pa_s_per_m3 * flow + line_pa_s2_per_m6 * flow * flow;
            of("fall at usual flow", put_in, get(P::DroopResistance) * flow)
        }
        FlowEffect::BackPressure { linear_pa_s_per_m3, quadratic_pa_s2_per_m6 } => {
            let drop = |linear: f64, quadratic: f64| linear * flow + quadratic * flow * flow;
            let put_in = drop(linear_pa_s_per_m3, quadratic_pa_s2_per_m6);
            of("drop at usual flow", put_in, drop(get(P::ReturnLaminar), get(P::ReturnResistance)))
        }
        FlowEffect::Leakage { opening, .. } => of("opening", opening, get(P::ValveLeakageOpening)),
        // A sharp edge and a rounded one agree far open: play²/2b more of the one is rounding²/4b more of the other.
        FlowEffect::RoundedEdges { play, .. } => of("rounding", SQRT_2 * play, get(P::EdgeRounding)),
        FlowEffect::LaminarTransition { pressure_pa } => of("pressure", pressure_pa, get(P::LaminarPressure)),
        FlowEffect::Gain(curve) => {
            // Flow per opening where the valve hardly opens, over that where it opens far.
            let curvature = |flow: &dyn Fn(f64) -> f64| flow(LITTLE) / LITTLE / (flow(FAR) / FAR) - 1.0;
            let (linear, beyond, notch) = (get(P::FlowGainLinear), get(P::FlowGainBeyond), get(P::FlowGainNotch));
            let found = |opening: f64| opening * (1.0 + linear * opening) + beyond * (opening - notch).max(0.0);
            of("curvature of the gain", curvature(&|opening| curve.shaped(opening)), curvature(&found))
        }
        // Not drawn here, or not in the catalogue.
        FlowEffect::Counterbalance(_) | FlowEffect::PumpRipple { .. } | FlowEffect::OtherConsumer { .. } => Vec::new(),
    }
}

fn load(effect: LoadEffect, drawn: &Drawn, found: &Machine<f64>) -> Vec<Measured> {
    let get = |parameter| found.get(parameter);
    let one = |what, put_in, found| vec![Measured { what, put_in, found }];
    let middle = 0.5 * get(P::Stroke);
    // A constant part of a force belongs to the load, which may change as well: only the variation of the force belongs to the effect.
    let spring = |y: f64| get(P::LoadSpring) * (y - middle) + get(P::LoadSpringBow) * (y - middle).powi(2);
    match effect {
        LoadEffect::EndStop { at_m, extending, .. } => {
            one("place", at_m, get(if extending { P::StopExtended } else { P::StopRetracted }))
        }
        LoadEffect::ProgressiveSpring { from_m, stiffness } => {
            let put_in = varies(drawn, |y| stiffness * (y - from_m).max(0.0).powf(1.5));
            one("how far it varies", put_in, varies(drawn, spring))
        }
        LoadEffect::Linkage { force_n, neutral_m, reach_m } => {
            let put_in = varies(drawn, |y| force_n * ((y - neutral_m) / reach_m).sin());
            one("how far it varies", put_in, varies(drawn, spring))
        }
        LoadEffect::NarrowBore { most_n_s_per_m, fits_at_m, width_m } => {
            let square = |y: f64| ((y - fits_at_m) / width_m).powi(2);
            let put_in = varies(drawn, |y| most_n_s_per_m * square(y) / (1.0 + square(y)));
            let (slope, bow) = (get(P::PositionDragSlope), get(P::PositionDragBow));
            let drag = |y: f64| get(P::ViscousFriction) * over_stroke(y, middle, slope, bow);
            one("how far the drag varies", put_in, varies(drawn, drag))
        }
        LoadEffect::HungMass { .. } => Vec::new(),
    }
}

/// What a slope and a bow add at a position: the slope at the ends of the stroke, the bow at both.
fn over_stroke(position_m: f64, middle_m: f64, slope: f64, bow: f64) -> f64 {
    let from_middle = (position_m - middle_m) / middle_m;
    slope * from_middle + bow * from_middle * from_middle
}

/// Variation over the recorded travel: the largest value less the smallest.
fn varies(drawn: &Drawn, of: impl Fn(f64) -> f64) -> f64 {
    const POINTS: u32 = 100;
    let (low, high) = of_all(drawn, |made| made.truth.iter().map(|state| state.position_m).collect());
    let values = (0..=POINTS).map(|point| of(low + (high - low) * f64::from(point) / f64::from(POINTS)));
    let (least, most) = values.fold((f64::MAX, f64::MIN), |all, value| (all.0.min(value), all.1.max(value)));
    most - least
}

/// The smallest and the largest of values of all recordings.
fn of_all(drawn: &Drawn, values: impl Fn(&SyntheticRecording) -> Vec<f64>) -> (f64, f64) {
    let all = drawn.recordings.iter().flat_map(|(_, made)| values(made));
    all.fold((f64::MAX, f64::MIN), |all, value| (all.0.min(value), all.1.max(value)))
}

fn dry(level: FrictionLevel, stiffness_n_per_m: f64, drawn: &Drawn, found: &Machine<f64>) -> Vec<Measured> {
    let get = |parameter| found.get(parameter);
    let one = |what, put_in, found| Measured { what, put_in, found };
    let placed =
        |y: f64| over_stroke(y, 0.5 * get(P::Stroke), get(P::PositionFrictionSlope), get(P::PositionFrictionBow));
    match level {
        FrictionLevel::Constant(force_n) => vec![one("force", force_n, get(P::CoulombFriction))],
        FrictionLevel::Stribeck { sliding_n, break_away_n, .. } => {
            let (force, excess) = (get(P::StribeckForce), get(P::StribeckExcess));
            vec![one("force at speed", sliding_n, force), one("force to break away", break_away_n, force + excess)]
        }
        FrictionLevel::Asymmetric { extending_n, retracting_n } => {
            let (extending, retracting) = (get(P::AsymmetricExtending), get(P::AsymmetricRetracting));
            vec![
                one("mean of both forces", 0.5 * (extending_n + retracting_n), 0.5 * (extending + retracting)),
                one("difference of both", extending_n - retracting_n, extending - retracting),
            ]
        }
        FrictionLevel::Slope { retracted_n, extended_n, stroke_m } => {
            let put_in = varies(drawn, |y| retracted_n + (extended_n - retracted_n) * y / stroke_m);
            vec![one("how far the force varies", put_in, varies(drawn, placed))]
        }
        FrictionLevel::Bump { rise_n, at_m, width_m, .. } => {
            let put_in = varies(drawn, |y| rise_n * (-((y - at_m) / width_m).powi(2)).exp());
            vec![one("how far the force varies", put_in, varies(drawn, placed))]
        }
        FrictionLevel::Presliding { sliding_n, .. } => vec![
            one("force", sliding_n, get(P::PreslidingForce)),
            one("stiffness", stiffness_n_per_m, get(P::PreslidingStiffness)),
        ],
        // The test bed's form depends mostly on the higher pressure, the hypothesis on the sum of both: at equal pressures they are the same.
        FrictionLevel::Pressure { area_m2, .. } => vec![one("area", area_m2, 2.0 * get(P::PressureFriction))],
    }
}

fn sensing(effect: SensingEffect, found: &Machine<f64>) -> Vec<Measured> {
    let of = |what, put_in, parameter| vec![Measured { what, put_in, found: found.get(parameter) }];
    let late_s = found.get(P::PositionLag) + found.get(P::PositionDelay);
    match effect {
        SensingEffect::Backlash { play_m } => of("play", play_m, P::BacklashPlay),
        SensingEffect::PositionDelay { delay_s } => vec![Measured { what: "time", put_in: delay_s, found: late_s }],
        SensingEffect::PositionFilter { frequency_hz, damping } => {
            // Delay of a slow motion.
            let put_in = damping / (std::f64::consts::PI * frequency_hz);
            vec![Measured { what: "time", put_in, found: late_s }]
        }
        SensingEffect::Offset { channel, offset } => match channel {
            MeasuredSignal::Spool => of("offset", offset, P::SpoolOffset),
            MeasuredSignal::PressureA => of("offset", offset, P::PressureAOffset),
            MeasuredSignal::PressureB => of("offset", offset, P::PressureBOffset),
            MeasuredSignal::Position => Vec::new(),
        },
        SensingEffect::Factor { channel, excess } => {
            let parameter = match channel {
                MeasuredSignal::Spool => P::SpoolFactor,
                MeasuredSignal::PressureA => P::PressureAFactor,
                MeasuredSignal::PressureB => P::PressureBFactor,
                MeasuredSignal::Position => P::PositionFactor,
            };
            of("factor's excess", excess, parameter)
        }
        SensingEffect::Flexibility { .. } => Vec::new(),
    }
}

/// Effects whose two forms have no number in common.
const OTHER_FORMS: [(&str, &str); 1] = [(
    "oil-temperature",
    "the test bed's oil warms by time and by the power that is lost, the hypothesis's by time alone, to an end",
)];

/// Cases of an effect: the measured numbers of those in which it alone was named, and how many were drawn.
fn cases(effect: &str) -> (Vec<Measured>, usize, usize) {
    let lot =
        Lot { seed: 301, concealed: Concealed::Single, hard: false, only: vec![effect.to_owned()], thermometer: false };
    let of = |index: u64| -> Option<Option<Vec<Measured>>> {
        let drawn = draw(&lot, index).unwrap()?;
        let found = Case::of(&drawn).diagnose();
        let all = || drawn.truth.forms.iter().flat_map(|form| measured(form, &drawn, &found.machine_after)).collect();
        Some((accepted(&found) == effect).then(all))
    };
    let all: Vec<Option<Vec<Measured>>> = (0..CASES).into_par_iter().filter_map(of).collect();
    let (drawn, named) = (all.len(), all.iter().flatten().count());
    (all.into_iter().flatten().flatten().collect(), named, drawn)
}

fn table(effects: &[&'static str]) -> String {
    let mut text = String::from(
        "effect                       named  what                      found over put in: median    worst   within 15 %\n",
    );
    // All at once: one case of an effect may take longer than all its others.
    let all: Vec<_> = effects.par_iter().map(|effect| (effect, cases(effect))).collect();
    for (effect, (measured, named, drawn)) in all {
        let mut by_what: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for one in measured {
            by_what.entry(one.what).or_default().push(one.found / one.put_in);
        }
        if by_what.is_empty() {
            let _ = writeln!(text, "{effect:<28} {named:>2}/{drawn}   no number in common");
        }
        for (what, mut ratios) in by_what {
            // The worst is the one furthest from 1, by its logarithm; one of the wrong sign is further than all.
            let off = |ratio: &f64| if *ratio > 0.0 { ratio.ln().abs() } else { f64::INFINITY };
            ratios.sort_by(f64::total_cmp);
            let middle = f64::midpoint(ratios[(ratios.len() - 1) / 2], ratios[ratios.len() / 2]);
            let worst = ratios.iter().copied().max_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(f64::NAN);
            let near = ratios.iter().filter(|ratio| (**ratio - 1.0).abs() <= 0.15).count();
            let _ = writeln!(
                text,
                "{effect:<28} {named:>2}/{drawn}   {what:<26} {middle:>24.3} {worst:>8.3}   {near:>4} of {}",
                ratios.len()
            );
        }
    }
    for (effect, why) in OTHER_FORMS {
        let _ = writeln!(text, "{effect}: {why}");
    }
    text
}

/// Slow: `cargo test --release -p system-tests --test diagnosis strengths_of -- --ignored --nocapture`.
#[test]
#[ignore = "some minutes"]
fn strengths_of_named_effects_are_as_near_as_the_table_says() {
    let effects: Vec<&'static str> =
        virtual_plant::concealed::VOCABULARY.iter().chain(&["hose-compliance"]).copied().collect();
    snapshot::compare("diagnosis/strengths.txt", &table(&effects), |found, kept| found == kept);
}

/// The reasons are given for existing effects only.
#[test]
fn every_effect_without_a_number_in_common_is_one_of_the_vocabulary() {
    let known: Vec<&str> = diagnosis::catalogue::CATALOGUE.iter().map(|effect: &&Hypothesis| effect.name).collect();
    assert!(OTHER_FORMS.iter().all(|(effect, _)| known.contains(effect)));
}
