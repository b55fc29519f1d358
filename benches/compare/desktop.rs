//! Simulation on this computer: the core against RK4 in C and in Numba, and `SciPy`.

use std::cell::RefCell;
use std::error::Error;
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

use serde_json::Value;
use system_benches::floor::{Operations, WIDE};
use system_benches::run::{InLanes, Row, Run, START_M, random_commands, staggered};

use model_core::machine::Machine;
use model_core::number::PerUnit;
use simulation::number::simd::LANES;
use virtual_plant::{InitialState, Plant};

use crate::accurate::{self, Judged, Off, POSITION_PERCENT, PRESSURE_PERCENT, Signals, machine_of, plant_run};
use crate::page::{Part, Wanted, table};
use crate::peers::{Peers, list, number, text};
use crate::{child, range};

/// Rounds in which everything is timed once.
const ROUNDS: usize = 15;
/// How often each is timed in a round, and how many runs at a time: few enough to fit between two time slices of other programs.
const TIMES: usize = 20;
const RUNS: u32 = 4;
/// A run under commands in V.
type Simulated = Box<dyn Fn(&[f32], &mut Vec<Row>)>;

/// A run in this process, on a drive.
struct Ours {
    name: &'static str,
    how: String,
    run: Simulated,
    /// How often it is timed in a round, and how many runs of it at a time.
    times: (usize, u32),
    /// How many drives are simulated by one run.
    drives: usize,
}

impl Ours {
    fn core(name: &'static str, run: Simulated) -> Self {
        Self { name, how: "one step a tick".to_owned(), run, times: (TIMES, RUNS), drives: 1 }
    }

    /// A batch: each drive starts a quarter of the commands later. The rows of the first one are judged.
    fn in_lanes(name: &'static str, step: impl Fn([&[f32]; LANES], &mut [Vec<Row>; LANES]) + 'static) -> Self {
        let scratch = RefCell::new(<[Vec<Row>; LANES]>::default());
        let run = move |volts: &[f32], rows: &mut Vec<Row>| {
            let twice = [volts, volts].concat();
            let mut all = scratch.borrow_mut();
            std::mem::swap(rows, &mut all[0]);
            step(staggered(&twice), &mut all);
            std::mem::swap(rows, &mut all[0]);
        };
        let how = format!("{LANES} drives in SIMD lanes, each under commands of its own; the time of one");
        Self { how, drives: LANES, ..Self::core(name, Box::new(run)) }
    }

    /// `diffsol` through the virtual test bed's plant, with the loosest tolerance that keeps a fifth of the allowed error free. The tolerances
    /// of `SciPy` are chosen in the same way.
    fn diffsol(machine: &Machine<f64>, initial: InitialState, volts: &[f32], judged: &Judged) -> Option<Self> {
        let mut rows = Vec::new();
        [1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 1e-7].into_iter().find_map(|tolerance| {
            let plant = Plant::new(machine, tolerance).ok()?;
            let run: Simulated = Box::new(move |volts, rows| plant_run(&plant, &initial, volts, rows));
            run(volts, &mut rows);
            let off = Off::between(&rows, judged, machine);
            let roomy = Off { position: off.position / 0.8, pressure: off.pressure / 0.8 };
            let how = format!("ESDIRK 5(4) of the virtual test bed, tolerance {tolerance:e}");
            roomy.is_accurate().then(|| Self { name: "diffsol, tuned", how, run, times: (1, 1), drives: 1 })
        })
    }

    /// Shortest time of a tick in a round, s.
    fn timed(&self, volts: &[f32], rows: &mut Vec<Row>) -> f64 {
        let (times, runs) = self.times;
        let mut once = || {
            let start = Instant::now();
            for _ in 0..runs {
                (self.run)(black_box(volts), rows);
                black_box(&rows);
            }
            start.elapsed().as_secs_f64() / f64::from(runs) / (volts.len() * self.drives) as f64
        };
        (0..times).map(|_| once()).fold(f64::INFINITY, f64::min)
    }
}

fn ours(machine: &Machine<f64>, initial: &InitialState) -> [Ours; 6] {
    let four = InLanes::new(machine, initial);
    let (real, fixed) = (Run::<f64>::new(machine, initial), Run::<PerUnit>::new(machine, initial));
    [
        Ours::core("**core, f64**", Box::new(move |volts, rows| real.paper(volts, rows))),
        Ours::core("**core, fixed point**", Box::new(move |volts, rows| fixed.paper(volts, rows))),
        Ours::core("**core, f64, any effect possible**", Box::new(move |volts, rows| real.any(volts, rows))),
        Ours::core("**core, fixed point, any effect possible**", Box::new(move |volts, rows| fixed.any(volts, rows))),
        Ours::in_lanes("**core, f64, a batch**", move |volts, rows| four.paper(volts, rows)),
        Ours::in_lanes("**core, f64, a batch, any effect possible**", move |volts, rows| four.any(volts, rows)),
    ]
}

/// This part of the comparison.
pub(crate) fn part() -> Result<Part, Box<dyn Error>> {
    let mut part = Part { text: "## Simulation on the desktop\n\n".to_owned(), wanted: Vec::new() };
    match (Signals::start()?, Peers::start("desktop.py")?) {
        (Some(mut signals), Some((mut peers, said))) => against(&mut part, &mut signals, &mut peers, &said)?,
        _ => alone(&mut part)?,
    }
    Ok(part)
}

/// Without opponents: only the times.
fn alone(part: &mut Part) -> Result<(), Box<dyn Error>> {
    let volts = random_commands(4000);
    let mut rows = Vec::new();
    let mut lines = Vec::new();
    for drive in ["press", "heavy"] {
        let machine = machine_of(drive)?;
        for run in &ours(&machine, &InitialState::at_rest(&machine, START_M)) {
            let shortest = (0..ROUNDS).map(|_| run.timed(&volts, &mut rows)).fold(f64::INFINITY, f64::min);
            lines.push(vec![drive.to_owned(), run.name.to_owned(), format!("{:.4}", 1e6 * shortest)]);
        }
    }
    write!(
        part.text,
        "The peers are not at hand: no opponents.\n\n{}",
        table(&["drive", "what", "µs a tick"], &lines)
    )?;
    Ok(())
}

fn against(part: &mut Part, signals: &mut Signals, peers: &mut Peers, said: &Value) -> Result<(), Box<dyn Error>> {
    writeln!(
        part.text,
        "4 s of random steps at 1 kHz, every tick's spool, position, velocity and pressures written out. Accurate is what misses the peers' reference\n\
         (RK4 in double, 200 substeps) by at most {POSITION_PERCENT} % of the stroke and {PRESSURE_PERCENT} % of the supply pressure on every tick. Shortest of {ROUNDS} rounds; \
         a ratio is that of the\n\
         shortest. C is `-O3 -march=native -fno-math-errno` with parameters that are constants of the compiler and the fewest accurate substeps S; ours has\n\
         parameters of the run time, and what it is built for is said above. {}.\n",
        text(&said["versions"])
    )?;
    for drive in ["press", "heavy"] {
        let lines = turns(part, signals, (peers, said), drive)?;
        let head = ["what", "µs a tick", "times C", "off, position % / pressure %", "how"];
        writeln!(part.text, "Drive `{drive}`:\n\n{}", table(&head, &lines.rows))?;
        writeln!(part.text, "{}", lines.floor)?;
    }
    writeln!(part.text, "{}", accurate::by_drive(signals)?)?;
    writeln!(part.text, "{}", range::table_of(signals)?)?;
    writeln!(part.text, "{}", memory(said)?)?;
    Ok(())
}

/// The rows about one drive.
struct Lines {
    rows: Vec<Vec<String>>,
    floor: String,
}

/// How far a step in f64, and a step of one drive in a batch, are from the floor.
fn floor(operations: &Operations, alone_s: f64, batch_s: f64) -> String {
    let Operations { sums, products, quotients, roots } = operations;
    let floor_s = operations.floor_s();
    format!(
        "A tick of the core in f64 is {sums:.0} sums and comparisons, {products:.0} products, {quotients:.0} quotients and {roots:.0} roots. By instructions of one\n\
         each, none of which waited for another, with nothing else to do, these would take {:.4} µs on this processor in this run: the step takes {:.1} times its\n\
         floor. A batch does {WIDE} at once: {:.1} times its.\n",
        1e6 * floor_s,
        alone_s / floor_s,
        batch_s / (floor_s / WIDE as f64),
    )
}

/// All programs in turns on one drive: a line each.
fn turns(
    part: &mut Part,
    signals: &Signals,
    (peers, said): (&mut Peers, &Value),
    drive: &str,
) -> Result<Lines, Box<dyn Error>> {
    let (machine, volts) = (machine_of(drive)?, signals.volts("random")?);
    let (initial, theirs) = (signals.initial(drive)?, list(&said["opponents"][drive])?);
    let reference = signals.reference(drive, "random")?;
    let diffsol = Ours::diffsol(&machine, initial, &volts, &reference);
    let ours: Vec<Ours> = ours(&machine, &initial).into_iter().chain(diffsol).collect();
    let mut rows = Vec::new();
    let mut shortest = vec![f64::INFINITY; ours.len() + theirs.len()];
    for _ in 0..ROUNDS {
        let (of_ours, of_theirs) = shortest.split_at_mut(ours.len());
        for (run, shortest) in ours.iter().zip(of_ours) {
            *shortest = shortest.min(run.timed(&volts, &mut rows));
        }
        for (index, shortest) in of_theirs.iter_mut().enumerate() {
            *shortest = shortest.min(number(&peers.ask(&format!("{drive} {index}"))?)?);
        }
    }
    let first_of_theirs = shortest.get(ours.len()).copied().ok_or("C is the first of the peers")?;
    let line = |name: &str, time: f64, off: Off, how: &str| {
        vec![
            name.to_owned(),
            format!("{:.4}", 1e6 * time),
            format!("{:.2}", time / first_of_theirs),
            off.shown(),
            how.to_owned(),
        ]
    };
    let mut lines = Vec::new();
    for (run, &time) in ours.iter().zip(&shortest) {
        (run.run)(&volts, &mut rows);
        lines.push(line(run.name, time, Off::between(&rows, &reference, &machine), &run.how));
    }
    for (opponent, &time) in theirs.iter().zip(&shortest[ours.len()..]) {
        let off = Off { position: number(&opponent["position"])?, pressure: number(&opponent["pressure"])? };
        lines.push(line(&text(&opponent["name"]), time, off, &text(&opponent["how"])));
    }
    for (what, aim, time, most) in [
        ("one simulation, core in f64", "no slower than RK4 in C", shortest[0], 1.0),
        ("one simulation, core in fixed point", "no slower than RK4 in C", shortest[1], 1.0),
        ("a batch, core in f64, one thread", "4 times as fast as RK4 in C, one by one", shortest[4], 0.25),
    ] {
        let ratio = time / first_of_theirs;
        part.wanted.push(Wanted {
            what: format!("{what}, drive `{drive}`"),
            aim: aim.to_owned(),
            found: format!("{ratio:.2} times its time"),
            is_met: ratio <= most,
        });
    }
    let floor = floor(&Operations::of_a_tick(&machine, &initial, &volts), shortest[0], shortest[4]);
    Ok(Lines { rows: lines, floor })
}

/// Most memory of a process that simulates.
fn memory(said: &Value) -> Result<String, Box<dyn Error>> {
    let preset = concat!(env!("CARGO_MANIFEST_DIR"), "/../presets/press-63-40.toml");
    let folder = tempfile::tempdir()?;
    let out = folder.path().join("out.csv");
    let out = out.to_str().ok_or("a temporary folder whose name is not text")?;
    let bed = folder.path().join("bed");
    let bed = bed.to_str().ok_or("a temporary folder whose name is not text")?;
    let input = "random:10V,4s,seed=1";
    let took = child::host_sim(1, &["simulate", "--machine", preset, "--input", input, "--out", out])?;
    let of_diffsol = child::host_sim(1, &["testbed", "--machine", preset, "--train", input, "--out", bed])?;
    let peak_mb = |of: &str| Ok::<_, Box<dyn Error>>(format!("{:.0}", number(&said["peak_kb"][of])? / 1024.0));
    let lines = [
        vec!["**`host-sim simulate`, 4 s, to a CSV**".to_owned(), format!("{:.0}", took.peak_mb)],
        vec!["diffsol, as `host-sim testbed`, 4 s, to a case's files".to_owned(), format!("{:.0}", of_diffsol.peak_mb)],
        vec!["Python with NumPy imported, after one run of RK4 C".to_owned(), peak_mb("c")?],
        vec!["Python with NumPy, SciPy and Numba imported, after one run".to_owned(), peak_mb("numba")?],
        vec!["the same after every opponent".to_owned(), peak_mb("all")?],
    ];
    Ok(table(&["most memory of a process", "MB"], &lines))
}
