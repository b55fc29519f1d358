//! What was said of the drives, kind by kind.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::{Value, json};

use diagnosis::catalogue::CATALOGUE;
use diagnosis::{Diagnosis, Verdict};

/// What was said of a drive.
pub(super) struct Said {
    pub(super) case: String,
    /// What is the matter with it.
    pub(super) what: &'static str,
    /// Names that are true of it.
    right: &'static [&'static str],
    pub(super) claims: Vec<&'static str>,
    pub(super) verdict: Verdict,
    /// Error of the worst signal of the held-out recording, over its noise, with the model that the diagnosis ends with.
    pub(super) worst: f64,
}

impl Said {
    pub(super) fn of(case: String, what: &'static str, right: &'static [&'static str], diagnosis: &Diagnosis) -> Self {
        let claims = diagnosis.findings.iter().map(|finding| finding.effect.name).collect();
        Self { case, what, right, claims, verdict: diagnosis.verdict, worst: worst(diagnosis) }
    }

    /// What [`Said::read`] reads.
    pub(super) fn written(&self) -> String {
        json!({ "claims": self.claims, "verdict": format!("{:?}", self.verdict), "worst": self.worst }).to_string()
    }

    /// What was written of a case.
    pub(super) fn read(text: &str, case: &str, what: &'static str, right: &'static [&'static str]) -> Self {
        let said: Value = serde_json::from_str(text).unwrap_or_else(|error| panic!("{case}: {error}"));
        let name = |claim: &Value| CATALOGUE.iter().map(|effect| effect.name).find(|name| *claim == **name);
        let is_it = |verdict: &Verdict| said["verdict"] == format!("{verdict:?}");
        let verdicts = [Verdict::NothingMissing, Verdict::Unexplained, Verdict::MissingPhysics];
        let claims: Option<Vec<&str>> = said["claims"].as_array().and_then(|all| all.iter().map(name).collect());
        let Some((claims, verdict)) = claims.zip(verdicts.into_iter().find(is_it)) else {
            panic!("{case}: found {text}")
        };
        // What is not finite is written as null.
        let worst = said["worst"].as_f64().unwrap_or(f64::INFINITY);
        Self { case: case.to_owned(), what, right, claims, verdict, worst }
    }

    /// What is claimed and not true.
    pub(super) fn falsely(&self) -> impl Iterator<Item = &'static str> {
        self.claims.iter().copied().filter(|claim| !self.right.contains(claim))
    }

    pub(super) fn found(&self) -> bool {
        self.claims.iter().any(|claim| self.right.contains(claim))
    }

    pub(super) fn line(&self) -> String {
        let claims = if self.claims.is_empty() { "none".to_owned() } else { self.claims.join(" + ") };
        format!("{}: {claims}, {:?}, {:.2}", self.case, self.verdict, self.worst)
    }
}

fn worst(diagnosis: &Diagnosis) -> f64 {
    let held_out = diagnosis.shown.iter().filter(|shown| shown.held_out);
    let errors = held_out.flat_map(|shown| {
        shown.prepared.channels.iter().filter_map(|channel| {
            let simulated = shown.after.signal(channel.signal)?;
            let rows = channel.recorded.iter().zip(simulated).zip(&channel.failed).skip(shown.prepared.unsettled);
            let kept: Vec<f64> = rows.filter(|(_, failed)| !**failed).map(|((is, would), _)| is - would).collect();
            let square = kept.iter().map(|error| error * error).sum::<f64>() / kept.len().max(1) as f64;
            Some(square.sqrt() / channel.noise)
        })
    });
    errors.fold(0.0, f64::max)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// One row for each kind, in the order in which they come, and the names that were claimed.
pub(super) fn table(said: &[Said]) -> String {
    let mut kinds: Vec<&str> = Vec::new();
    for said in said {
        if !kinds.contains(&said.what) {
            kinds.push(said.what);
        }
    }
    let mut text = format!(
        "{:<36}{:>8}{:>8}{:>8}{:>9}{:>13}{:>9}{:>8}\n",
        "what is the matter", "drives", "found", "false", "nothing", "unexplained", "missing", "error"
    );
    for kind in kinds {
        let of: Vec<&Said> = said.iter().filter(|said| said.what == kind).collect();
        let ended = |verdict: Verdict| of.iter().filter(|said| said.verdict == verdict).count();
        let found = of.iter().filter(|said| said.found()).count();
        let falsely = of.iter().filter(|said| said.falsely().next().is_some()).count();
        let error = median(of.iter().map(|said| said.worst).collect());
        let _ = writeln!(
            text,
            "{kind:<36}{:>8}{found:>8}{falsely:>8}{:>9}{:>13}{:>9}{error:>8.1}",
            of.len(),
            ended(Verdict::NothingMissing),
            ended(Verdict::Unexplained),
            ended(Verdict::MissingPhysics),
        );
    }
    let mut names: BTreeMap<(&str, &str), Vec<&str>> = BTreeMap::new();
    for said in said {
        for name in said.falsely() {
            names.entry((said.what, name)).or_default().push(&said.case);
        }
    }
    for ((what, name), cases) in names {
        let _ = writeln!(text, "{name} falsely claimed of {what}: {}", cases.join(", "));
    }
    text
}
