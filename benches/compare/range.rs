//! The range of parameters over which a step stays accurate: how far each step tolerates a deviation from a drive's own values.

use std::error::Error;

use system_benches::run::{Run, TICK};

use model_core::drive::Drive;
use model_core::machine::{Machine, Parameter as P};
use model_core::number::{PerUnit, Scalar};
use system_tests::simulate::DELAY;

use crate::accurate::{Off, Signals, judged, machine_of};
use crate::page::table;
use crate::peers::list;

/// Factors by which a parameter is changed.
const FACTORS: [f64; 12] = [1.05, 1.1, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0, 8.0, 16.0, 32.0];
/// Substeps of the opponents.
const SUBSTEPS: [u64; 3] = [2, 3, 4];
/// Signals under which both runs are judged.
const JUDGED: [&str; 2] = ["random", "step 10 V"];
const DRIVES: [&str; 2] = ["printed", "press"];

/// A change: its name in the peers' program, the change itself, and its name in a row.
type Change = (&'static str, fn(&Machine<f64>, f64) -> Machine<f64>, &'static str);

const CHANGES: [Change; 4] = [
    ("viscous friction", |machine, factor| scaled(machine, &[P::ViscousFriction], factor), "viscous friction, times"),
    ("bulk modulus", |machine, factor| scaled(machine, &[P::BulkModulus], factor), "bulk modulus, times"),
    ("moving mass", |machine, factor| scaled(machine, &[P::MovingMass], 1.0 / factor), "moving mass, divided by"),
    (
        "flow",
        |machine, factor| scaled(machine, &[P::FlowCoefficient, P::FlowLimit], factor),
        "the valve's flow and its limit, times",
    ),
];

fn scaled(machine: &Machine<f64>, parameters: &[P], factor: f64) -> Machine<f64> {
    let values: Vec<(P, f64)> =
        parameters.iter().map(|&parameter| (parameter, factor * machine.get(parameter))).collect();
    machine.with(&values)
}

/// Whether the core is accurate on a changed drive, by the references of both signals; false where the drive does not fit the format.
fn bears<N: Scalar<Real = f64>>(
    signals: &Signals,
    drive: &str,
    machine: &Machine<f64>,
    references: &serde_json::Value,
) -> Result<bool, Box<dyn Error>> {
    if Drive::<N>::new::<DELAY>(machine, TICK).is_err() {
        return Ok(false);
    }
    let run = Run::<N>::new(machine, &signals.initial(drive)?);
    let (mut worst, mut rows): (Off, _) = Default::default();
    for signal in JUDGED {
        run.any(&signals.volts(signal)?, &mut rows);
        worst = worst.or(Off::between(&rows, &judged(&references[signal])?, machine));
    }
    Ok(worst.is_accurate())
}

/// The largest factor of one change up to which each solver is accurate at all factors: f64, fixed point, RK4 with each number of substeps.
fn borne(signals: &mut Signals, drive: &str, (name, change, _): Change) -> Result<[f64; 5], Box<dyn Error>> {
    let mut borne = [1.0; 5];
    let mut still = [true; 5];
    for factor in FACTORS {
        let substeps: Vec<String> =
            SUBSTEPS.iter().zip(&still[2..]).filter(|(_, still)| **still).map(|(count, _)| count.to_string()).collect();
        let said = signals.ask(&format!("{drive}\t{name}\t{factor}\t{}", substeps.join(",")))?;
        if said["references"].is_null() {
            break;
        }
        let changed = change(&machine_of(drive)?, factor);
        let of_peers = list(&said["borne"])?;
        let now = [
            bears::<f64>(signals, drive, &changed, &said["references"])?,
            bears::<PerUnit>(signals, drive, &changed, &said["references"])?,
        ];
        let now = now.into_iter().chain(SUBSTEPS.map(|count| of_peers.contains(&count.into())));
        for ((still, borne), now) in still.iter_mut().zip(&mut borne).zip(now) {
            *still &= now;
            if *still {
                *borne = factor;
            }
        }
        if !still.contains(&true) {
            break;
        }
    }
    Ok(borne)
}

/// A row for each drive and parameter.
pub(crate) fn table_of(signals: &mut Signals) -> Result<String, Box<dyn Error>> {
    let mut lines = Vec::new();
    for drive in DRIVES {
        for change in CHANGES {
            let borne = borne(signals, drive, change)?;
            let shown = borne.iter().map(|factor| format!("{factor}"));
            lines.push([drive, change.2].map(str::to_owned).into_iter().chain(shown).collect());
        }
    }
    let head = [
        "drive",
        "bears",
        "**core, f64**",
        "**core, fixed point**",
        "RK4 C float, S=2",
        "RK4 C float, S=3",
        "RK4 C float, S=4",
    ];
    let [first, .., last] = FACTORS;
    let note = format!(
        "How far a parameter may be from the drive's own value and each still be accurate under the random steps and 10 V, by the reference of the changed drive:\n\
         of {} factors from {first} to {last} the last one before the first that is not borne. 1: none of them. The reference has 200 substeps, times the factor.\n\
         Where the fixed-point format does not hold a drive, building it is an error, and it is not borne. Ours is the step of a drive that may have any effect: with friction\n\
         so hard that h·D/m is beyond the format's gains the paper's model by itself is refused as well.\n",
        FACTORS.len(),
    );
    Ok(format!("{}\n{note}", table(&head, &lines)))
}
