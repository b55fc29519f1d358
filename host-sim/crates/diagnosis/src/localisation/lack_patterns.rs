//! The simple shapes that a lack in each link may have, and what wrong base parameters look like.

use simulation::signal::noise::extent;
use simulation::signal::slope::slopes;
use simulation::signal::window::{WINDOW_S, rows_in};

use super::balances::{Coefficients, Observed};
use super::link_evidence::Lack;
use crate::catalogue::Subsystem;

/// Usual relative error of a base parameter that was fitted to a model that lacks something.
const WRONG: f64 = 0.05;
/// Atmospheric pressure, Pa.
const ATMOSPHERE_PA: f64 = 1e5;

/// A usual error of each base parameter, expressed as a lack.
#[must_use]
pub(super) fn wrong_parameters(observed: &Observed, by: &Coefficients, supply_pa: f64) -> Vec<Lack> {
    let flows = &observed.flows;
    let each = |value: &dyn Fn(usize) -> f64| observed.each(value);
    let zeros = || vec![0.0; observed.rows()];
    let mut wrong = vec![
        // Flow coefficient, dead zone.
        Lack::Flow(each(&|row| WRONG * flows[row].a), each(&|row| WRONG * flows[row].b)),
        along_spool(observed, |row| -0.01 * observed.spool[row].signum()),
        // Capacities, load, and viscous friction if there is any.
        Lack::Stored(each(&|row| WRONG * by.capacity.0 * observed.pressure_a_pa[row]), zeros()),
        Lack::Stored(zeros(), each(&|row| WRONG * by.capacity.1 * observed.pressure_b_pa[row])),
        Lack::Force(vec![0.01 * supply_pa * by.area.0; observed.rows()]),
        Lack::Force(each(&|row| -WRONG * by.damping * observed.velocity_m_per_s[row])),
    ];
    if !observed.has_spool {
        wrong.push(along_spool(observed, |row| WRONG * observed.spool[row]));
        wrong.push(along_spool(observed, |_| 0.01));
        let slopes = rates(observed, &observed.spool);
        wrong.push(along_spool(observed, |row| -0.002 * slopes[row]));
    }
    wrong
}

/// The flows that an additional spool travel would add.
fn along_spool(observed: &Observed, travel: impl Fn(usize) -> f64) -> Lack {
    let flows = &observed.flows;
    Lack::Flow(
        observed.each(|row| flows[row].by_spool.0 * travel(row)),
        observed.each(|row| flows[row].by_spool.1 * travel(row)),
    )
}

/// Rate of change over a fifth of a window to both sides; its sign matters most.
fn rates(observed: &Observed, values: &[f64]) -> Vec<f64> {
    slopes(&observed.time_s, values, rows_in(&observed.time_s, 0.2 * WINDOW_S).max(1))
}

/// The largest magnitude of a series.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(f64::MIN_POSITIVE, |largest, value| largest.max(value.abs()))
}

/// Every shape of every link that these signals can show.
#[must_use]
pub(super) fn patterns(observed: &Observed, by: &Coefficients, stroke_m: f64) -> Vec<(Subsystem, Lack)> {
    let mut found = flow(observed);
    found.extend(chambers(observed, by, stroke_m));
    found.extend(mechanics(observed, stroke_m));
    found.extend(sensing(observed));
    if !observed.has_spool {
        found.extend(valve(observed));
    }
    found
}

fn flow(observed: &Observed) -> Vec<(Subsystem, Lack)> {
    let (flows, spool) = (&observed.flows, &observed.spool);
    let scaled = |by: &dyn Fn(usize) -> (f64, f64)| {
        Lack::Flow(observed.each(|row| flows[row].a * by(row).0), observed.each(|row| flows[row].b * by(row).1))
    };
    let extends = |row: usize| if spool[row] > 0.0 { 1.0 } else { 0.0 };
    let mut found = vec![
        // One side opens earlier; one of the two edges in series is larger; the gain depends on the opening.
        along_spool(observed, |_| 1.0),
        scaled(&|row| (1.0 - extends(row), extends(row))),
        scaled(&|row| (spool[row].abs(), spool[row].abs())),
        scaled(&|row| (spool[row].powi(2), spool[row].powi(2))),
    ];
    // A supply pressure that falls with the delivered flow, at once or with a lag, or as recorded; back-pressure of the return line.
    let delivered = observed.each(|row| if spool[row] > 0.0 { flows[row].a } else { -flows[row].b });
    let returned = observed.each(|row| if spool[row] > 0.0 { flows[row].b } else { -flows[row].a });
    let by_supply = |off: &[f64]| {
        Lack::Flow(
            observed.each(|row| flows[row].by_supply.0 * off[row]),
            observed.each(|row| flows[row].by_supply.1 * off[row]),
        )
    };
    found.push(by_supply(&delivered));
    for time_s in [0.05, 0.2, 1.0] {
        found.push(by_supply(&lagged(&observed.time_s, &delivered, time_s)));
    }
    if let Some(off) = &observed.supply_off_pa {
        found.push(by_supply(off));
    }
    found.push(Lack::Flow(
        observed.each(|row| flows[row].by_tank.0 * returned[row].powi(2)),
        observed.each(|row| flows[row].by_tank.1 * returned[row].powi(2)),
    ));
    // Both edges of a port pass a little near the neutral.
    let (a, b) = (&observed.pressure_a_pa, &observed.pressure_b_pa);
    let supply = largest(a).max(largest(b));
    let port = |pressure: f64| (supply - pressure).max(0.0).sqrt() - pressure.max(0.0).sqrt();
    for reach in [0.02, 0.05, 0.12] {
        let open = |row: usize| libm::exp(-(spool[row] / reach).powi(2));
        found.push(Lack::Flow(
            observed.each(|row| open(row) * port(a[row])),
            observed.each(|row| -open(row) * port(b[row])),
        ));
    }
    found.into_iter().map(|lack| (Subsystem::Flow, lack)).collect()
}

/// A first-order lag of a series.
fn lagged(time_s: &[f64], values: &[f64], lag_s: f64) -> Vec<f64> {
    let mut state = values.first().copied().unwrap_or(0.0);
    let mut before = time_s.first().copied().unwrap_or(0.0);
    time_s
        .iter()
        .zip(values)
        .map(|(time, value)| {
            state += (value - state) * (1.0 - libm::exp(-(time - before) / lag_s));
            before = *time;
            state
        })
        .collect()
}

fn chambers(observed: &Observed, by: &Coefficients, stroke_m: f64) -> Vec<(Subsystem, Lack)> {
    let (a, b, y) = (&observed.pressure_a_pa, &observed.pressure_b_pa, &observed.position_m);
    let zeros = || vec![0.0; observed.rows()];
    let past = observed.each(|row| b[row] - a[row]);
    let gas = |pressures: &[f64]| observed.each(|row| -ATMOSPHERE_PA / pressures[row].max(ATMOSPHERE_PA));
    let stepped = |pressures: &[f64], sign: f64| {
        // ∫(y − y_mid) dp: a volume that moves with the rod.
        let mut held = 0.0;
        observed
            .each(|row| row as f64)
            .iter()
            .enumerate()
            .map(|(row, _)| {
                if row > 0 {
                    let middle = f64::midpoint(y[row], y[row - 1]) - 0.5 * stroke_m;
                    held += sign * middle * (pressures[row] - pressures[row - 1]);
                }
                held
            })
            .collect::<Vec<f64>>()
    };
    let (area_a, area_b) = by.area;
    let ratio = by.capacity.1 / by.capacity.0;
    let scaled = |values: Vec<f64>, by: f64| values.into_iter().map(|value| by * value).collect::<Vec<f64>>();
    [
        Lack::Flow(past.clone(), past),
        Lack::Flow(observed.each(|row| -a[row]), zeros()),
        Lack::Flow(zeros(), b.clone()),
        Lack::Stored(gas(a), scaled(gas(b), ratio)),
        Lack::Stored(stepped(a, area_a), stepped(b, -area_b)),
    ]
    .into_iter()
    .map(|lack| (Subsystem::Chambers, lack))
    .collect()
}

fn mechanics(observed: &Observed, stroke_m: f64) -> Vec<(Subsystem, Lack)> {
    let (v, y) = (&observed.velocity_m_per_s, &observed.position_m);
    let (a, b) = (&observed.pressure_a_pa, &observed.pressure_b_pa);
    let fastest = largest(v);
    // Sign of the velocity, smoothed near zero, where it is not known.
    let sense = |row: usize| libm::tanh(v[row] / (0.01 * fastest));
    let middle = |row: usize| y[row] / stroke_m - 0.5;
    let mut found = vec![
        observed.each(|row| -sense(row)),
        observed.each(|row| -sense(row).abs()),
        observed.each(|row| -sense(row) * middle(row)),
        observed.each(|row| -sense(row) * middle(row).powi(2)),
        observed.each(|row| -sense(row) * (a[row] + b[row])),
        observed.each(|row| -v[row] * v[row].abs()),
        observed.each(middle),
        observed.each(|row| middle(row).powi(2)),
        observed.each(|row| middle(row).powi(3)),
    ];
    for share in [0.03, 0.1, 0.3] {
        found.push(observed.each(|row| -sense(row) * libm::exp(-v[row].abs() / (share * fastest))));
    }
    let (low, high) = extent(y);
    for share in [0.02, 0.06] {
        let depth = share * (high - low);
        found.push(observed.each(|row| (y[row] - high + depth).max(0.0)));
        found.push(observed.each(|row| (low + depth - y[row]).max(0.0)));
    }
    found.into_iter().map(|force| (Subsystem::Mechanics, Lack::Force(force))).collect()
}

fn sensing(observed: &Observed) -> Vec<(Subsystem, Lack)> {
    let (v, y) = (&observed.velocity_m_per_s, &observed.position_m);
    let mut found = vec![observed.each(|row| -v[row])];
    for time_s in [0.01, 0.03] {
        let late = lagged(&observed.time_s, y, time_s);
        found.push(observed.each(|row| late[row] - y[row]));
    }
    for play_m in [1e-4, 2e-4, 4e-4, 8e-4, 1.6e-3] {
        let mut held = y[0];
        let followed: Vec<f64> = y
            .iter()
            .map(|y| {
                held = held.clamp(y - 0.5 * play_m, y + 0.5 * play_m);
                held - y
            })
            .collect();
        found.push(followed);
    }
    found.into_iter().map(|error| (Subsystem::Sensing, Lack::Position(error))).collect()
}

fn valve(observed: &Observed) -> Vec<(Subsystem, Lack)> {
    let (x, flows) = (&observed.spool, &observed.flows);
    let turning = rates(observed, x);
    let fastest = largest(&turning);
    let (mut high, mut low) = (Vec::new(), Vec::new());
    for width in [0.01, 0.03] {
        let mut held = x[0];
        let series: Vec<f64> = x
            .iter()
            .map(|x| {
                held = held.clamp(x - 0.5 * width, x + 0.5 * width);
                held - x
            })
            .collect();
        if width > 0.02 { high = series } else { low = series }
    }
    let began = observed.time_s[0];
    let across = |row: usize| flows[row].a.abs() + flows[row].b.abs();
    vec![
        along_spool(observed, |row| high[row]),
        along_spool(observed, |row| low[row]),
        along_spool(observed, |row| -libm::tanh(turning[row] / (0.05 * fastest))),
        along_spool(observed, |row| observed.time_s[row] - began),
        along_spool(observed, |row| -x[row].powi(3)),
        along_spool(observed, |row| -(x[row].abs() - 0.5 * largest(x)).max(0.0) * x[row].signum()),
        along_spool(observed, |row| -x[row].signum() * across(row)),
    ]
    .into_iter()
    .map(|lack| (Subsystem::Valve, lack))
    .collect()
}
