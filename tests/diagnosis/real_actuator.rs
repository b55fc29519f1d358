//! A robot arm's valve opening and oil pressure, measured by others: without units and without a clock, so only scale-free figures.

use std::fmt::Write;

use diagnosis::base_parameters;
use identification::experiment::Prepared;
use identification::fit::{From, fit};
use recording::{Recording, Signal, StaticTable, read_from};
use simulation::{Arithmetic, InputPoint, StartOffset, Stimulus, natural_tick};

use super::root;

/// RMSE of a linear ARX model in free run on the second half, in the pressure's own unit.
const LINEAR: f64 = 0.949;
/// The machine file's unit: one unit of p is 1 MPa.
const PRESSURE_PA: f64 = 1e6;

/// Rows of the table as a recording; a row counts as 10 ms.
fn recording(table: &StaticTable, map: &recording::ChannelMap, rows: std::ops::Range<usize>) -> Recording {
    let (u, p) = (table.column("u_valve").unwrap().1, table.column("p_oil_pressure").unwrap().1);
    let mut text = "time [s],u,p\n".to_owned();
    for row in rows {
        writeln!(text, "{},{},{}", 0.01 * row as f64, u[row], p[row]).unwrap();
    }
    read_from("actuator.csv", text.as_bytes(), map).unwrap()
}

#[test]
fn the_pressure_of_a_real_arm_is_followed_better_than_by_a_linear_model() {
    let Some(folder) = system_tests::at_hand::shared("data/actuator") else { return };
    let table = StaticTable::read(&folder.join("actuator.csv")).unwrap();
    let file = machine_file::read(&root().join("tests/diagnosis/actuator.toml")).unwrap();
    let half = table.rows() / 2;
    let first = recording(&table, &file.channels, 0..half);
    let prepared = Prepared::new(&first, &file.machine, file.load_source, None).unwrap();
    let fitted = fit(&file.machine, &base_parameters(&file), &[&prepared], &From::default(), 1e-8).unwrap();

    // Free run over all rows: no pressure of the second half was used, neither in the fit nor as its initial state.
    let whole = recording(&table, &file.channels, 0..table.rows());
    let tick = natural_tick(&whole);
    let stimulus = Stimulus::new(&whole, &fitted.machine, InputPoint::Command, file.load_source, tick).unwrap();
    let run = Arithmetic::Float.simulate(&fitted.machine, &stimulus, StartOffset::none()).unwrap();
    let (recorded, simulated) = (whole.signal(Signal::PressureA).unwrap(), run.signal(Signal::PressureA).unwrap());
    let rmse = |rows: std::ops::Range<usize>| {
        let count = rows.len() as f64;
        (rows.map(|row| ((recorded[row] - simulated[row]) / PRESSURE_PA).powi(2)).sum::<f64>() / count).sqrt()
    };
    let (train, test) = (rmse(0..half), rmse(half..table.rows()));
    println!("free run, units of p: first half {train:.3}, second half {test:.3}; linear {LINEAR} on the second half");
    assert!(test < 0.85 * LINEAR, "{test}");
    // The residual is not noise: the model is better than a linear one and far from complete.
    assert!(train > 0.3, "{train}");
}
