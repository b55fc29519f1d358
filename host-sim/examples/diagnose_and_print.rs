//! Diagnoses a drive and prints what its model leaves out.
//!
//! `cargo run -p host-sim --example diagnose_and_print [FOLDER]`; the folder holds `machine.toml`, `train-1.csv` to `train-4.csv` and
//! `holdout-1.csv` and `holdout-2.csv`.

use std::error::Error;
use std::path::PathBuf;

use diagnosis::diagnose;
use recording::{ChannelMap, Recording, RecordingError};

fn main() -> Result<(), Box<dyn Error>> {
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/press-63-40");
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| shipped.to_owned()));
    let drive = machine_file::read(&folder.join("machine.toml"))?;
    let read = |name: &str, count: u8| -> Result<Vec<Recording>, RecordingError> {
        let paths = (1..=count).map(|number| folder.join(format!("{name}-{number}.csv")));
        paths.map(|path| recording::read(&path, &ChannelMap::default())).collect()
    };

    // The training recordings choose; the held-out ones may only veto.
    let found = diagnose(&drive, &read("train", 4)?, &read("holdout", 2)?, None, &|_| {})?;

    println!("{}: {:?}", found.machine, found.verdict);
    for finding in &found.findings {
        println!("{} (confidence {:.3})", finding.effect.name, finding.confidence);
        for estimate in &finding.parameters {
            println!("  {} = {:.4e} ± {:.1e}", estimate.parameter.description().key, estimate.value, estimate.std);
        }
    }
    Ok(())
}
