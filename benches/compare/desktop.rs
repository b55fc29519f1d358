//! Simulation on this computer: the core against RK4 in C and in Numba, and `SciPy`.

use std::array::from_fn;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

use host_sim::lanes::LANES;
use host_sim::testbed::{Commands, Excitation, InitialState, Plant};
use model_core::fixed_point::PerUnit;
use model_core::machine::Machine;
use model_core::parameter::Parameter as P;
use serde_json::Value;
use system_benches::floor::{Operations, WIDE};
use system_benches::run::{Abreast, Row, Run, TICK};
use system_tests::drives;
use system_tests::simulate::ORACLE_TOLERANCE;

use crate::child;
use crate::page::{Part, Wanted, table};
use crate::peers::{self, Peers, list, number, text};

/// Rounds in which everything is timed once.
const ROUNDS: usize = 15;
/// How often each is timed in a round, and how many runs of it at a time: so few as fit between two turns of other programs.
const TIMES: usize = 20;
const RUNS: u32 = 4;
/// Where the rod stands at first, m, as the peers have it.
const START_M: f64 = 0.15;

/// What counts as accurate, as in the peers' README: % of the stroke, % of the supply pressure, the largest over all ticks.
const POSITION_PERCENT: f64 = 0.01;
const PRESSURE_PERCENT: f64 = 0.1;

/// The peers' signal that is judged otherwise.
const SWEEP: &str = "sweep";

/// Position (m) and both pressures (Pa) at the end of each tick.
type Judged = Vec<[f64; 3]>;
/// A run under commands in V.
type Simulated = Box<dyn Fn(&[f32], &mut Vec<Row>)>;

/// One that runs in this process, on a drive.
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

    /// A batch: each drive a quarter of the commands further on. The first one's rows are those that are judged.
    fn abreast(name: &'static str, step: impl Fn([&[f32]; LANES], &mut [Vec<Row>; LANES]) + 'static) -> Self {
        let scratch = RefCell::new(<[Vec<Row>; LANES]>::default());
        let run = move |volts: &[f32], rows: &mut Vec<Row>| {
            let twice = [volts, volts].concat();
            let own = from_fn(|lane| &twice[lane * volts.len() / LANES..][..volts.len()]);
            let mut all = scratch.borrow_mut();
            std::mem::swap(rows, &mut all[0]);
            step(own, &mut all);
            std::mem::swap(rows, &mut all[0]);
        };
        let how = format!("{LANES} drives abreast, each under commands of its own; the time of one");
        Self { how, drives: LANES, ..Self::core(name, Box::new(run)) }
    }

    /// `diffsol` by way of the virtual test bed's plant, with the loosest tolerance that leaves a fifth of what is allowed, as `SciPy`'s
    /// are chosen.
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

/// Rows of a plant at the end of each tick; none where it cannot be solved.
fn plant_run(plant: &Plant, initial: &InitialState, volts: &[f32], rows: &mut Vec<Row>) {
    // The first row is before the first tick; the last command is held.
    let held = volts.iter().chain(volts.last()).map(|&volts| f64::from(volts)).collect();
    let times_s: Vec<f64> = (0..=volts.len()).map(|tick| tick as f64 * TICK.seconds()).collect();
    rows.clear();
    let states = plant.simulate(&Commands::Valve(held), initial, &times_s).unwrap_or_default();
    rows.extend(states.iter().skip(1).map(|state| {
        [state.spool, state.position_m, state.velocity_m_per_s, state.pressure_a_pa, state.pressure_b_pa]
    }));
}

/// Largest differences, % of the stroke and % of the supply pressure.
#[derive(Clone, Copy, Debug, Default)]
struct Off {
    position: f64,
    pressure: f64,
}

impl Off {
    fn between(rows: &[Row], reference: &Judged, machine: &Machine<f64>) -> Self {
        if rows.len() != reference.len() {
            return Self { position: f64::INFINITY, pressure: f64::INFINITY };
        }
        // What is no number is as far off as can be.
        let percent = |found: f64, wanted: f64, of: f64| {
            let off = 100.0 * (found - wanted).abs() / of;
            if off.is_nan() { f64::INFINITY } else { off }
        };
        let (stroke, supply) = (machine.get(P::Stroke), machine.get(P::SupplyPressure));
        rows.iter().zip(reference).fold(Self::default(), |worst, ([_, y, _, pa, pb], [y0, pa0, pb0])| Self {
            position: worst.position.max(percent(*y, *y0, stroke)),
            pressure: worst.pressure.max(percent(*pa, *pa0, supply)).max(percent(*pb, *pb0, supply)),
        })
    }

    fn or(self, other: Self) -> Self {
        Self { position: self.position.max(other.position), pressure: self.pressure.max(other.pressure) }
    }

    fn is_accurate(self) -> bool {
        self.position <= POSITION_PERCENT && self.pressure <= PRESSURE_PERCENT
    }

    fn shown(self) -> String {
        let fails = if self.is_accurate() { "" } else { " **not accurate**" };
        format!("{:.0e} / {:.0e}{fails}", self.position, self.pressure)
    }
}

/// What the peers' program says of itself.
struct Said(Value);

impl Said {
    fn volts(&self, signal: &str) -> Result<Vec<f32>, Box<dyn Error>> {
        #[expect(clippy::cast_possible_truncation, reason = "they were f32")]
        list(&self.0["signals"][signal])?.iter().map(|volts| Ok(number(volts)? as f32)).collect()
    }

    fn signals(&self) -> Result<Vec<String>, Box<dyn Error>> {
        Ok(self.0["signals"].as_object().ok_or("signals have names")?.keys().cloned().collect())
    }

    fn start(&self, drive: &str) -> Result<InitialState, Box<dyn Error>> {
        let [a, b] = [0, 1].map(|index| number(&self.0["start"][drive][index]));
        Ok(InitialState { pressure_a_pa: a?, pressure_b_pa: b?, position_m: START_M, velocity_m_per_s: 0.0 })
    }
}

fn judged(runs: &Value) -> Result<Judged, Box<dyn Error>> {
    let row = |row: &Value| {
        let [y, a, b] = [0, 1, 2].map(|index| number(&row[index]));
        Ok([y?, a?, b?])
    };
    list(runs)?.iter().map(row).collect()
}

fn machine_of(drive: &str) -> Result<Machine<f64>, Box<dyn Error>> {
    let found = drives::named().into_iter().find(|named| named.name == drive);
    Ok(found.ok_or_else(|| format!("there is no drive {drive}"))?.machine)
}

fn ours(machine: &Machine<f64>, initial: &InitialState) -> [Ours; 6] {
    let four = Abreast::new(machine, initial);
    let (real, fixed) = (Run::<f64>::new(machine, initial), Run::<PerUnit>::new(machine, initial));
    [
        Ours::core("**core, f64**", Box::new(move |volts, rows| real.paper(volts, rows))),
        Ours::core("**core, fixed point**", Box::new(move |volts, rows| fixed.paper(volts, rows))),
        Ours::core("**core, f64, any effect possible**", Box::new(move |volts, rows| real.any(volts, rows))),
        Ours::core("**core, fixed point, any effect possible**", Box::new(move |volts, rows| fixed.any(volts, rows))),
        Ours::abreast("**core, f64, a batch**", move |volts, rows| four.paper(volts, rows)),
        Ours::abreast("**core, f64, a batch, any effect possible**", move |volts, rows| four.any(volts, rows)),
    ]
}

/// The part.
pub(crate) fn part() -> Result<Part, Box<dyn Error>> {
    let mut part = Part { text: "## Simulation on the desktop\n\n".to_owned(), wanted: Vec::new() };
    match Peers::start("desktop.py")? {
        Some((mut peers, said)) => against(&mut part, &mut peers, &Said(said))?,
        None => alone(&mut part)?,
    }
    Ok(part)
}

/// Without opponents: times alone.
fn alone(part: &mut Part) -> Result<(), Box<dyn Error>> {
    #[expect(clippy::cast_possible_truncation, reason = "commands in V, as the peers take them")]
    let volts: Vec<f32> =
        Excitation::random_steps(1).sample(TICK.seconds()).into_iter().map(|volts| volts as f32).collect();
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

fn against(part: &mut Part, peers: &mut Peers, said: &Said) -> Result<(), Box<dyn Error>> {
    writeln!(
        part.text,
        "4 s of random steps at 1 kHz, every tick's slider, position, velocity and pressures written out. Accurate is what misses the peers' reference\n\
         (RK4 in double, 200 substeps) by at most {POSITION_PERCENT} % of the stroke and {PRESSURE_PERCENT} % of the supply pressure on every tick. Shortest of {ROUNDS} rounds; \
         a ratio is that of the\n\
         shortest. C is `-O3 -march=native -fno-math-errno` with parameters that are constants of the compiler and the fewest accurate substeps S; ours has\n\
         parameters of the run time, and what it is built for is said above. {}.\n",
        text(&said.0["versions"])
    )?;
    for drive in ["press", "heavy"] {
        let lines = turns(part, peers, said, drive)?;
        let head = ["what", "µs a tick", "times C", "off, position % / pressure %", "how"];
        writeln!(part.text, "Drive `{drive}`:\n\n{}", table(&head, &lines.rows))?;
        writeln!(part.text, "{}", lines.floor)?;
    }
    writeln!(part.text, "{}", accuracy(said)?)?;
    writeln!(part.text, "{}", friction(said)?)?;
    writeln!(part.text, "{}", memory(said)?)?;
    Ok(())
}

/// What is said of one drive.
struct Lines {
    rows: Vec<Vec<String>>,
    floor: String,
}

/// How far a step in f64, and one of a batch, are from the floor.
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

/// Everything in turns on one drive: a line each.
fn turns(part: &mut Part, peers: &mut Peers, said: &Said, drive: &str) -> Result<Lines, Box<dyn Error>> {
    let (machine, volts) = (machine_of(drive)?, said.volts("random")?);
    let (initial, theirs) = (said.start(drive)?, list(&said.0["opponents"][drive])?);
    let reference = judged(&said.0["references"][drive]["random"])?;
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

/// The worst of the peers' signals, by drive and arithmetic. Fixed point is bit for bit what the target computes.
///
/// A sweep changes its command in every tick. The peers' limiter turns that into a ramp over the tick; ours holds the command, as a
/// controller does, and moves at the limiter's own rate within the tick, half a tick sooner on the average. So the sweep is judged by
/// the project's oracle, which does that too, and what the peers' reference says of it stands beside.
fn accuracy(said: &Said) -> Result<String, Box<dyn Error>> {
    let mut lines = Vec::new();
    for drive in ["printed", "press", "heavy"] {
        let (machine, initial) = (machine_of(drive)?, said.start(drive)?);
        for run in ours(&machine, &initial).iter().take(2) {
            let mut worst = Off::default();
            let mut rows = Vec::new();
            for signal in said.signals()?.iter().filter(|signal| *signal != SWEEP) {
                (run.run)(&said.volts(signal)?, &mut rows);
                worst = worst.or(Off::between(&rows, &judged(&said.0["references"][drive][signal])?, &machine));
            }
            let volts = said.volts(SWEEP)?;
            (run.run)(&volts, &mut rows);
            let by_peers = Off::between(&rows, &judged(&said.0["references"][drive][SWEEP])?, &machine);
            let oracle = Plant::new(&machine, ORACLE_TOLERANCE)?;
            let mut exact = Vec::new();
            plant_run(&oracle, &initial, &volts, &mut exact);
            let exact: Judged = exact.iter().map(|[_, y, _, a, b]| [*y, *a, *b]).collect();
            let by_oracle = Off::between(&rows, &exact, &machine);
            lines.push(vec![drive.to_owned(), run.name.to_owned(), worst.shown(), by_oracle.shown(), by_peers.shown()]);
        }
    }
    let head = [
        "off, position % / pressure %",
        "",
        "steps of 2 to 10 V and random",
        "sweep, by the oracle",
        "sweep, by the peers' reference",
    ];
    let note = "A sweep changes its command in every tick. The peers' limiter makes that a ramp over the tick; ours, and the oracle, hold the command, as a controller does,\n\
        and follow at the limiter's own rate within the tick: half a tick sooner on the average. The last column is that difference of two models.\n";
    Ok(format!("{}\n{note}", table(&head, &lines)))
}

/// How much more viscous friction than the drive's own each bears: both the random steps and 10 V stay accurate.
fn friction(said: &Said) -> Result<String, Box<dyn Error>> {
    let mut columns: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let drives = ["printed", "press"];
    for drive in drives {
        let (machine, initial) = (machine_of(drive)?, said.start(drive)?);
        let mut borne = [1.0, 1.0];
        for case in list(&said.0["friction"][drive])? {
            let factor = number(&case["factor"])?;
            let stiffer = machine.with(&[(P::ViscousFriction, factor * machine.get(P::ViscousFriction))]);
            for (run, borne) in ours(&stiffer, &initial).iter().zip(&mut borne) {
                let mut worst = Off::default();
                let mut rows = Vec::new();
                for signal in ["random", "step 10 V"] {
                    (run.run)(&said.volts(signal)?, &mut rows);
                    worst = worst.or(Off::between(&rows, &judged(&case["references"][signal])?, &stiffer));
                }
                if worst.is_accurate() {
                    *borne = factor;
                }
            }
        }
        for (name, borne) in ["core, f64", "core, fixed point"].iter().zip(borne) {
            columns.entry((*name).to_owned()).or_default().push(format!("{borne:.0}"));
        }
        if let Some(target) = peers::on_target()? {
            for substeps in [2, 3, 4] {
                let borne = number(&target["margin"][format!("{drive} S={substeps}")])?;
                columns.entry(format!("RK4 C float, S={substeps}")).or_default().push(format!("{borne:.2}"));
            }
        }
    }
    let lines: Vec<Vec<String>> =
        columns.into_iter().map(|(name, borne)| [name].into_iter().chain(borne).collect()).collect();
    let most = list(&said.0["friction"]["press"])?.last().map_or(Ok(1.0), |case| number(&case["factor"]))?;
    let note = format!("Ours was tried at 2, 4, 8, 16 and {most:.0} times; RK4 in steps of 0.05 up to 4 times.\n");
    Ok(format!("{}\n{note}", table(&["bears the drive's viscous friction times", drives[0], drives[1]], &lines)))
}

/// Most memory of a process that simulates.
fn memory(said: &Said) -> Result<String, Box<dyn Error>> {
    let preset = concat!(env!("CARGO_MANIFEST_DIR"), "/../presets/press-63-40.toml");
    let folder = tempfile::tempdir()?;
    let out = folder.path().join("out.csv");
    let out = out.to_str().ok_or("a temporary folder whose name is no text")?;
    let took = child::host_sim(1, &["simulate", "--machine", preset, "--input", "random:10V,4s,seed=1", "--out", out])?;
    let peak_mb = |of: &str| Ok::<_, Box<dyn Error>>(format!("{:.0}", number(&said.0["peak_kb"][of])? / 1024.0));
    let lines = [
        vec!["**`host-sim simulate`, 4 s, to a CSV**".to_owned(), format!("{:.0}", took.peak_mb)],
        vec!["Python with NumPy, SciPy and Numba imported, after one run".to_owned(), peak_mb("numba")?],
        vec!["the same after every opponent".to_owned(), peak_mb("all")?],
    ];
    Ok(table(&["most memory of a process", "MB"], &lines))
}
