//! What is found on known characteristics.

mod draws;
mod kinds;
mod rates;

use super::*;

/// A triangle of −10 … 10, twice.
fn triangle() -> Vec<f64> {
    (0..4000).map(|row: i32| 10.0 - 0.02 * f64::from((row.rem_euclid(2000) - 1000).abs())).collect()
}

fn columns() -> Columns {
    Columns { input: "I".to_owned(), output: "Q".to_owned(), ..Columns::default() }
}

fn table(input: Vec<f64>, output: Vec<f64>) -> StaticTable {
    StaticTable::new("sweep.csv", vec![("I [mA]".to_owned(), input), ("Q [l/min]".to_owned(), output)])
}

/// The output of a backlash of this width, followed by a dead zone, gain and saturation.
fn valve(width: f64, dead_zone: f64, full: f64) -> StaticTable {
    let input = triangle();
    let mut spool = input[0];
    let output = input
        .iter()
        .map(|value| {
            spool = spool.clamp(value - 0.5 * width, value + 0.5 * width);
            let open = (spool - 0.4).abs() - dead_zone;
            (spool - 0.4).signum() * (2.0 * open.max(0.0)).min(full)
        })
        .collect();
    table(input, output)
}

fn names(statics: &Statics) -> Vec<&'static str> {
    statics.indications.iter().map(|indication| indication.effect).collect()
}

#[test]
fn width_null_and_dead_zone_of_a_known_valve_are_found() {
    let found = analyse(&valve(0.6, 1.0, f64::INFINITY), &columns()).unwrap();
    let hysteresis = found.hysteresis.unwrap();
    assert!((hysteresis.width - 0.6).abs() < 0.03 && hysteresis.std < 0.03, "{hysteresis:?}");
    let null = found.null.unwrap();
    assert!((null.input - 0.4).abs() < 0.03 && (null.rising.unwrap() - 0.7).abs() < 0.05, "{null:?}");
    assert!((found.positive.unwrap().extrapolated - 1.4).abs() < 0.05, "{found:?}");
    assert!((found.negative.unwrap().extrapolated + 0.6).abs() < 0.05, "{found:?}");
    assert!(found.staircase.is_none() && found.jumps.is_empty() && found.saturation.is_empty(), "{found:?}");
    assert!(names(&found).is_empty() && found.has_loop(), "one sweep does not tell hysteresis from a lag: {found:?}");
    assert!(found.remarks.contains(&Remark::LagOrLoop { lag_s: None }), "{found:?}");
}

#[test]
fn a_valve_without_play_shows_no_hysteresis_and_a_saturation_shows() {
    let straight = analyse(&valve(0.0, 0.0, f64::INFINITY), &columns()).unwrap();
    assert!(names(&straight).is_empty(), "{straight:?}");
    let bounded = analyse(&valve(0.0, 0.0, 14.0), &columns()).unwrap();
    assert!(bounded.saturation.iter().any(|fallen| fallen.upper && (fallen.from - 7.4).abs() < 1.1), "{bounded:?}");
    assert_eq!(names(&bounded), ["flow-gain-nonlinearity"]);
}

#[test]
fn a_meters_staircase_does_not_become_physics() {
    let smooth = valve(0.6, 0.0, f64::INFINITY);
    let meter = |value: &f64| if value.abs() > 6.0 { (value / 0.8).round() * 0.8 } else { *value };
    let output = smooth.columns()[1].1.iter().map(meter).collect();
    let found = analyse(&table(triangle(), output), &columns()).unwrap();
    assert!((found.staircase.unwrap().step - 0.8).abs() < 1e-6, "{found:?}");
    assert!((found.hysteresis.unwrap().width - 0.6).abs() < 0.05, "{found:?}");
    assert!(names(&found).is_empty() && found.has_loop(), "{found:?}");
    assert!(found.remarks.iter().any(|remark| matches!(remark, Remark::Staircase(_))), "{found:?}");
}

#[test]
fn droop_and_return_pressure_are_read_over_the_flow() {
    let command: Vec<f64> = (0..20).map(|row| 5.0 * f64::from(row)).collect();
    let flow: Vec<f64> = command.iter().map(|u| (u - 20.0).max(0.0)).collect();
    let supply = flow.iter().map(|flow| 150.0 - 0.1 * flow).collect();
    let returning = flow.iter().map(|flow| if *flow > 0.0 { 1.0 + 0.2 * flow } else { 60.0 }).collect();
    let named = |name: &str, values: Vec<f64>| (name.to_owned(), values);
    let table = StaticTable::new(
        "t.csv",
        vec![named("I", command), named("Q", flow), named("ps", supply), named("pb", returning)],
    );
    let columns = Columns { supply: Some("ps".into()), returning: Some("pb".into()), ..columns() };
    let found = analyse(&table, &columns).unwrap();
    assert_eq!(names(&found), ["supply-droop", "tank-back-pressure"]);
    let port = found.returning.unwrap();
    assert!((port.at_rest - 1.0).abs() < 1e-6 && (port.at_full - 16.0).abs() < 1e-6, "{port:?}");
    let edge = found.positive.unwrap();
    assert!((edge.extrapolated - 20.0).abs() < 1e-6 && edge.begins_between == Some((20.0, 25.0)), "{edge:?}");
}

#[test]
fn runs_at_constant_command_become_rows_and_others_are_refused() {
    let run = |command: f64, speed: f64| {
        let time: Vec<f64> = (0..50).map(|row| 10.0 * f64::from(row)).collect();
        let position = time.iter().map(|time| 0.1 + speed * 1e-3 * time).collect();
        let named = |name: &str, values: Vec<f64>| (name.to_owned(), values);
        StaticTable::new(
            "run.csv",
            vec![named("time [ms]", time), named("U [V]", vec![command; 50]), named("position [m]", position)],
        )
    };
    let table = means(&[run(7.0, 0.02), run(6.0, 0.01)], "U").unwrap();
    let velocity = table.column(VELOCITY).unwrap().1;
    assert!((velocity[0] - 0.01).abs() < 1e-12 && (velocity[1] - 0.02).abs() < 1e-12, "{velocity:?}");
    let mut moving = run(6.0, 0.0);
    moving = StaticTable::new(
        "m.csv",
        moving
            .columns()
            .iter()
            .map(|(h, v)| (h.clone(), v.iter().enumerate().map(|(i, v)| v + i as f64).collect()))
            .collect(),
    );
    assert!(means(&[run(7.0, 0.0), moving], "U").unwrap_err().to_string().contains("constant command"));
    assert!(analyse(&table, &columns()).unwrap_err().to_string().contains("at least 5"));
}
