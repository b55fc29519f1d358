//! The peers' signals, and what counts as accurate under them.

use std::error::Error;

use serde_json::Value;
use system_benches::run::{Row, Run, START_M, TICK};

use model_core::machine::{Machine, Parameter as P};
use model_core::number::{PerUnit, Scalar};
use system_tests::drives;
use system_tests::simulate::ORACLE_TOLERANCE;
use virtual_plant::{Commands, InitialState, Plant};

use crate::page::table;
use crate::peers::{Peers, list, number};

/// What counts as accurate, as in the peers' README: % of the stroke, % of the supply pressure, the largest over all ticks.
pub(crate) const POSITION_PERCENT: f64 = 0.01;
pub(crate) const PRESSURE_PERCENT: f64 = 0.1;

/// The peers' signal that is judged in another way.
const SWEEP: &str = "sweep";

/// Position (m) and both pressures (Pa) at the end of each tick.
pub(crate) type Judged = Vec<[f64; 3]>;

/// Rows of a plant at the end of each tick; none where it cannot be solved.
pub(crate) fn plant_run(plant: &Plant, initial: &InitialState, volts: &[f32], rows: &mut Vec<Row>) {
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
pub(crate) struct Off {
    pub(crate) position: f64,
    pub(crate) pressure: f64,
}

impl Off {
    pub(crate) fn between(rows: &[Row], reference: &Judged, machine: &Machine<f64>) -> Self {
        if rows.len() != reference.len() {
            return Self { position: f64::INFINITY, pressure: f64::INFINITY };
        }
        // A value that is not a number counts as infinitely far off.
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

    pub(crate) fn or(self, other: Self) -> Self {
        Self { position: self.position.max(other.position), pressure: self.pressure.max(other.pressure) }
    }

    pub(crate) fn is_accurate(self) -> bool {
        self.position <= POSITION_PERCENT && self.pressure <= PRESSURE_PERCENT
    }

    pub(crate) fn shown(self) -> String {
        let fails = if self.is_accurate() { "" } else { " **not accurate**" };
        format!("{:.0e} / {:.0e}{fails}", self.position, self.pressure)
    }
}

/// The drive that has this name at the peers.
pub(crate) fn machine_of(drive: &str) -> Result<Machine<f64>, Box<dyn Error>> {
    let found = drives::named().into_iter().find(|named| named.name == drive);
    Ok(found.ok_or_else(|| format!("there is no drive {drive}"))?.machine)
}

/// How far a run is off under all of the signals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Judgement {
    /// Steps and random, by the peers' reference.
    pub(crate) steps: Off,
    /// The sweep, by the project's oracle and by the peers' reference.
    pub(crate) sweep: Off,
    pub(crate) sweep_by_peers: Off,
}

/// Signals, starts and references, from the peers' program.
#[derive(Debug)]
pub(crate) struct Signals {
    peers: Peers,
    said: Value,
}

impl Signals {
    /// `None` where the peers are not there.
    pub(crate) fn start() -> Result<Option<Self>, Box<dyn Error>> {
        Ok(Peers::start("signals.py")?.map(|(peers, said)| Self { peers, said }))
    }

    pub(crate) fn names(&self) -> Result<Vec<String>, Box<dyn Error>> {
        Ok(self.said["signals"].as_object().ok_or("signals have names")?.keys().cloned().collect())
    }

    pub(crate) fn volts(&self, signal: &str) -> Result<Vec<f32>, Box<dyn Error>> {
        #[expect(clippy::cast_possible_truncation, reason = "they were f32")]
        list(&self.said["signals"][signal])?.iter().map(|volts| Ok(number(volts)? as f32)).collect()
    }

    /// The initial state of a drive.
    pub(crate) fn initial(&self, drive: &str) -> Result<InitialState, Box<dyn Error>> {
        let [a, b] = [0, 1].map(|index| number(&self.said["start"][drive][index]));
        Ok(InitialState { pressure_a_pa: a?, pressure_b_pa: b?, position_m: START_M, velocity_m_per_s: 0.0 })
    }

    /// The peers' reference for a drive under a signal.
    pub(crate) fn reference(&self, drive: &str, signal: &str) -> Result<Judged, Box<dyn Error>> {
        judged(&self.said["references"][drive][signal])
    }

    /// Sends a changed drive to the program.
    pub(crate) fn ask(&mut self, line: &str) -> Result<Value, Box<dyn Error>> {
        self.peers.ask(line)
    }

    /// How far a run of a drive is off.
    ///
    /// A sweep changes its command in every tick. The peers' limiter turns that into a ramp over the tick; ours holds the command, as a
    /// controller does, and moves at the limiter's own rate within the tick, half a tick sooner on the average. So the sweep is judged by
    /// the project's oracle, which does the same, and the figure against the peers' reference stands beside it.
    fn judge(&self, drive: &str, run: impl Fn(&[f32], &mut Vec<Row>)) -> Result<Judgement, Box<dyn Error>> {
        let (machine, initial) = (machine_of(drive)?, self.initial(drive)?);
        let (mut steps, mut rows): (Off, Vec<Row>) = Default::default();
        for signal in self.names()?.iter().filter(|signal| *signal != SWEEP) {
            run(&self.volts(signal)?, &mut rows);
            steps = steps.or(Off::between(&rows, &self.reference(drive, signal)?, &machine));
        }
        let volts = self.volts(SWEEP)?;
        run(&volts, &mut rows);
        let mut exact = Vec::new();
        plant_run(&Plant::new(&machine, ORACLE_TOLERANCE)?, &initial, &volts, &mut exact);
        let exact: Judged = exact.iter().map(|[_, y, _, a, b]| [*y, *a, *b]).collect();
        Ok(Judgement {
            steps,
            sweep: Off::between(&rows, &exact, &machine),
            sweep_by_peers: Off::between(&rows, &self.reference(drive, SWEEP)?, &machine),
        })
    }
}

/// Rows that the peers have written.
pub(crate) fn judged(runs: &Value) -> Result<Judged, Box<dyn Error>> {
    let row = |row: &Value| {
        let [y, a, b] = [0, 1, 2].map(|index| number(&row[index]));
        Ok([y?, a?, b?])
    };
    list(runs)?.iter().map(row).collect()
}

/// The core in an arithmetic, on a drive.
pub(crate) fn of_core<N: Scalar<Real = f64>>(signals: &Signals, drive: &str) -> Result<Judgement, Box<dyn Error>> {
    let run = Run::<N>::new(&machine_of(drive)?, &signals.initial(drive)?);
    signals.judge(drive, |volts, rows| run.paper(volts, rows))
}

/// The worst of the peers' signals, by drive and arithmetic. Fixed point is bit for bit what the target computes.
pub(crate) fn by_drive(signals: &Signals) -> Result<String, Box<dyn Error>> {
    let mut lines = Vec::new();
    for drive in ["printed", "press", "heavy"] {
        for (name, off) in [
            ("**core, f64**", of_core::<f64>(signals, drive)?),
            ("**core, fixed point**", of_core::<PerUnit>(signals, drive)?),
        ] {
            let shown = [off.steps, off.sweep, off.sweep_by_peers].map(Off::shown);
            lines.push([drive, name].map(str::to_owned).into_iter().chain(shown).collect());
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
