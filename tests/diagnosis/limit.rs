//! A limit of the search: what it ends is the same on every machine, is told as unfinished, and claims nothing.

use diagnosis::{Diagnosis, Options, Verdict, diagnose_with};
use report::evidence::Exhibits;
use report::{html, json, terminal};

use super::bed::{Case, Dice, effect, valve_case};

fn within(case: &Case, limit_s: Option<f64>) -> Diagnosis {
    let options = Options { limit_s, ..Options::default() };
    diagnose_with(&case.file, (&case.training, &case.held_out), options, &|_| {}).unwrap()
}

fn leaking() -> Case {
    valve_case(401, effect("internal-leakage", &mut Dice::new(2810)), false, None)
}

fn exhibits(case: &Case, diagnosis: &Diagnosis) -> Exhibits {
    Exhibits::of(&case.file, &case.training, &case.held_out, diagnosis, true).unwrap()
}

#[test]
fn a_search_that_is_ended_by_its_limit_finds_the_same_with_any_number_of_threads() {
    let case = leaking();
    let whole_s = within(&case, None).selection.searched.all_s();
    for share in [0.3, 0.7] {
        let run = || format!("{:?}", within(&case, Some(share * whole_s)));
        let of = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run);
        let (one, three) = (of(1), of(3));
        assert!(one == three, "{share}");
    }
}

#[test]
fn a_search_that_is_ended_by_its_limit_claims_nothing_and_says_what_it_did_not_try() {
    for case in [leaking(), valve_case(402, None, false, None)] {
        let whole = within(&case, None);
        let whole_s = whole.selection.searched.all_s();
        assert!(whole.selection.searched.is_finished() && whole.verdict != Verdict::Unexplained, "{:?}", whole.verdict);
        let mut ended = 0;
        for share in [1e-3, 0.3, 0.6, 0.9] {
            let found = within(&case, Some(share * whole_s));
            let searched = &found.selection.searched;
            let told = exhibits(&case, &found);
            let (text, document) = (terminal::text(&found, &told), json::document(&found, &told));
            let page = html::page(&found, &told, &html::About::default());
            if searched.is_finished() {
                assert_eq!(found.verdict, whole.verdict, "{share}");
                assert!(document["unfinished"].is_null() && !text.contains("not tried"), "{text}");
                continue;
            }
            ended += 1;
            assert_eq!(found.verdict, Verdict::Unexplained, "{share}");
            assert!(found.findings.is_empty() && found.suspected.is_none() && found.outside.is_none(), "{share}");
            let first = text.lines().next().unwrap();
            assert!(first.contains("the search reached its limit of "), "{first}");
            assert!(!first.contains("confirmed") && !first.contains("nothing missing"), "{first}");
            assert!(!text.contains("no effect of the catalogue explains"), "{text}");
            assert!(text.contains("\nnot tried  ") && text.contains("\nslow       "), "{text}");
            assert!(!page.contains("No effect that was tried explains"), "{share}");
            assert!(!text.contains("\nstructure  ") && document["structure"].is_null(), "{text}");
            assert!(page.contains("reached its limit") && !page.contains("confirmed on"), "{share}");
            let unfinished = &document["unfinished"];
            assert!(!unfinished["not_tried"].as_array().unwrap().is_empty(), "{unfinished}");
            assert!(unfinished["spent"].as_array().unwrap().iter().all(|part| part["seconds"].as_f64().unwrap() > 0.0));
            assert_eq!(document["findings"].as_array().map(Vec::len), Some(0), "{document}");
        }
        assert!(ended > 1, "{ended}");
    }
}

#[test]
fn a_limit_is_exceeded_by_no_more_than_a_step() {
    // The limit is kept but for the step that a search is in: the base is always refitted.
    let case = leaking();
    let whole_s = within(&case, None).selection.searched.all_s();
    let half = within(&case, Some(0.5 * whole_s)).selection.searched.all_s();
    assert!(half < 0.8 * whole_s, "{half} of {whole_s}");
}
