//! The page: the drives by urgency, and every amount over time as small charts.

use maud::{Markup, PreEscaped, html};

use fleet::Judgement;
use jiff::civil::Date;
use model_core::machine::Parameter;
use report::html::{About, document};
use report::plot::{Multiple, Piece, multiple};

use crate::trend::Trend;
use crate::wear::{Urgency, Wear, Wears, date_of};
use crate::words::{headline, limit, name, now, state, to_limit};

/// As many charts are drawn, the most urgent ones first: the page stays small.
const DRAWN: usize = 300;

/// The page of a hall.
#[must_use]
pub fn page(wears: &Wears, about: &About) -> String {
    let moving: Vec<&Wear> = wears.moving().collect();
    let top = html! {
        h1 class=(if moving.is_empty() { "nothing" } else { "missing" }) { (headline(wears)) "." }
        @if !wears.no_dates.is_empty() {
            p class="fact" { "Nights whose names are no dates are left out: " (shown(wears.no_dates.iter())) @if wears.no_dates.len() > SHOWN { " and others" } "." }
        }
    };
    let rest = html! {
        (urgent(wears, &moving))
        (charts(wears, "What has changed, or is beyond its limit", &moving))
        (charts(wears, "What is steady", &wears.all.iter().filter(|wear| wear.urgency.is_steady()).collect::<Vec<_>>()))
        (drives(wears))
        section {
            h2 { "How it is told" }
            p { "A dot is one night with its standard deviation, as the recordings of that night tell it; a night that does not tell the amount has no dot. A hollow dot is far from its neighbours on both sides and takes no part. "
                "The nights are cut into levels and straight lines by optimal partitioning (Jackson et al. 2005): a piece more, or a rate, must explain more than chance would. In a hall in which nothing changes and nights do not depend on each other, a jump is told in one of a hundred, and a rate in one of a hundred. "
                "Deviations are widened where nights scatter more than their recordings say. The day on which a limit is reached is where the line meets it; earliest and latest are where its 95 % band does, if it goes on as it does now." }
        }
    };
    document("Wear of a hall", (about, &[]), &top, &rest)
}

/// As many names are shown.
const SHOWN: usize = 5;

/// The first of some names.
fn shown<'a>(names: impl Iterator<Item = &'a String>) -> String {
    names.take(SHOWN).map(String::as_str).collect::<Vec<_>>().join(", ")
}

fn urgent(wears: &Wears, moving: &[&Wear]) -> Markup {
    html! {
        @if !moving.is_empty() {
            section {
                h2 { "By urgency" }
                table class="wide" {
                    tr { th { "drive" } th class="text" { "effect" } th class="text" { "now" } th class="text" { "trend" } th class="text" { "limit, and when it is reached" } }
                    @for wear in moving {
                        tr { td { (wear.drive) } td class="text" { (name(wear.parameter)) } td class="text" { (now(wears, wear)) }
                            td class="text" { (with_dates(&state(wears, wear))) } td class="text" { (with_dates(&limit(wear))) @if !to_limit(wears, wear).is_empty() { ": " (with_dates(&to_limit(wears, wear))) } } }
                    }
                }
            }
        }
    }
}

/// A sentence whose dates are not broken at the end of a line.
fn with_dates(text: &str) -> Markup {
    let is_date = |word: &str| word.trim_end_matches(',').parse::<Date>().is_ok();
    html! { @for word in text.split_inclusive(' ') { @if is_date(word.trim_end()) { span class="whole" { (word) } } @else { (word) } } }
}

fn charts(wears: &Wears, title: &str, of: &[&Wear]) -> Markup {
    html! {
        @if !of.is_empty() {
            section {
                h2 { (title) }
                div class="multiples" { @for wear in of.iter().take(DRAWN) { figure { (PreEscaped(multiple(&chart(wears, wear)))) } } }
                @if of.len() > DRAWN { p class="soft" { (of.len() - DRAWN) " more are not drawn, so that the page stays small." } }
            }
        }
    }
}

/// One amount over time. All charts have the same days.
fn chart(wears: &Wears, wear: &Wear) -> Multiple {
    let trend = &wear.trend;
    let days = (crate::wear::day_of(wears.nights.0), crate::wear::day_of(wears.nights.1));
    let piece = |piece: &crate::Piece| {
        let (from, to) = trend.days(piece);
        Piece { ends: [(from, piece.line.at(from).0), (to, piece.line.at(to).0)] }
    };
    let continued = |reach_day: f64| {
        let now = trend.now()?;
        let last = trend.last_day();
        Some([(last, now.line.at(last).0), (reach_day, now.line.at(reach_day).0)])
    };
    Multiple {
        title: wear.drive.clone(),
        subtitle: name(wear.parameter),
        unit: wear.parameter.description().unit.to_owned(),
        usual: usual(wears, wear.parameter),
        days,
        ends: [wears.nights.0.to_string(), wears.nights.1.to_string()],
        points: points(trend),
        pieces: trend.pieces.iter().map(piece).collect(),
        changes: trend.changes.clone(),
        limit: wear.limit.map(|limit| if value_now(trend) < 0.0 { -limit.value } else { limit.value }),
        is_urgent: !wear.urgency.is_steady(),
        ahead: match wear.urgency {
            Urgency::Reaches(reach) => {
                continued(reach.expected).zip(date_of(reach.expected)).map(|(line, date)| (line, date.to_string()))
            }
            _ => None,
        },
    }
}

/// The largest magnitude of an amount in the hall's last nights: charts of the same amount have the same power of ten.
fn usual(wears: &Wears, parameter: Parameter) -> f64 {
    let own = wears.all.iter().filter(|wear| wear.parameter == parameter);
    own.map(|wear| value_now(&wear.trend).abs()).fold(0.0, f64::max)
}

fn value_now(trend: &Trend) -> f64 {
    trend.now().map_or(0.0, |piece| piece.line.at(trend.last_day()).0)
}

fn points(trend: &Trend) -> Vec<report::plot::Amount> {
    let of = trend.points.iter().zip(&trend.odd);
    of.map(|(point, odd)| report::plot::Amount { day: point.day, value: point.value, std: point.std, is_odd: *odd })
        .collect()
}

/// How the nights of every drive ended.
fn drives(wears: &Wears) -> Markup {
    let usual = [Judgement::InBand, Judgement::Unchanged];
    let others: Vec<Judgement> = Judgement::ALL.into_iter().filter(|one| !usual.contains(one)).collect();
    let told = |judgement: Judgement| wears.drives.values().any(|tally| tally.of(judgement) > 0);
    let columns: Vec<Judgement> = usual.into_iter().chain(others.iter().copied().filter(|one| told(*one))).collect();
    let (quiet, rest): (Vec<_>, Vec<_>) =
        wears.drives.iter().partition(|(_, tally)| others.iter().all(|one| tally.of(*one) == 0));
    html! {
        section {
            h2 { "Nights of every drive" }
            @if !rest.is_empty() {
                table class="wide" {
                    tr { th { "drive" } @for column in &columns { th { (column.name()) } } }
                    @for (drive, tally) in &rest { tr { td { (drive) } @for column in &columns { td { (tally.of(*column)) } } } }
                }
            }
            p class="soft" { (quiet.len()) " of " (wears.drives.len()) " drives were in their band or unchanged in every night." }
        }
    }
}
