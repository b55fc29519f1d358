//! Nights of many drives: how many recordings a minute are watched, how that grows with the number of drives, what a second core gives, what memory it takes,
//! and what 100,000 recordings a night cost.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use recording::ChannelMap;

use crate::child::{self, Took, text};
use crate::growth::exponent;
use crate::machine;
use crate::page::{Part, Wanted, table};

/// The drive, as it is installed.
const DRIVE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../presets/press-63-40-installed.toml");
/// Recordings of 4 s at 1 kHz that tell the band, and further ones that are watched in turns.
const HEALTHY: usize = 12;
const WATCHED: usize = 8;
const LENGTH_S: u32 = 4;
/// Numbers of drives, one night of one recording each.
const DRIVES: [usize; 3] = [100, 1000, 10_000];
/// Drives of which the night is refitted, and diagnosed.
const REFITTED: usize = 20;
const DIAGNOSED: usize = 4;
/// Machines, each of two cores, and the share of nights that leave their band, of the table of costs.
const MACHINES: [f64; 4] = [1.0, 2.0, 4.0, 16.0];
const NIGHTLY: f64 = 1e5;
const LEFT: f64 = 0.01;

/// Recordings of the drive with these effects on the virtual test bed.
fn recorded(folder: &Path, count: usize, seed: &str, effects: &[&str]) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let signals: Vec<String> =
        (1..=count).map(|number| format!("random:4V,0.1s,0.5s,{LENGTH_S}s,seed={seed}{number:02}")).collect();
    let mut arguments = vec!["testbed", "--machine", DRIVE, "--spread", "0", "--closed-loop", "80", "--seed", seed];
    arguments.extend(signals.iter().flat_map(|signal| ["--train", signal.as_str()]));
    arguments.extend(effects.iter().flat_map(|effect| ["--effect", effect]));
    arguments.extend(["--out", text(folder)?]);
    child::host_sim(2, &arguments)?;
    Ok((1..=count).map(|number| folder.join(format!("train-{number}.csv"))).collect())
}

/// The drive with its band, and recordings as Parquet: healthy ones, and ones with a leak.
struct Drawn {
    machine: PathBuf,
    healthy: Vec<PathBuf>,
    leaking: Vec<PathBuf>,
}

impl Drawn {
    fn new(scratch: &Path) -> Result<Self, Box<dyn Error>> {
        let healthy = recorded(&scratch.join("healthy"), HEALTHY + WATCHED, "1", &[])?;
        let leaking = recorded(&scratch.join("leaking"), DIAGNOSED, "2", &["internal-leakage=3e-12"])?;
        let machine = scratch.join("machine.toml");
        let mut arguments = vec!["watch", "--machine", DRIVE, "--save-machine", text(&machine)?, "--healthy"];
        arguments.extend(healthy[..HEALTHY].iter().map(|path| text(path)).collect::<Result<Vec<_>, _>>()?);
        child::host_sim(2, &arguments)?;
        let packed = |path: &PathBuf| -> Result<PathBuf, Box<dyn Error>> {
            let to = path.with_extension("parquet");
            recording::read(path, &ChannelMap::default())?.write(&to, &[], &[])?;
            Ok(to)
        };
        Ok(Self {
            machine,
            healthy: healthy[HEALTHY..].iter().map(packed).collect::<Result<_, _>>()?,
            leaking: leaking.iter().map(packed).collect::<Result<_, _>>()?,
        })
    }

    /// A hall of so many drives, whose nights have these recordings in turns.
    fn hall(&self, folder: &Path, drives: usize, recordings: &[PathBuf]) -> Result<(), Box<dyn Error>> {
        for number in 0..drives {
            let drive = folder.join(format!("drive=d{number:05}"));
            let night = drive.join("date=2026-01-01");
            fs::create_dir_all(&night)?;
            fs::copy(&self.machine, drive.join("machine.toml"))?;
            fs::copy(&recordings[number % recordings.len()], night.join("1.parquet"))?;
        }
        Ok(())
    }
}

/// Judges a hall; the table is new.
fn judged(hall: &Path, upto: &str, threads: usize) -> Result<Took, Box<dyn Error>> {
    let table = tempfile::tempdir()?;
    child::host_sim(threads, &["fleet", text(hall)?, "--upto", upto, "--out", text(&table.path().join("t"))?])
}

/// The figures of the halls of different sizes.
struct Watched {
    lines: Vec<Vec<String>>,
    /// Number of drives, and computing time in s.
    growth: Vec<(f64, f64)>,
    per_minute: f64,
    twice: f64,
    most_mb: f64,
}

fn watched(drawn: &Drawn, scratch: &Path) -> Result<Watched, Box<dyn Error>> {
    let mut all = Watched { lines: Vec::new(), growth: Vec::new(), per_minute: 0.0, twice: 0.0, most_mb: 0.0 };
    for drives in DRIVES {
        let hall = scratch.join(format!("hall-{drives}"));
        drawn.hall(&hall, drives, &drawn.healthy)?;
        let [one, two] = [1, 2].map(|threads| judged(&hall, "watch", threads));
        let (one, two) = (one?, two?);
        let of = |took: &Took, threads: &str| {
            vec![
                format!("{drives} drives, {threads}"),
                format!("{:.2}", took.wall_s),
                format!("{:.0}", 60.0 * drives as f64 / took.wall_s),
                format!("{:.2}", 1e3 * took.computed_s / drives as f64),
                format!("{:.0}", took.peak_mb),
            ]
        };
        all.lines.extend([of(&one, "one thread"), of(&two, "two threads")]);
        all.growth.push((drives as f64, one.computed_s));
        all.per_minute = 60.0 * drives as f64 / two.wall_s;
        all.twice = one.wall_s / two.wall_s;
        all.most_mb = all.most_mb.max(two.peak_mb);
        fs::remove_dir_all(&hall)?;
    }
    Ok(all)
}

/// What 100,000 recordings a night take on some machines, h: watched alone; watched, and the others refitted and some diagnosed. Computing times of a night in
/// s, and how many times as fast two cores are.
fn nightly((watch_s, refit_s, diagnose_s): (f64, f64, f64), twice: f64) -> Vec<Vec<String>> {
    let hours = |each_s: f64, machines: f64| format!("{:.2}", NIGHTLY * each_s / (twice * machines) / 3600.0);
    let all_s = (1.0 - LEFT) * refit_s + LEFT * diagnose_s;
    MACHINES
        .iter()
        .map(|&machines| vec![format!("{machines:.0}"), hours(watch_s, machines), hours(all_s, machines)])
        .collect()
}

/// This part of the comparison.
pub(crate) fn part() -> Result<Part, Box<dyn Error>> {
    let load = machine::load()?;
    let scratch = tempfile::tempdir()?;
    let scratch = scratch.path();
    let drawn = Drawn::new(scratch)?;
    let bytes = fs::metadata(&drawn.healthy[0])?.len();
    let watched = watched(&drawn, scratch)?;
    let one_night = |name: &str, drives: usize, recordings: &[PathBuf], upto: &str| -> Result<f64, Box<dyn Error>> {
        let hall = scratch.join(name);
        drawn.hall(&hall, drives, recordings)?;
        Ok(judged(&hall, upto, 2)?.computed_s / drives as f64)
    };
    let watch_s = watched.growth.last().map_or(f64::NAN, |(drives, computed_s)| computed_s / drives);
    let refit_s = one_night("refitted", REFITTED, &drawn.healthy, "refit")?;
    let diagnose_s = one_night("diagnosed", DIAGNOSED, &drawn.leaking, "diagnose")?;
    let exponent = exponent(&watched.growth);

    let mut part = Part { text: "## A fleet\n\n".to_owned(), wanted: Vec::new() };
    let mut want = |what: &str, aim: &str, found: String, is_met| {
        part.wanted.push(Wanted { what: what.to_owned(), aim: aim.to_owned(), found, is_met });
    };
    want(
        "recordings of 4 s at 1 kHz watched in a minute, from Parquet, two cores",
        "2000",
        format!("{:.0}", watched.per_minute),
        watched.per_minute >= 2000.0,
    );
    want(
        "growth of its computing time from 100 to 10,000 drives, exponent",
        "at most 1.02",
        format!("{exponent:.3}"),
        exponent <= 1.02,
    );
    want(
        "two threads against one, 10,000 drives",
        "1.8 times as fast",
        format!("{:.2}", watched.twice),
        watched.twice >= 1.8,
    );
    want("most memory of it", "1 GiB", format!("{:.0} MB", watched.most_mb), watched.most_mb < 1024.0);
    writeln!(
        part.text,
        "`host-sim fleet --upto watch` from its start to the written table: each drive has a machine file of its own and one night of one recording of {LENGTH_S} s at\n\
         1 kHz with all sensors, Parquet, {} kB. The files were written just before, so that the disk's own speed does not count. The load before was {load}.\n",
        bytes / 1024
    )?;
    let head = ["what", "s", "recordings a minute", "ms computed for each", "most memory, MB"];
    writeln!(part.text, "{}", table(&head, &watched.lines))?;
    writeln!(
        part.text,
        "Computing time grows with the number of drives to the power {exponent:.3}. A night that is also refitted takes {refit_s:.2} s of computing\n\
         (mean of {REFITTED}), one that left its band and is diagnosed {diagnose_s:.1} s (mean of {DIAGNOSED}, a leak).\n"
    )?;
    writeln!(part.text, "What {NIGHTLY:.0} recordings a night take, computed from these on machines of two cores:\n")?;
    let head = ["machines", "watched, h", "watched, refitted, and one in a hundred diagnosed, h"];
    writeln!(part.text, "{}", table(&head, &nightly((watch_s, refit_s, diagnose_s), watched.twice)))?;
    let read_mb_per_s = watched.twice / watch_s * bytes as f64 / 1e6;
    writeln!(
        part.text,
        "What limits it is computing: nights know nothing of each other, and a machine of two cores that only watches reads {read_mb_per_s:.1} MB/s. One process\n\
         writes the table, which is {:.0} rows a second on sixteen machines.",
        watched.twice * MACHINES[MACHINES.len() - 1] / watch_s
    )?;
    Ok(part)
}
