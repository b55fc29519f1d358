//! One refit of ten parameters on four recordings, against `scipy.optimize.least_squares`.

use std::error::Error;
use std::fmt::Write;
use std::time::Instant;

use serde_json::Value;
use system_benches::refit::{FREE, Refit};

use model_core::machine::Machine;
use system_tests::at_hand::shared;

use crate::machine;
use crate::page::{Part, Wanted, table};
use crate::peers::{Peers, list, number, text};

/// Rounds in which everything is timed once.
const ROUNDS: usize = 9;
/// The case, of `$HOST_SIM_SHARED`: the one that the peers' `bench_fit.py` uses.
const CASE: &str = "concealed/d30";

/// One of our fits: its name, its problem, its threads.
struct Ours {
    name: &'static str,
    refit: Refit,
    pool: rayon::ThreadPool,
    shortest_s: f64,
    computed_s: f64,
    end: Option<End>,
}

/// The end point of one of our fits.
struct End {
    machine: Machine<f64>,
    evaluations: usize,
    cost: Option<f64>,
}

impl Ours {
    fn new(name: &'static str, refit: &Refit, threads: usize) -> Result<Self, Box<dyn Error>> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        Ok(Self { name, refit: refit.clone(), pool, shortest_s: f64::INFINITY, computed_s: f64::INFINITY, end: None })
    }

    fn time(&mut self) -> Result<(), Box<dyn Error>> {
        let (start, computed) = (Instant::now(), machine::computed_s());
        let (fit, evaluations) = self.pool.install(|| self.refit.run())?;
        self.shortest_s = self.shortest_s.min(start.elapsed().as_secs_f64());
        self.computed_s = self.computed_s.min(machine::computed_s() - computed);
        if !fit.converged {
            return Err(format!("{} did not converge", self.name).into());
        }
        self.end = Some(End { machine: fit.machine, evaluations, cost: self.refit.cost(&fit) });
        Ok(())
    }
}

/// One of the peers' fits.
struct Theirs {
    name: String,
    shortest_s: f64,
    computed_s: f64,
    cost: f64,
    simulations: String,
}

/// Runs all fits in turns; returns the peers' times.
fn turns(ours: &mut [Ours], mut peers: Option<&mut (Peers, Value)>) -> Result<Vec<Theirs>, Box<dyn Error>> {
    let names: Vec<String> = match &peers {
        Some((_, said)) => list(&said["kinds"])?.iter().map(text).collect(),
        None => Vec::new(),
    };
    let new = |name| Theirs {
        name,
        shortest_s: f64::INFINITY,
        computed_s: f64::INFINITY,
        cost: f64::NAN,
        simulations: String::new(),
    };
    let mut theirs: Vec<Theirs> = names.into_iter().map(new).collect();
    for _ in 0..ROUNDS {
        ours.iter_mut().try_for_each(Ours::time)?;
        if let Some((peers, _)) = &mut peers {
            for theirs in &mut theirs {
                let found = peers.ask(&format!("run {}", theirs.name))?;
                theirs.shortest_s = theirs.shortest_s.min(number(&found["seconds"])?);
                theirs.computed_s = theirs.computed_s.min(number(&found["computed"])?);
                theirs.cost = number(&found["cost"])?;
                theirs.simulations = format!("{} simulations", found["simulations"]);
            }
        }
    }
    Ok(theirs)
}

/// This part of the comparison.
pub(crate) fn part() -> Result<Part, Box<dyn Error>> {
    let mut part = Part { text: "## A refit\n\n".to_owned(), wanted: Vec::new() };
    let Some(case) = shared(CASE) else {
        writeln!(part.text, "Left out: the recordings of `{CASE}` are not at hand.")?;
        return Ok(part);
    };
    let noise = Refit::read(&case)?;
    let norms = noise.clone().as_the_peers();
    let mut ours = [
        Ours::new("**`identification::fit`, one thread**", &norms, 1)?,
        Ours::new("**`identification::fit`, two threads**", &norms, 2)?,
        Ours::new("**`identification::fit` with the tool's own residuals, two threads**", &noise, 2)?,
    ];
    let mut peers = Peers::start("fit.py")?;
    let theirs = turns(&mut ours, peers.as_mut())?;
    let best = theirs.iter().map(|theirs| theirs.shortest_s).fold(f64::INFINITY, f64::min);
    let line = |name: String, shortest_s: f64, computed_s: f64, evaluations: String, [own, cost]: [String; 2]| {
        let ratio = if best.is_finite() { format!("{:.2}", best / shortest_s) } else { "–".to_owned() };
        vec![
            name,
            format!("{:.1}", 1e3 * shortest_s),
            format!("{:.1}", 1e3 * computed_s),
            ratio,
            evaluations,
            own,
            cost,
        ]
    };
    let mut lines = Vec::new();
    for ours in &ours {
        let End { machine, evaluations, cost: own } = ours.end.as_ref().ok_or("it was run")?;
        let cost = match &mut peers {
            Some((peers, _)) => {
                let values: Vec<String> = FREE.iter().map(|&parameter| machine.get(parameter).to_string()).collect();
                format!("{:.4e}", number(&peers.ask(&format!("cost {}", values.join(" ")))?["cost"])?)
            }
            None => "–".to_owned(),
        };
        let evaluations = format!("{evaluations} simulations with derivatives");
        let own = own.map_or("–".to_owned(), |own| format!("{own:.4e}"));
        lines.push(line(ours.name.to_owned(), ours.shortest_s, ours.computed_s, evaluations, [own, cost]));
    }
    for theirs in &theirs {
        let name = format!("SciPy `least_squares`, {}", theirs.name);
        let cost = format!("{:.4e}", theirs.cost);
        lines.push(line(name, theirs.shortest_s, theirs.computed_s, theirs.simulations.clone(), [cost.clone(), cost]));
    }
    writeln!(
        part.text,
        "Ten parameters on the {} rows of the four training recordings of `{CASE}`, spool and position; all start from the nominal values and none comes near its\n\
         bounds (theirs 0.3 to 3 times the nominal value, ours those of each parameter). The residuals are the peers': plain squares, each channel by its norm; both start\n\
         each recording from the same state. Their derivatives are differences of the Numba model, RK4 with one substep, one BLAS thread; ours are exact. The cost is\n\
         that of the peers' residuals, once with the model that was fitted, once with the peers' at the parameters that were found: the models differ within a tick. The\n\
         tool's own residuals are robust and by each channel's noise, and its starts are free. Shortest of {ROUNDS} rounds.\n",
        noise.rows()
    )?;
    let head = [
        "what",
        "ms",
        "ms, of all threads",
        "times as fast as the faster of the peers'",
        "each recording",
        "cost at the end, own model",
        "peers' model",
    ];
    write!(part.text, "{}", table(&head, &lines))?;
    if best.is_finite() {
        for ours in ours.iter().take(2) {
            let faster = best / ours.shortest_s;
            part.wanted.push(Wanted {
                what: format!("a refit of ten parameters, {}", ours.name.trim_matches('*')),
                aim: "5 times as fast as SciPy's".to_owned(),
                found: format!("{faster:.2} times"),
                is_met: faster >= 5.0,
            });
        }
    }
    if let Some((_, said)) = &peers {
        let peak = number(&said["peak_kb"])? / 1024.0;
        writeln!(
            part.text,
            "\nMost memory of the peers' process: {peak:.0} MB; of ours, which also reads and writes files, see below."
        )?;
    }
    Ok(part)
}
