//! Static recordings measured by others: a servo valve's sweeps without a clock, a crane valve's table and runs.

use std::path::{Path, PathBuf};

use identification::static_curve::{Columns, Statics, VELOCITY, analyse, means};
use recording::StaticTable;

use super::{done, text};

fn folder(part: &str) -> Option<PathBuf> {
    system_tests::at_hand::shared(&format!("data/{part}"))
}

fn columns(input: &str, output: &str) -> Columns {
    Columns { input: input.to_owned(), output: output.to_owned(), ..Columns::default() }
}

/// The figures, printed.
fn of(table: &StaticTable, columns: &Columns) -> Statics {
    let found = analyse(table, columns).unwrap();
    println!("{}\n", report::statics::text(&found));
    found
}

fn names(statics: &Statics) -> Vec<&'static str> {
    statics.indications.iter().map(|indication| indication.effect).collect()
}

fn near(found: f64, expected: f64, within: f64) {
    assert!((found - expected).abs() < within, "{found} is not within {within} of {expected}");
}

#[test]
fn a_servo_valves_loop_and_null_are_found_and_the_meters_staircase_is_not_physics() {
    let Some(folder) = folder("servovalve") else { return };
    let flow = StaticTable::read(&folder.join("flow_gain.csv")).unwrap();
    let flow = of(&flow, &columns("current_mA", "flow_lpm"));
    // 0.1 gal/min is the resolution of the meter's coarse range.
    near(flow.staircase.unwrap().step, 0.3785, 1e-3);
    assert!(flow.jumps.iter().any(|jump| (jump.input + 5.0).abs() < 0.3), "{:?}", flow.jumps);
    near(flow.hysteresis.unwrap().width, 0.5, 0.1);
    near(flow.null.unwrap().input, 0.0, 0.2);
    assert_eq!(names(&flow), ["valve-hysteresis"]);

    let pressure = StaticTable::read(&folder.join("pressure_gain.csv")).unwrap();
    let pressure = of(&pressure, &columns("current_mA", "load_pressure_bar"));
    let null = pressure.null.unwrap();
    near(null.rising.unwrap(), 0.49, 0.03);
    near(null.falling.unwrap(), -0.39, 0.03);
    near(pressure.hysteresis.unwrap().width, 0.88, 0.05);
    assert_eq!(names(&pressure), ["valve-hysteresis"]);
}

#[test]
fn a_crane_valves_table_shows_dead_zone_saturation_droop_and_return_pressure() {
    let Some(folder) = folder("redcrane") else { return };
    let table = StaticTable::read(&folder.join("jib_up_150bar.csv")).unwrap();
    let asked = Columns {
        spool: Some("uV_sensor".to_owned()),
        supply: Some("ps_bar".to_owned()),
        returning: Some("pb_bar".to_owned()),
        ..columns("u_percent", "xdot_mps")
    };
    let found = of(&table, &asked);
    let (rest, first) = found.positive.unwrap().begins_between.unwrap();
    assert!((23.0..=23.6).contains(&rest) && (23.4..=24.0).contains(&first), "{rest} {first}");
    let lost = found.saturation.iter().find(|fallen| fallen.share < 0.2).unwrap();
    near(lost.from, 95.0, 0.1);
    let (supply, returning) = (found.supply.as_ref().unwrap(), found.returning.as_ref().unwrap());
    // 149.4 bar in most rows; the rows of 21-24 % were taken at 4 bar more.
    near(supply.at_rest, 149.4, 2.0);
    near(supply.at_full, 138.4, 1.0);
    near(returning.at_full, 13.5, 1.0);
    assert_eq!(names(&found), ["solenoid-saturation", "flow-gain-nonlinearity", "supply-droop", "tank-back-pressure"]);
    of(&table, &Columns { spool: asked.spool.clone(), ..columns("u_percent", "Kv_Lmin_sqrtbar") });
}

#[test]
fn a_crane_valves_runs_show_dead_zone_droop_and_return_pressure() {
    let Some(folder) = folder("redcrane/runs") else { return };
    let read = |share: u32| StaticTable::read(&folder.join(format!("jib-up-120bar-{share}.csv"))).unwrap();
    let table = means(&[10, 30, 40, 50, 70, 100].map(read), "command_5v_centre").unwrap();
    let asked = Columns {
        supply: Some("supply_pressure".to_owned()),
        returning: Some("pressure_b".to_owned()),
        ..columns("command_5v_centre", VELOCITY)
    };
    let found = of(&table, &asked);
    // 25 % of 5 V beside the centre; at 23.4 % the spool begins to creep.
    near(found.positive.unwrap().extrapolated, 6.25, 0.1);
    let (supply, returning) = (found.supply.as_ref().unwrap(), found.returning.as_ref().unwrap());
    near(supply.at_rest, 123.8, 0.5);
    near(supply.at_full, 118.2, 0.5);
    near(returning.at_full, 9.6, 0.5);
    assert_eq!(names(&found), ["flow-gain-nonlinearity", "supply-droop", "tank-back-pressure"]);
}

#[test]
fn the_command_writes_what_it_prints() {
    let Some(folder) = folder("servovalve") else { return };
    let sweep = folder.join("flow_gain.csv");
    let out = tempfile::tempdir().unwrap();
    let [json, plot] = ["s.json", "s.svg"].map(|name| out.path().join(name));
    let arguments = ["--input", "current_mA", "--output", "flow_lpm", "--json", text(&json), "--plot", text(&plot)];
    let printed = done(&[["statics", "--recording", text(&sweep)].as_slice(), &arguments].concat());
    assert!(printed.contains("valve-hysteresis") && printed.contains("no clock"), "{printed}");
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    assert!(read(&json).contains("host-sim/statics/1") && read(&plot).starts_with("<svg"));
}
