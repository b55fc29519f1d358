//! Static recordings measured by others: a servo valve's sweeps without a clock, a crane valve's table and runs.

use std::path::{Path, PathBuf};

use identification::static_curve::{Cause, Columns, RateFrom, Shape, Statics, VELOCITY, analyse, compare, means};
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
    // One sweep without a clock: the loop may be a lag.
    assert!(names(&flow).is_empty() && flow.has_loop());

    let pressure = StaticTable::read(&folder.join("pressure_gain.csv")).unwrap();
    let pressure = of(&pressure, &columns("current_mA", "load_pressure_bar"));
    let null = pressure.null.unwrap();
    near(null.rising.unwrap(), 0.49, 0.03);
    near(null.falling.unwrap(), -0.39, 0.03);
    near(pressure.hysteresis.unwrap().width, 0.88, 0.05);
    assert!(names(&pressure).is_empty() && pressure.has_loop());
}

#[test]
fn a_servo_valves_leakage_is_a_peak_and_its_loop_a_lag() {
    let Some(folder) = folder("leakage") else { return };
    let read = |period: f64| {
        let table = StaticTable::read(&folder.join(format!("leak-period{period}.csv"))).unwrap();
        (of(&table, &columns("current_mA", "leakage_lpm")).with_period(period), period)
    };
    let sweeps = [20.0, 50.0, 200.0, 500.0].map(read);
    for (statics, _) in &sweeps {
        let peak = statics.shape.extreme().unwrap();
        assert!(matches!(statics.shape, Shape::Peak(_)) && names(statics).is_empty(), "{statics:?}");
        near(peak.input, 0.0, 0.2);
        assert!((statics.gain, statics.null, statics.positive) == (None, None, None), "{statics:?}");
    }
    let slowest = sweeps[3].0.shape.extreme().unwrap();
    near(slowest.output, 1.3, 0.05);
    near(slowest.lower_end, 0.67, 0.02);
    let timed = sweeps.each_ref().map(|(statics, period)| (statics, *period));
    let found = compare(&timed, RateFrom::Period);
    assert_eq!(found.cause, Cause::Lag, "{found:?}");
    assert!(found.indications().is_empty(), "{found:?}");
    let statics = sweeps.map(|(statics, _)| statics);
    println!("{}", report::statics::text_of_sweeps(&statics, &found));
    // The numbers of rows are no measure of the period here, and are not taken for one.
    let rows = statics.each_ref().map(|statics| (statics, statics.rows as f64));
    let supposed = compare(&rows, RateFrom::Rows);
    assert!(
        report::statics::text_of_sweeps(&statics, &supposed).contains("give --period")
            && supposed.indications().is_empty()
    );
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
    assert!(printed.contains("one sweep cannot tell") && printed.contains("no clock"), "{printed}");
    let read = |path: &Path| std::fs::read_to_string(path).unwrap();
    assert!(read(&json).contains("host-sim/statics/1") && read(&plot).starts_with("<svg"));
}
