//! Threads change nothing: a diagnosis in a pool of one thread is the same as in one of two, or of five, to the last bit of every number.

use report::evidence::Exhibits;
use report::json::diagnosis;

use super::bed::{Case, Dice, effect, pump_case, valve_case};

/// The complete result as text: each number as the shortest one that reads back to the same bits.
fn found(case: &Case, threads: usize) -> [String; 2] {
    let run = || {
        let diagnosis = case.diagnose();
        let exhibits = Exhibits::of(&case.file, &case.training, &case.held_out, &diagnosis, true).unwrap();
        [format!("{diagnosis:?}"), diagnosis::document(&diagnosis, &exhibits).to_string()]
    };
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
}

#[test]
fn one_thread_finds_what_more_find() {
    let valve = |name, seed| valve_case(seed, effect(name, &mut Dice::new(7 * seed + 3)), seed % 2 == 1, None);
    let pump = |name, seed| pump_case(seed, effect(name, &mut Dice::new(7 * seed + 3)));
    let cases = [valve("internal-leakage", 401), valve("none", 402), pump("pump-slip", 403)];
    for (index, case) in cases.iter().enumerate() {
        let [one, one_written] = found(case, 1);
        // For the first case, also more threads than there are processors.
        let pools: &[usize] = if index == 0 { &[2, 5] } else { &[2] };
        for &threads in pools {
            let [more, more_written] = found(case, threads);
            assert_eq!(one.len(), more.len(), "case {index}, {threads} threads");
            let differs = one.bytes().zip(more.bytes()).position(|(one, more)| one != more);
            assert_eq!(differs.map(|at| (&one[at..], &more[at..])), None, "case {index}, {threads} threads");
            assert!(one_written == more_written, "case {index}, {threads} threads: the document");
        }
    }
}
