//! Runs at a constant command are reduced to one row each.

use recording::StaticTable;
use simulation::signal::noise::extent;

use super::StaticsError;
use super::line::FittedLine;

/// The header of the velocity computed from a run's position, in the position's unit per second.
pub const VELOCITY: &str = "velocity";

/// The means of each run's columns, and the velocity from a column `position` where there is a clock. The rows are in the order
/// of the input, which must be constant in each run.
pub fn means(runs: &[StaticTable], input: &str) -> Result<StaticTable, StaticsError> {
    const CONSTANT: f64 = 0.01;
    let mut rows: Vec<(f64, Vec<f64>)> = Vec::new();
    let spread = |table: &StaticTable| -> Result<(f64, f64), StaticsError> { Ok(extent(table.column(input)?.1)) };
    let each = runs.iter().map(spread).collect::<Result<Vec<_>, _>>()?;
    let (low, high) = (
        each.iter().map(|(low, _)| *low).fold(f64::MAX, f64::min),
        each.iter().map(|(_, high)| *high).fold(f64::MIN, f64::max),
    );
    let headers: Vec<&str> =
        runs.first().map_or_else(Vec::new, |run| run.columns().iter().map(|(h, _)| h.as_str()).collect());
    let with_velocity = runs.iter().all(|run| run.clock_s().is_some() && run.column("position").is_ok());
    for (run, (from, to)) in runs.iter().zip(&each) {
        if to - from > CONSTANT * (high - low) {
            return Err(StaticsError::InputMoves {
                run: run.name().to_owned(),
                input: input.to_owned(),
                from: *from,
                to: *to,
            });
        }
        let mut row = Vec::new();
        for header in &headers {
            let values = run.column(header)?.1;
            row.push(values.iter().sum::<f64>() / values.len() as f64);
        }
        if let (true, Some(time_s)) = (with_velocity, run.clock_s()) {
            let points: Vec<(f64, f64)> = time_s.into_iter().zip(run.column("position")?.1.iter().copied()).collect();
            row.push(FittedLine::through(&points).map_or(f64::NAN, |line| line.slope));
        }
        rows.push((f64::midpoint(*from, *to), row));
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let names = headers.iter().map(|header| (*header).to_owned()).chain(with_velocity.then(|| VELOCITY.to_owned()));
    let columns = names.enumerate().map(|(index, name)| (name, rows.iter().map(|(_, row)| row[index]).collect()));
    Ok(StaticTable::new(&format!("{} runs", runs.len()), columns.collect()))
}
