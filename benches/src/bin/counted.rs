//! The runs whose instructions `tests/instructions.rs` counts: `counted step-f64 TICKS`, `counted step-fixed TICKS`, `counted step-lanes TICKS`,
//! `counted refit FOLDER TIMES`.
//! Times 0 reads what a refit needs and does none, so that the difference of two runs is the refits alone.

use std::error::Error;
use std::path::Path;

use system_benches::refit::Refit;
use system_benches::run::{InLanes, Run, START_M, random_commands, staggered};

use model_core::number::{PerUnit, Scalar};
use simulation::number::simd::LANES;
use system_tests::drives;
use virtual_plant::InitialState;

fn step<N: Scalar<Real = f64>>(ticks: usize) -> f64 {
    let machine = drives::press();
    let run = Run::<N>::new(&machine, &InitialState::at_rest(&machine, START_M));
    let mut rows = Vec::new();
    run.any(&random_commands(ticks), &mut rows);
    rows.last().map_or(f64::NAN, |row| row[1])
}

fn step_in_lanes(ticks: usize) -> f64 {
    let machine = drives::press();
    let four = InLanes::new(&machine, &InitialState::at_rest(&machine, START_M));
    let volts = random_commands(2 * ticks);
    let mut rows = <[Vec<_>; LANES]>::default();
    four.any(staggered(&volts), &mut rows);
    rows[0].last().map_or(f64::NAN, |row| row[1])
}

fn refit(folder: &str, times: usize) -> Result<f64, Box<dyn Error>> {
    let refit = Refit::read(Path::new(folder))?;
    // The division of work must not depend on the number of threads.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut loss = 0.0;
    for _ in 0..times {
        let (fit, _) = pool.install(|| refit.run())?;
        loss += fit.loss;
    }
    Ok(loss)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match words.as_slice() {
        ["step-f64", ticks] => step::<f64>(ticks.parse()?),
        ["step-fixed", ticks] => step::<PerUnit>(ticks.parse()?),
        ["step-lanes", ticks] => step_in_lanes(ticks.parse()?),
        ["refit", folder, times] => refit(folder, times.parse()?)?,
        _ => return Err("expected step-f64 TICKS, step-fixed TICKS, step-lanes TICKS, or refit FOLDER TIMES".into()),
    };
    println!("{result}");
    Ok(())
}
