//! Reads a drive and a recording, simulates in fixed point, and prints how well each signal is followed.
//!
//! `cargo run -p host-sim --example read_and_simulate [FOLDER]`; the folder holds `machine.toml` and `holdout-1.csv`.

use std::error::Error;
use std::path::PathBuf;

use recording::ChannelMap;
use simulation::figures_of_merit::SignalFit;
use simulation::{StartOffset, Stimulus, first_input_point, natural_tick, simulate_fixed};

fn main() -> Result<(), Box<dyn Error>> {
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/press-63-40");
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| shipped.to_owned()));
    let drive = machine_file::read(&folder.join("machine.toml"))?;
    let recording = recording::read(&folder.join("holdout-1.csv"), &ChannelMap::default())?;

    // The model is driven by the signal furthest upstream that was recorded.
    let input_point = first_input_point(drive.machine.source, &recording)?;
    let tick = natural_tick(&recording);
    let stimulus = Stimulus::new(&recording, &drive.machine, input_point, drive.load_source, tick)?;
    let run = simulate_fixed(&drive.machine, &stimulus, StartOffset::none())?;

    println!("{}: {} rows, driven by {}", recording.name(), recording.rows(), input_point.driving());
    for (signal, simulated) in &run.series {
        let Some(recorded) = recording.signal(*signal) else { continue };
        let fit = SignalFit::of(*signal, recording.time_s(), recorded, simulated);
        println!("{signal:>12}: NRMSE fit {:.2} %", fit.nrmse_percent);
    }
    Ok(())
}
