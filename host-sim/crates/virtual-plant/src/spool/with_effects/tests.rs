//! What each valve effect does to the spool.

use super::*;
use crate::flow::edges::{GainCurve, SeriesLine};

const PARAMETERS: SpoolParameters = SpoolParameters {
    gain_per_v: 0.1,
    offset: 0.0,
    rate_per_s: 20.0,
    time_constants_s: [0.01, 0.015],
    delay_s: 0.004,
    swings: None,
    speed_per_s: f64::INFINITY,
};

fn edges() -> Edges {
    Edges {
        coefficient: 2e-7,
        dead_zone: [0.05; 2],
        transition_pa: 2e3,
        laminar_pa: 0.0,
        flow_limit: f64::INFINITY,
        gain: GainCurve::Proportional,
        sizes: [1.0; 4],
        supply_line: SeriesLine::default(),
        return_line: SeriesLine::default(),
    }
}

/// Spool positions at every millisecond for a command over time.
fn run(effects: &[ValveEffect], pressure_pa: f64, ticks: u32, command: impl Fn(f64) -> f64) -> Vec<f64> {
    run_of(PARAMETERS, effects, pressure_pa, ticks, command)
}

/// The same of another spool.
fn run_of(
    parameters: SpoolParameters,
    effects: &[ValveEffect],
    pressure_pa: f64,
    ticks: u32,
    command: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let state = State {
        pressure_a: 0.4 * pressure_pa,
        pressure_b: 0.4 * pressure_pa,
        velocity: 0.0,
        position: 0.1,
        supply: pressure_pa,
        port_a: 0.4 * pressure_pa,
        port_b: 0.4 * pressure_pa,
        viscosity: 1.0,
    };
    let mut spool = ShapedSpool::at_rest(parameters, effects, 0.0, command(0.0));
    let mut positions = Vec::new();
    for tick in 0..ticks {
        let time_s = f64::from(tick) * 1e-3;
        spool.command(time_s, command(time_s));
        positions.push(spool.position());
        let mut now_s = time_s;
        while now_s < f64::from(tick + 1) * 1e-3 {
            now_s = spool.curve_from(now_s, f64::from(tick + 1) * 1e-3, &edges(), &state).1;
        }
    }
    positions
}

fn sine(amplitude_v: f64, frequency_hz: f64) -> impl Fn(f64) -> f64 {
    move |time_s| amplitude_v * (std::f64::consts::TAU * frequency_hz * time_s).sin()
}

#[test]
fn without_effects_it_agrees_with_the_closed_form() {
    let command = |time_s: f64| if time_s < 0.05 { 3.0 } else { -4.0 };
    let positions = run(&[], 7e6, 200, command);
    let mut exact = Spool::at_rest(PARAMETERS, 0.0, 3.0);
    for (tick, found) in positions.iter().enumerate() {
        let time_s = tick as f64 * 1e-3;
        exact.command(time_s, command(time_s));
        let expected = exact.piece_from(time_s).0.position(time_s);
        assert!((found - expected).abs() < 1e-5, "{time_s}: {found} {expected}");
    }
}

#[test]
fn hysteresis_is_as_wide_as_said_at_any_rate() {
    for effect in [ValveEffect::WeightedPlays { width: 0.04 }, ValveEffect::BoucWen { width: 0.04, turning: 0.03 }] {
        for (period_s, ticks) in [(4.0, 5000), (40.0, 50_000)] {
            let command = sine(5.0, 1.0 / period_s);
            let positions = run(&[effect], 7e6, ticks, &command);
            let none = run(&[], 7e6, ticks, &command);
            // At the downward passage through zero and the next upward one; the run lasts a little longer than one period.
            let [half, whole] = [2, 4].map(|quarters| quarters * positions.len() / 5);
            let width = (positions[half] - none[half]) - (positions[whole] - none[whole]);
            assert!((width - 0.04).abs() < 2e-3, "{effect:?} {period_s}: {width}");
        }
    }
}

#[test]
fn a_sticking_spool_holds_and_jumps_short() {
    let effect = ValveEffect::Stiction { break_away: 0.02, kinetic_share: 0.15, jump_s: 1.5e-3 };
    let positions = run(&[effect], 7e6, 4000, |time_s| 0.5 * time_s);
    let held = positions.windows(2).filter(|pair| (pair[1] - pair[0]).abs() < 1e-12).count();
    assert!(held > 3500, "{held}");
    let jumps = positions.windows(6).filter(|six| six[5] - six[0] > 0.01 && six[0].total_cmp(&six[0]).is_eq()).count();
    assert!(jumps > 8, "{jumps}");
    // A commanded travel of 0.2, in jumps of 0.85 of the break-away: the spool is never further away than the break-away.
    for (tick, x) in positions.iter().enumerate() {
        let free = 0.1 * 0.5 * tick as f64 * 1e-3;
        assert!((free - x).abs() < 0.0225, "{tick}");
    }
}

#[test]
fn a_spool_that_jumps_at_once_makes_a_staircase_even_of_a_fast_ramp() {
    let effect = ValveEffect::Stiction { break_away: 0.02, kinetic_share: 0.25, jump_s: 0.0 };
    let positions = run(&[effect], 7e6, 200, |time_s| 20.0 * time_s);
    // 2 full travels per second: a jump of 0.015 every 7.5 ms.
    let jumps: Vec<f64> = positions.windows(2).map(|pair| pair[1] - pair[0]).filter(|jump| *jump > 0.0).collect();
    assert!((20..30).contains(&jumps.len()), "{}", jumps.len());
    assert!(jumps.iter().all(|jump| (jump - 0.015).abs() < 1e-3), "{jumps:?}");
}

/// Kinetic friction shifts what the spring pulls it to; it overshoots that, and rests where it would turn round, within the break-away of its target.
#[test]
fn a_spool_on_a_spring_that_sticks_slides_until_it_would_turn_round() {
    let (omega, zeta) = (250.0_f64, 0.5_f64);
    let swings = Some(Swings { pull_per_s2: omega * omega, drag_per_s: 2.0 * zeta * omega, pulled: 1.0 });
    let parameters = SpoolParameters { swings, rate_per_s: f64::INFINITY, delay_s: 0.0, ..PARAMETERS };
    let effect = ValveEffect::Stiction { break_away: 0.1, kinetic_share: 0.4, jump_s: 0.0 };
    let stepped =
        |volts: f64| run_of(parameters, &[effect], 0.0, 200, |time_s| if time_s > 5e-4 { volts } else { 0.0 });
    let positions = stepped(2.0);
    let root = (1.0 - zeta * zeta).sqrt();
    let furthest = 0.16 * (1.0 + (-std::f64::consts::PI * zeta / root).exp());
    assert!((positions[100] - furthest).abs() < 1e-3, "{} {furthest}", positions[100]);
    assert!(positions[100..].iter().all(|x| x.to_bits() == positions[100].to_bits()), "it rests");
    assert!(stepped(0.99).iter().all(|x| *x == 0.0), "it is held");
}

#[test]
fn the_neutral_drifts_and_the_solenoid_saturates() {
    let drift = run(&[ValveEffect::NullDrift { travel: 0.02, period_s: 2.0 }], 7e6, 2001, |_| 1.0);
    assert!((drift[0] - 0.1).abs() < 1e-12 && (drift[2000] - 0.12).abs() < 1e-3);
    let saturated =
        run(&[ValveEffect::Saturation { ceiling: 0.6 }], 7e6, 500, |time_s| if time_s > 0.1 { 10.0 } else { 0.5 });
    assert!((saturated[100] - 0.05).abs() < 2e-4, "small commands pass");
    assert!((saturated[499] - 0.6 * (1.0_f64 / 0.6).tanh()).abs() < 1e-4);
}

#[test]
fn flow_closes_the_spool_in_proportion_to_the_pressure() {
    let effect = ValveEffect::FlowForce { closing_per_pa: 1e-8, braking_s_per_root_pa: 1e-6 };
    let step = |time_s: f64| if time_s > 0.01 { 5.0 } else { 0.0 };
    let [none, half, full] = [0.0, 5e6, 10e6].map(|pressure_pa| run(&[effect], pressure_pa, 600, step)[599]);
    assert!((none - 0.5).abs() < 1e-5);
    // x = 0.5 − c·Δp·(x − 0.05)
    let expected = |across: f64| (0.5 + 1e-8 * across * 0.05) / (1.0 + 1e-8 * across);
    assert!((half - expected(5e6)).abs() < 1e-4 && (full - expected(10e6)).abs() < 1e-4);
    let braked = run(&[effect], 10e6, 60, step)[40];
    let free = run(&[], 10e6, 60, step)[40];
    assert!(braked < free);
}

/// A mass on a spring whose step response is known: overshoot e^(−πζ/√(1 − ζ²)) at π/(ω·√(1 − ζ²)).
#[test]
fn a_spool_on_a_spring_overshoots_as_the_textbook_says() {
    let (omega, zeta) = (250.0_f64, 0.5_f64);
    let swings = Some(Swings { pull_per_s2: omega * omega, drag_per_s: 2.0 * zeta * omega, pulled: 1.0 });
    let parameters = SpoolParameters { swings, rate_per_s: f64::INFINITY, delay_s: 0.0, ..PARAMETERS };
    let positions = run_of(parameters, &[], 7e6, 60, |time_s| if time_s > 5e-4 { 1.0 } else { 0.0 });
    let highest = positions.iter().copied().fold(0.0, f64::max);
    assert!((highest / 0.1 - 1.163).abs() < 2e-3, "{highest}");
    assert!((positions[59] / 0.1 - 1.0).abs() < 2e-3);
}

#[test]
fn the_spool_moves_no_faster_than_its_own_limit_and_then_arrives() {
    let driven = |pulled| Some(Swings { pull_per_s2: 9e4, drag_per_s: 400.0, pulled });
    for swings in [None, driven(1.0), driven(3.0)] {
        let parameters = SpoolParameters { swings, speed_per_s: 5.0, rate_per_s: f64::INFINITY, ..PARAMETERS };
        let positions = run_of(parameters, &[], 7e6, 300, |time_s| if time_s > 5e-4 { 6.0 } else { 0.0 });
        let fastest = positions.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        assert!((fastest - 5e-3).abs() < 1e-5, "{fastest}");
        assert!((positions[299] - 0.6).abs() < 1e-4, "{}", positions[299]);
    }
}
