//! The plant compared with an independent solution, and with itself at another tolerance.

use model_core::machine::Parameter::{self, *};
use model_core::machine::{Machine, Source};
use recording::excitation::signals::Excitation;

use crate::effect::PlantEffect;
use crate::excitation::input::Commands;
use crate::plant::{InitialState, Plant, PlantState};

/// The paper's printed values; a cylinder with softer oil columns; the same with a heavy, lightly
/// damped load.
pub(crate) fn printed() -> Machine<f64> {
    let mut machine = Machine::with_defaults(Source::Valve);
    for (parameter, value) in [
        (SupplyPressure, 7.0e6),
        (FlowLimit, 3.0e-4),
        (ValveGain, 0.0559),
        (ValveOffset, 0.0345),
        (DeadZone, 0.105),
        (RateLimit, 12.0),
        (TimeConstant1, 0.018),
        (TimeConstant2, 0.0279),
        (TransportDelay, 0.007),
        (FlowCoefficient, 2.4e-7),
        (LaminarTransition, 2.0e3),
        (AreaA, 3.117e-3),
        (AreaB, 1.861e-3),
        (BulkModulus, 1.2e9),
        (VolumeA, 1.2e9 / 9.63e12),
        (VolumeB, 1.2e9 / 1.28e12),
        (MovingMass, 18.3),
        (ViscousFriction, 1.0e5),
    ] {
        machine.set(parameter, value);
    }
    machine
}

pub(crate) fn press() -> Machine<f64> {
    let mut machine = printed();
    machine.set(VolumeA, 1.2e9 / 2.3e12);
    machine.set(VolumeB, 1.2e9 / 3.6e12);
    machine
}

pub(crate) fn heavy() -> Machine<f64> {
    let mut machine = press();
    machine.set(MovingMass, 200.0);
    machine.set(ViscousFriction, 5.0e3);
    machine
}

/// Classical RK4 with substeps of `h`, states r-lag, x, pa, pb, v, y, all equations written out.
fn reference(machine: &Machine<f64>, volts: &[f64], tick_s: f64, substeps: u32) -> Vec<[f64; 4]> {
    let p = |parameter: Parameter| machine.get(parameter);
    let (gain, offset, rate, delay) = (p(ValveGain), p(ValveOffset), p(RateLimit), p(TransportDelay));
    let target = |k: usize| gain * volts[k] + offset;
    let mut limited = vec![target(0)];
    for k in 1..volts.len() {
        let gap = target(k - 1) - limited[k - 1];
        limited.push(limited[k - 1] + gap.clamp(-rate * tick_s, rate * tick_s));
    }
    let r = |time: f64| {
        let time = time - delay;
        if time <= 0.0 {
            return target(0);
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a tick's number")]
        let k = ((time / tick_s) as usize).min(volts.len() - 1);
        let reach = (rate * (time - k as f64 * tick_s)).max(0.0);
        limited[k] + (target(k) - limited[k]).clamp(-reach, reach)
    };
    let root = |d: f64| d / (d * d + p(LaminarTransition).powi(2)).powf(0.25);
    let slope = |time: f64, s: &[f64; 6]| {
        let [lag, x, pa, pb, v, _] = *s;
        let p0 = p(SupplyPressure);
        let k = p(FlowCoefficient);
        let dz = p(DeadZone);
        let (qa, qb) = if x > dz {
            (k * (x - dz) * root(p0 - pa), k * (x - dz) * root(pb))
        } else if x < -dz {
            (k * (x + dz) * root(pa), k * (x + dz) * root(p0 - pb))
        } else {
            (0.0, 0.0)
        };
        let (qa, qb) = (qa.clamp(-p(FlowLimit), p(FlowLimit)), qb.clamp(-p(FlowLimit), p(FlowLimit)));
        let force = p(AreaA) * pa - p(AreaB) * pb - p(ViscousFriction) * v;
        [
            (r(time) - lag) / p(TimeConstant1),
            (lag - x) / p(TimeConstant2),
            p(BulkModulus) / p(VolumeA) * (qa - p(AreaA) * v),
            p(BulkModulus) / p(VolumeB) * (p(AreaB) * v - qb),
            force / p(MovingMass),
            v,
        ]
    };
    let start = InitialState::at_rest(machine, 0.15);
    let mut s = [target(0), target(0), start.pressure_a_pa, start.pressure_b_pa, 0.0, 0.15];
    let mut rows = Vec::new();
    let h = tick_s / f64::from(substeps);
    for tick in 0..volts.len() {
        rows.push([s[1], s[2], s[3], s[5]]);
        for sub in 0..substeps {
            let t = tick as f64 * tick_s + f64::from(sub) * h;
            let moved = |by: f64, k: &[f64; 6]| std::array::from_fn(|i| s[i] + by * k[i]);
            let k1 = slope(t, &s);
            let k2 = slope(t + 0.5 * h, &moved(0.5 * h, &k1));
            let k3 = slope(t + 0.5 * h, &moved(0.5 * h, &k2));
            let k4 = slope(t + h, &moved(h, &k3));
            s = std::array::from_fn(|i| s[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
    }
    rows
}

fn times(count: usize) -> Vec<f64> {
    (0..count).map(|k| k as f64 * 1e-3).collect()
}

/// Steps of both signs, small and large; one of them is too short for the ramp to reach its end.
fn steps(count: usize) -> Vec<f64> {
    let pattern = [(0, 0.0), (50, 4.0), (250, -9.5), (270, 7.0), (550, 0.0), (650, -3.0), (800, 2.3)];
    (0..count).map(|k| pattern.iter().rev().find(|entry| entry.0 <= k % 900).map_or(0.0, |entry| entry.1)).collect()
}

fn simulate(machine: &Machine<f64>, volts: &[f64], tolerance: f64) -> Vec<PlantState> {
    let plant = Plant::new(machine, tolerance).unwrap();
    let initial = InitialState::at_rest(machine, 0.15);
    plant.simulate(&Commands::Valve(volts.to_vec()), &initial, &times(volts.len())).unwrap()
}

/// Largest differences of spool, both pressures (in supply pressures) and position (in strokes).
fn distance(machine: &Machine<f64>, one: &[[f64; 4]], other: &[[f64; 4]]) -> [f64; 4] {
    assert_eq!(one.len(), other.len());
    let scale = [1.0, machine.get(SupplyPressure), machine.get(SupplyPressure), machine.get(Stroke)];
    let mut worst = [0.0_f64; 4];
    for (a, b) in one.iter().zip(other) {
        for i in 0..4 {
            worst[i] = worst[i].max((a[i] - b[i]).abs() / scale[i]);
        }
    }
    worst
}

fn rows(states: &[PlantState]) -> Vec<[f64; 4]> {
    states.iter().map(|s| [s.spool, s.pressure_a_pa, s.pressure_b_pa, s.position_m]).collect()
}

#[test]
fn the_plant_agrees_with_an_independent_runge_kutta_solution() {
    for (name, machine) in [("printed", printed()), ("press", press()), ("heavy", heavy())] {
        let volts = steps(900);
        let clock = std::time::Instant::now();
        let found = rows(&simulate(&machine, &volts, 1e-10));
        let took = clock.elapsed();
        let [x, pa, pb, y] = distance(&machine, &found, &reference(&machine, &volts, 1e-3, 1000));
        println!("{name}: x {x:.1e}, pa {pa:.1e}, pb {pb:.1e}, y {y:.1e} in {took:?}");
        assert!(x < 1e-8 && pa < 1e-6 && pb < 1e-6 && y < 1e-7, "{name}: {x:.1e} {pa:.1e} {pb:.1e} {y:.1e}");
    }
}

#[test]
fn the_solution_converges_with_the_tolerance() {
    for (name, machine) in [("printed", printed()), ("press", press()), ("heavy", heavy())] {
        let volts = steps(4000);
        let finest = rows(&simulate(&machine, &volts, 1e-12));
        for (tolerance, bound) in [(1e-7, 1e-6), (1e-8, 1e-7), (1e-10, 2e-9)] {
            let clock = std::time::Instant::now();
            let found = rows(&simulate(&machine, &volts, tolerance));
            let took = clock.elapsed();
            let [_, pa, pb, y] = distance(&machine, &finest, &found);
            println!("{name} at {tolerance:.0e}: pa {pa:.1e}, pb {pb:.1e}, y {y:.1e} in {took:?}");
            assert!(pa < bound && pb < bound && y < 0.1 * bound, "{name}: {pa:.1e} {pb:.1e} {y:.1e}");
        }
    }
}

/// Saturated flow, a spool that jumps, friction that sticks: kinks that are not announced to the
/// integrator.
#[test]
fn the_solution_converges_through_saturation_jumps_and_sticking() {
    let mut jumping = press();
    for (parameter, value) in [(RateLimit, f64::INFINITY), (TimeConstant1, 0.0), (TimeConstant2, 0.0)] {
        jumping.set(parameter, value);
    }
    let mut equal_lags = heavy();
    equal_lags.set(TimeConstant1, 0.0279);
    equal_lags.set(TransportDelay, 0.0123);
    let rich = [
        PlantEffect::coulomb_friction(900.0),
        PlantEffect::hose_compliance(2e-13),
        PlantEffect::internal_leakage(2e-12),
    ];
    for (name, machine) in [("printed", printed()), ("jumping", jumping), ("equal lags", equal_lags)] {
        for effects in [&[][..], &rich] {
            let volts = Excitation::random_steps(11).sample(1e-3);
            let run = |tolerance: f64| {
                let plant = Plant::new(&machine, tolerance).unwrap().with_effects(effects);
                let initial = InitialState::at_rest(&machine, 0.15);
                rows(&plant.simulate(&Commands::Valve(volts.clone()), &initial, &times(volts.len())).unwrap())
            };
            let finest = run(1e-12);
            for (tolerance, bound) in [(1e-7, 1e-5), (1e-10, 1e-8)] {
                let [_, pa, pb, y] = distance(&machine, &finest, &run(tolerance));
                let count = effects.len();
                println!("{name}, {count} effects at {tolerance:.0e}: pa {pa:.1e}, pb {pb:.1e}, y {y:.1e}");
                assert!(pa < bound && pb < bound && y < bound, "{name}: {pa:.1e} {pb:.1e} {y:.1e}");
            }
        }
    }
}
