//! What is said of wear.

use std::collections::BTreeSet;

use diagnosis::catalogue::CATALOGUE;
use model_core::machine::Parameter;
use recording::display_unit::in_si;
use report::{size, wording};

use crate::wear::{Given, Urgency, Wear, Wears, date_of, day_of};

/// What is said of a hall.
#[must_use]
pub fn headline(wears: &Wears) -> String {
    let drives = wears.drives.len();
    let (from, to) = wears.nights;
    let of = format!("{drives} drive{}, {from} to {to}", if drives == 1 { "" } else { "s" });
    let Some(first) = wears.moving().next() else {
        return if wears.all.is_empty() {
            format!("no night tells how much there is of any effect: {of}")
        } else {
            format!("no effect of any drive has changed: {of}")
        };
    };
    let worn: BTreeSet<&str> = wears.moving().map(|wear| &*wear.drive).collect();
    let whose = name(first.parameter);
    let most = match first.urgency {
        Urgency::Reached => format!("{} first, whose {whose} is beyond its limit", first.drive),
        Urgency::Reaches(_) => {
            format!("{} first, whose {whose} reaches its limit {}", first.drive, to_limit(wears, first))
        }
        _ => format!("{} first, whose {whose} {}", first.drive, state(wears, first)),
    };
    let (verb, are) = if worn.len() == 1 { ("has", "is") } else { ("have", "are") };
    let beyond = wears.all.iter().any(|wear| wear.urgency == Urgency::Reached);
    let beyond = if beyond { format!(" or {are} beyond a limit") } else { String::new() };
    format!("{} of {of}, {verb} changed{beyond}: {most}", worn.len())
}

/// An effect, with the name of the amount where it has several.
#[must_use]
pub fn name(parameter: Parameter) -> String {
    let effect = CATALOGUE.iter().find(|effect| effect.effect_parameters().any(|own| own.parameter == parameter));
    effect.map_or_else(|| parameter.description().key.to_owned(), |effect| wording::whose(effect, parameter))
}

fn unit(parameter: Parameter) -> String {
    let unit = parameter.description().unit;
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

/// How much there is now: `3.94e-12 ± 2e-14 m3/s/Pa (1.7 l/min …)`.
#[must_use]
pub fn now(wears: &Wears, wear: &Wear) -> String {
    let Some(piece) = wear.trend.now() else { return String::new() };
    let (value, std) = piece.line.at(wear.trend.last_day());
    let machine = wears.machines.get(&wear.drive).map(|file| &file.machine);
    let size = machine.and_then(|machine| size::size(machine, wear.parameter, value));
    let size = size.map_or_else(String::new, |size| format!(" ({size})"));
    format!("{} ± {}{}{size}", in_si(value, 3), in_si(std, 2), unit(wear.parameter))
}

/// Amounts whose size is no multiple of their value: a rate has none.
const NOT_LINEAR: [Parameter; 2] = [Parameter::SolenoidCurvature, Parameter::LaminarPressure];

/// How it has changed: `grows by 2.1e-13 ± 1e-14 m3/s/Pa a month since 2026-11-03`.
#[must_use]
pub fn state(wears: &Wears, wear: &Wear) -> String {
    let (trend, unit) = (&wear.trend, unit(wear.parameter));
    let Some(piece) = trend.now() else { return String::new() };
    let (first, last) = trend.days(piece);
    let day = |day: f64| date_of(day).map_or_else(String::new, |date| date.to_string());
    if trend.is_told_once(day_of(wears.nights.1)) {
        return format!("told in the night of {} alone", day(last));
    }
    let (rate, rate_std) = piece.line.per_month();
    let (value, std) = piece.line.at(last);
    if piece.grows {
        let verb = if value * rate > 0.0 { "grows" } else { "falls" };
        let size = wears.machines.get(&wear.drive).filter(|_| !NOT_LINEAR.contains(&wear.parameter));
        let size = size.and_then(|file| size::size(&file.machine, wear.parameter, rate.abs()));
        let size = size.map_or_else(String::new, |size| format!(" ({})", size.amount));
        // Of what grows from the first night on nobody knows since when.
        let least = if trend.pieces.len() == 1 { "at least " } else { "" };
        let by = format!("{} ± {}{unit}{size}", in_si(rate.abs(), 2), in_si(rate_std, 1));
        return format!("{verb} by {by} a month since {least}{}", day(first));
    }
    let before = trend.pieces.len().checked_sub(2).and_then(|index| trend.pieces.get(index));
    let Some(before) = before else { return "steady".to_owned() };
    let (then, then_std) = before.line.at(trend.days(before).1);
    if before.grows && (value - then).abs() <= 3.0 * libm::hypot(std, then_std) {
        return format!("has not changed any more since {}", day(first));
    }
    format!("jumped from {} to {}{unit} on {}", in_si(then, 3), in_si(value, 3), day(first))
}

/// When it reaches its limit: `about 2026-12-20, earliest 2026-12-11, latest 2027-01-06`.
#[must_use]
pub fn to_limit(wears: &Wears, wear: &Wear) -> String {
    let day = |day: f64| date_of(day).map_or_else(|| "later than any date".to_owned(), |date| date.to_string());
    match wear.urgency {
        Urgency::Reached => "exceeded".to_owned(),
        // Since then no night has told it.
        Urgency::Reaches(reach) if reach.expected < day_of(wears.nights.1) => {
            format!("should have been reached by {}", day(reach.expected))
        }
        Urgency::Reaches(reach) => {
            let latest =
                reach.latest.map_or_else(|| "perhaps never".to_owned(), |late| format!("latest {}", day(late)));
            format!("about {}, earliest {}, {latest}", day(reach.expected), day(reach.earliest))
        }
        Urgency::Grows if wear.limit.is_some() => "later than can be told: beyond ten times the nights seen".to_owned(),
        _ => String::new(),
    }
}

/// Its limit: `4e-12 m3/s/Pa`, and who says so where it is not the user.
#[must_use]
pub fn limit(wear: &Wear) -> String {
    let worn = |given: Given| if given == Given::Worn { ", worn according to sources" } else { "" };
    wear.limit.map_or_else(
        || "none known".to_owned(),
        |limit| format!("{}{}{}", in_si(limit.value, 3), unit(wear.parameter), worn(limit.given)),
    )
}
