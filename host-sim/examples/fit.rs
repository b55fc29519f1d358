//! Fits a drive's uncertain parameters to its training recordings and prints each with its standard deviation.
//!
//! `cargo run -p host-sim --example fit [FOLDER]`; the folder holds `machine.toml` and `train-1.csv` to `train-4.csv`.

use std::error::Error;
use std::path::PathBuf;

use identification::experiment::Prepared;
use identification::fit::{From, effective_samples, fit, inflation, softened_all};
use recording::ChannelMap;

fn main() -> Result<(), Box<dyn Error>> {
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/press-63-40");
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| shipped.to_owned()));
    let drive = machine_file::read(&folder.join("machine.toml"))?;
    let mut prepared = Vec::new();
    for number in 1..=4 {
        let recording = recording::read(&folder.join(format!("train-{number}.csv")), &ChannelMap::default())?;
        prepared.push(Prepared::new(&recording, &drive.machine, drive.load_source, None)?);
    }

    let cases: Vec<&Prepared> = prepared.iter().collect();
    let found = fit(&drive.machine, &diagnosis::base_parameters(&drive), &cases, &From::default(), 1e-8)?;

    // Neighbouring residuals are correlated, which makes the standard deviations larger.
    let residuals = softened_all(&found.machine, cases.iter().copied().zip(found.starts.iter().copied()))?;
    for estimate in found.estimates(inflation(&residuals, effective_samples)) {
        let name = estimate.parameter.description().key;
        println!("{name:>32}: {:.5e} ± {:.1e}, before {:.5e}", estimate.value, estimate.std, estimate.before);
    }
    Ok(())
}
