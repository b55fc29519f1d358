//! A search that its limit has ended: what it did not try, and what was slow.

use diagnosis::selection::{Searched, Selection, Stage};
use recording::display_unit::significant;

/// What stands first where a search did not come to its own end; `None` where it did.
#[must_use]
pub fn limit_reached(searched: &Searched) -> Option<String> {
    if searched.is_finished() {
        return None;
    }
    let limit = searched.limit_s.map_or_else(String::new, |limit_s| format!(" of {} s", significant(limit_s, 3)));
    Some(format!("the search reached its limit{limit} before everything was tried, so nothing is claimed"))
}

/// What a search left out by its limit, in a sentence: nothing is claimed then, unless tables alone were left out, which change no verdict.
#[must_use]
pub fn left_out(searched: &Searched) -> Option<String> {
    let tables = || format!("the search reached its limit before {} were tried", stage(Stage::Tables));
    limit_reached(searched).or_else(|| (!searched.left_out.is_empty()).then(tables))
}

/// What was not tried, or not to the end.
#[must_use]
pub fn not_tried(searched: &Searched) -> Vec<String> {
    searched.left_out.iter().map(|left| stage(*left)).collect()
}

/// What each part cost, the dearest first, in seconds on two cores.
#[must_use]
pub fn spent(searched: &Searched) -> Vec<(String, f64)> {
    let mut parts = searched.spent_s.clone();
    parts.retain(|(_, spent_s)| *spent_s > 0.0);
    parts.sort_by(|a, b| b.1.total_cmp(&a.1));
    parts.into_iter().map(|(part, spent_s)| (stage(part), spent_s)).collect()
}

/// The same in a sentence.
#[must_use]
pub fn slow(searched: &Searched) -> String {
    let each = |(part, spent_s): (String, f64)| format!("{part} {} s", significant(spent_s, 2));
    spent(searched).into_iter().map(each).collect::<Vec<_>>().join(", ")
}

/// The likeliest candidate model so far. It is no finding.
#[must_use]
pub fn best_so_far(selection: &Selection) -> Option<String> {
    let trials = selection.rounds.iter().flatten().filter(|trial| trial.net > 0.0);
    let best = trials.max_by(|a, b| a.net.total_cmp(&b.net))?;
    let effects: Vec<&str> = best.effects.iter().map(|effect| effect.name).collect();
    Some(format!(
        "{} (log-likelihood gain {}): no finding, as not everything was tried",
        effects.join(" + "),
        significant(best.net, 3)
    ))
}

/// A part of the search.
#[must_use]
fn stage(stage: Stage) -> String {
    match stage {
        Stage::Base => "refit of the base parameters".to_owned(),
        Stage::Sides => "valve and what is below its spool, each by itself".to_owned(),
        Stage::Effects(1) => "single effects".to_owned(),
        Stage::Effects(2) => "pairs of effects".to_owned(),
        Stage::Effects(count) => format!("{count} effects together"),
        Stage::Slow => "effects that act over time, on the whole recordings".to_owned(),
        Stage::Jumps => "jumps of a spool that is not recorded".to_owned(),
        Stage::Outside => "causes outside the drive".to_owned(),
        Stage::Gains => "forces by what velocity and position gain".to_owned(),
        Stage::Tables => "correction tables".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unfinished_search_says_what_it_left_out_and_what_was_slow() {
        let mut searched = Searched { limit_s: Some(5.0), ..Searched::default() };
        assert_eq!(limit_reached(&searched), None);
        searched.spent_s = vec![(Stage::Base, 1.3), (Stage::Effects(1), 3.9)];
        searched.left_out = vec![Stage::Effects(2), Stage::Outside];
        let first = limit_reached(&searched).unwrap();
        assert_eq!(first, "the search reached its limit of 5.00 s before everything was tried, so nothing is claimed");
        assert_eq!(not_tried(&searched), ["pairs of effects", "causes outside the drive"]);
        assert_eq!(slow(&searched), "single effects 3.9 s, refit of the base parameters 1.3 s");
    }
}
