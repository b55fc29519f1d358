//! Every drive on the paper's signals and on random steps, at 1 kHz.

use model_core::machine::{Machine, Tick};
use model_core::number::{PerUnit, Single};
use recording::excitation::signals::Excitation;
use system_tests::drives;
use system_tests::simulate::{Distance, core, oracle};
use virtual_plant::InitialState;

use crate::table::{self, TableLine, five};
use crate::tolerances::{Case, of};

const TICK: Tick = Tick::OneMillisecond;

/// Seeds 1 to this; none was chosen.
const SEEDS: u64 = 40;

/// Where every run starts, m.
const START_M: f64 = 0.15;

fn compare(machine: &Machine<f64>, excitation: &Excitation) -> [Distance; 5] {
    let volts = excitation.sample(TICK.seconds());
    let initial = InitialState::at_rest(machine, START_M);
    let truth = oracle(machine, TICK, &volts, &initial);
    let real = core::<f64>(machine, TICK, &volts, &initial);
    let fixed = core::<PerUnit>(machine, TICK, &volts, &initial);
    let single = core::<Single>(machine, TICK, &volts, &initial);
    five(&truth, &real, &fixed, &single)
}

fn check(line: &TableLine, case: Case) {
    line.check(of(case), of(Case::Rounding));
}

#[test]
fn the_core_follows_the_oracle_on_every_signal() {
    let mut lines = Vec::new();
    for drive in drives::named() {
        let mut add = |signal: String, found: [Distance; 5], case| {
            lines.push((TableLine::of(drive.name, signal, found), case));
        };
        for volts in [2, 4, 6, 8, 10] {
            let found = compare(&drive.machine, &Excitation::paper_steps(f64::from(volts)));
            add(format!("steps {volts} V"), found, Case::StepsAndSweep);
        }
        add("sweep".to_owned(), compare(&drive.machine, &Excitation::paper_sweep()), Case::StepsAndSweep);
        let mut worst = [Distance::default(); 5];
        for seed in 1..=SEEDS {
            let found = compare(&drive.machine, &Excitation::random_steps(seed));
            worst = std::array::from_fn(|index| worst[index].or(found[index]));
            if seed == 1 {
                add("random, seed 1".to_owned(), found, Case::RandomSteps);
            }
        }
        add(format!("random, worst of {SEEDS}"), worst, Case::RandomSteps);
    }
    for (line, case) in &lines {
        check(line, *case);
    }
    table::compare("table.txt", &lines.into_iter().map(|(line, _)| line).collect::<Vec<_>>());
}
