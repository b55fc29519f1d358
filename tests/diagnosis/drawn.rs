//! Drawn drives with a known truth: the right effect is accepted, or nothing.

use std::collections::BTreeMap;
use std::time::Instant;

use rayon::prelude::*;

use diagnosis::Verdict;

use super::bed::{Dice, accepted, effect, pump_case, valve_case};

const KINDS: [&str; 4] = ["none", "internal-leakage", "coulomb-friction", "hose-compliance"];

/// One drawn case and the diagnosis of it.
struct Said {
    truth: &'static str,
    case: String,
    accepted: String,
    verdict: Verdict,
}

fn valve(truth: &'static str, seed: u64, pressures: bool) -> Said {
    let start = Instant::now();
    let put_in = effect(truth, &mut Dice::new(7 * seed + 3));
    let diagnosis = valve_case(seed, put_in, pressures, None).diagnose();
    said(truth, format!("seed {seed}, pressures {pressures}, {put_in:?}"), &diagnosis, start)
}

fn pump(truth: &'static str, seed: u64) -> Said {
    let start = Instant::now();
    let put_in = effect(truth, &mut Dice::new(7 * seed + 3));
    let diagnosis = pump_case(seed, put_in).diagnose();
    said(truth, format!("pump, seed {seed}, {put_in:?}"), &diagnosis, start)
}

fn said(truth: &'static str, case: String, diagnosis: &diagnosis::Diagnosis, start: Instant) -> Said {
    let found: Vec<String> = diagnosis
        .findings
        .iter()
        .flat_map(|finding| &finding.parameters)
        .map(|estimate| format!("{:.4e} ± {:.1e}", estimate.value, estimate.std))
        .collect();
    let accepted = accepted(diagnosis);
    println!(
        "{case}: {accepted} {found:?}, {:?}, {:?}, {:.1} s",
        diagnosis.verdict,
        diagnosis.not_confirmed.iter().map(|effect| effect.name).collect::<Vec<_>>(),
        start.elapsed().as_secs_f64()
    );
    Said { truth, case, accepted, verdict: diagnosis.verdict }
}

/// Prints how often each truth got which answer.
fn table(said: &[Said]) {
    let mut counts: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for said in said {
        *counts.entry((said.truth, &said.accepted)).or_default() += 1;
    }
    println!("{:>18} | {:<38} | cases", "put in", "accepted");
    for ((truth, accepted), count) in counts {
        println!("{truth:>18} | {accepted:<38} | {count}");
    }
}

fn count(said: &[Said], wanted: impl Fn(&Said) -> bool) -> usize {
    said.iter().filter(|said| wanted(said)).count()
}

#[test]
fn a_drawn_valve_drive_is_given_its_own_effect_and_none_where_nothing_was_put_in() {
    let mut draws: Vec<(&str, u64)> = KINDS.iter().flat_map(|&kind| [1, 2, 3].map(|seed| (kind, seed))).collect();
    // On this one the search once stopped at a bound of the pressure level, and hose compliance was wrongly accepted.
    draws.push(("none", 121));
    let said: Vec<Said> =
        draws.par_iter().map(|&(kind, seed)| valve(kind, seed, seed % 2 == 1 && seed < 100)).collect();
    table(&said);
    for said in said.iter().filter(|said| said.truth == "none") {
        assert_eq!((said.accepted.as_str(), said.verdict), ("none", Verdict::NothingMissing), "{}", said.case);
    }
    assert_eq!(count(&said, |said| said.accepted != said.truth && said.accepted != "none"), 0);
    assert!(count(&said, |said| said.truth != "none" && said.accepted == said.truth) >= 6);
}

#[test]
fn a_pump_that_slips_under_a_recorded_force_is_found() {
    let said = [pump("pump-slip", 1), pump("none", 2)];
    table(&said);
    for said in &said {
        assert_eq!(said.accepted, said.truth, "{}", said.case);
    }
}

/// Many drives, for the rates in the notes:
/// `cargo test --release -p system-tests --test diagnosis many_drawn -- --ignored --nocapture`
#[test]
#[ignore = "minutes: 40 drives with nothing missing, 40 with an effect, 8 with a pump"]
fn many_drawn_drives_are_given_their_own_effect_or_none() {
    let start = Instant::now();
    let nothing: Vec<Said> = (100..140_u64).into_par_iter().map(|seed| valve("none", seed, seed % 2 == 0)).collect();
    table(&nothing);
    let alarms = count(&nothing, |said| said.accepted != "none");
    let followed = count(&nothing, |said| said.verdict == Verdict::NothingMissing);
    println!("false alarms {alarms}/40, nothing missing {followed}/40, {:.0} s", start.elapsed().as_secs_f64());
    let effects: Vec<Said> = (200..240_usize)
        .into_par_iter()
        .map(|seed| valve(KINDS[1 + seed % 3], seed as u64, (seed / 3) % 2 == 0))
        .collect();
    table(&effects);
    let right = count(&effects, |said| said.accepted == said.truth);
    let wrong = count(&effects, |said| said.accepted != "none" && !said.accepted.contains(said.truth));
    // The test bed's effects have other forms than the hypotheses; a second effect may explain the misfit that this leaves.
    let more = count(&effects, |said| said.accepted != said.truth && said.accepted.contains(said.truth));
    println!("right {right}/40, more {more}/40, wrong {wrong}/40, {:.0} s", start.elapsed().as_secs_f64());
    let kinds = ["pump-slip", "none", "internal-leakage", "hose-compliance"];
    let pumps: Vec<Said> = (300..308_usize).into_par_iter().map(|seed| pump(kinds[seed % 4], seed as u64)).collect();
    table(&pumps);
    println!("all in {:.0} s", start.elapsed().as_secs_f64());
    assert!(alarms <= 1, "{alarms} of 40");
    assert!(wrong <= 1, "{wrong} of 40");
}
