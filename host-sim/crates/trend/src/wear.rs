//! Every amount of every drive of a table, with its limit, the most urgent first.

use std::collections::{BTreeMap, BTreeSet};

use diagnosis::catalogue::CATALOGUE;
use fleet::{Row, Tally, column_of};
use jiff::civil::Date;
use machine_file::MachineFile;
use model_core::machine::{Machine, Parameter};
use report::size;

use crate::line::{Point, Reach};
use crate::trend::{Trend, scatters, squares, telling};

/// The day that days are counted from.
const FIRST: Date = jiff::civil::date(2000, 1, 1);

/// A night as a number of days.
pub(crate) fn day_of(night: Date) -> f64 {
    f64::from((night - FIRST).get_days())
}

/// The night of a number of days; `None` beyond the calendar.
#[must_use]
pub fn date_of(day: f64) -> Option<Date> {
    #[expect(clippy::cast_possible_truncation, reason = "whole days, and what is beyond is no date")]
    FIRST.checked_add(jiff::Span::new().try_days(day.round() as i64).ok()?).ok()
}

/// Why a limit cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LimitError {
    /// It is no name and number.
    #[error(
        "`{found}`; expected a column of the table and a number in its unit, as in internal_leakage_conductance_m3_per_s_pa=4e-12"
    )]
    Form {
        /// What was given.
        found: String,
    },
    /// No amount of an effect has this column.
    #[error("no amount of an effect is called `{found}`; expected {}", match like { Some(like) => format!("`{like}`?"), None => "one of the table's columns, as internal_leakage_conductance_m3_per_s_pa".to_owned() })]
    Name {
        /// What was given.
        found: String,
        /// The column that is most like it.
        like: Option<String>,
    },
}

/// Limits of amounts, as the user gives them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits(Vec<(Parameter, f64)>);

impl Limits {
    /// From arguments, each a column of the table and a number in its unit.
    ///
    /// # Errors
    /// One is no such column, or no number beyond 0.
    pub fn parse<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Result<Self, LimitError> {
        let one = |text: &str| {
            let form = || LimitError::Form { found: text.to_owned() };
            let (name, value) = text.split_once('=').ok_or_else(form)?;
            let value: f64 =
                value.trim().parse().ok().filter(|value| f64::is_finite(*value) && *value != 0.0).ok_or_else(form)?;
            let parameter = amounts().find(|amount| column_of(*amount).as_deref() == Some(name.trim()));
            Ok((parameter.ok_or_else(|| LimitError::Name { found: name.to_owned(), like: like(name) })?, value.abs()))
        };
        arguments.into_iter().map(one).collect::<Result<_, _>>().map(Self)
    }

    /// The limit of an amount: the last one that is given for it, else where sources call a cylinder worn.
    fn of(&self, parameter: Parameter, machine: Option<&Machine<f64>>) -> Option<Limit> {
        let given = self.0.iter().rev().find(|(own, _)| *own == parameter);
        let worn = || Some(Limit { value: size::worn(machine?, parameter)?, given: Given::Worn });
        given.map(|&(_, value)| Limit { value, given: Given::Argument }).or_else(worn)
    }
}

/// The column that begins as a name does.
fn like(name: &str) -> Option<String> {
    let plain = name.trim().to_ascii_lowercase().replace(['-', '.', ' '], "_");
    amounts().filter_map(column_of).find(|column| !plain.is_empty() && column.starts_with(&plain))
}

/// The parameters that say how much of an effect there is.
pub(crate) fn amounts() -> impl Iterator<Item = Parameter> {
    let own: BTreeSet<Parameter> = CATALOGUE
        .iter()
        .flat_map(|effect| effect.effect_parameters())
        .filter(|own| own.is_amount())
        .map(|own| own.parameter)
        .collect();
    Parameter::ALL.iter().copied().filter(move |parameter| own.contains(parameter))
}

/// Who says what the limit of an amount is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Given {
    /// The user.
    Argument,
    /// Sources: from there on a cylinder is worn ([`size::Grade`]).
    Worn,
}

/// How much of an effect there may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Its magnitude, SI.
    pub value: f64,
    /// Who says so.
    pub given: Given,
}

/// How urgent an amount is. What stands first is more urgent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Urgency {
    /// It is beyond its limit.
    Reached,
    /// It grows towards its limit, and reaches it within ten times the time in which it was seen to grow.
    Reaches(Reach),
    /// It grows, and has no limit or reaches it later.
    Grows,
    /// It falls, or has jumped in the last month, or one night alone has told it.
    Changed,
    /// It is as it was.
    Steady,
}

/// Share of halls in which nothing changes for which a jump of some amount is told by chance; as many for a rate.
const FALSE_CHANGES: f64 = 0.01;
/// Days after which a jump is no news.
const RECENT_DAYS: f64 = 30.0;
/// How far a line is continued, in times of the nights that tell it.
const HORIZON: f64 = 10.0;

impl Urgency {
    fn of(trend: &Trend, limit: Option<Limit>, up_to: f64) -> Self {
        let Some(piece) = trend.now() else { return Self::Steady };
        if trend.is_told_once(up_to) {
            return Self::Changed;
        }
        let (value, _) = piece.line.at(trend.last_day());
        let grows = piece.grows && value * piece.line.per_month().0 > 0.0;
        if limit.is_some_and(|limit| value.abs() >= limit.value) {
            return Self::Reached;
        }
        let (first, last) = trend.days(piece);
        let within = |reach: &Reach| reach.expected <= last + HORIZON * (last - first);
        let reach = limit.and_then(|limit| piece.line.reaches(limit.value, last)).filter(within);
        let is_new = trend.changes.last().is_some_and(|change| change + RECENT_DAYS >= last);
        match reach {
            Some(reach) if grows => Self::Reaches(reach),
            _ if grows => Self::Grows,
            _ if piece.grows || is_new => Self::Changed,
            _ => Self::Steady,
        }
    }

    /// Whether something is to be looked at.
    #[must_use]
    pub fn is_steady(&self) -> bool {
        matches!(self, Self::Steady)
    }

    /// Its name for programs.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Reached => "beyond-limit",
            Self::Reaches(_) => "reaches-limit",
            Self::Grows => "grows",
            Self::Changed => "changed",
            Self::Steady => "steady",
        }
    }

    fn rank(&self) -> u8 {
        match self {
            Self::Reached => 0,
            Self::Reaches(_) => 1,
            Self::Grows => 2,
            Self::Changed => 3,
            Self::Steady => 4,
        }
    }
}

/// One amount of one drive.
#[derive(Clone, Debug)]
pub struct Wear {
    /// The drive.
    pub drive: String,
    /// Which amount.
    pub parameter: Parameter,
    /// How it was, and is.
    pub trend: Trend,
    /// How much it may be, where that is known.
    pub limit: Option<Limit>,
    /// How urgent it is.
    pub urgency: Urgency,
}

impl Wear {
    /// What stands first among those of the same kind: what is furthest beyond its limit, reaches it first, doubles first; else what is nearest to it.
    fn order(&self) -> f64 {
        let Some(piece) = self.trend.now() else { return f64::INFINITY };
        let (now, rate) = (piece.line.at(self.trend.last_day()).0.abs(), piece.line.per_month().0.abs());
        match self.urgency {
            Urgency::Reaches(reach) => reach.expected,
            Urgency::Grows => now / rate,
            _ => self.limit.map_or(0.0, |limit| -now / limit.value),
        }
    }
}

/// What a table says of a hall.
#[derive(Clone, Debug)]
pub struct Wears {
    /// Every amount, the most urgent first.
    pub all: Vec<Wear>,
    /// How the nights of every drive ended.
    pub drives: BTreeMap<String, Tally>,
    /// The first and the last night.
    pub nights: (Date, Date),
    /// Names of nights that are no dates: they have no place in time.
    pub no_dates: BTreeSet<String>,
    /// The machines, where they are known: what sizes are counted in.
    pub machines: BTreeMap<String, MachineFile>,
}

impl Wears {
    /// The amounts that are to be looked at, the most urgent first.
    pub fn moving(&self) -> impl Iterator<Item = &Wear> {
        self.all.iter().filter(|wear| !wear.urgency.is_steady())
    }
}

/// Why nothing can be said of a table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WearError {
    /// It has no rows.
    #[error("no row is in this table; expected some that `host-sim fleet` wrote")]
    Empty,
    /// None of its nights is a date.
    #[error(
        "none of its nights is a date, the first is `{found}`; expected names as 2026-11-30, which say how much time is between them"
    )]
    NoDates {
        /// The first one.
        found: String,
    },
}

/// Every amount in the rows of a table. Machines say what sizes are counted in, and where a cylinder is worn; a drive may lack one.
///
/// # Errors
/// There are no rows, or no night of them is a date.
pub fn wears(rows: &[Row], limits: &Limits, machines: BTreeMap<String, MachineFile>) -> Result<Wears, WearError> {
    let first = rows.first().ok_or(WearError::Empty)?;
    let mut drives: BTreeMap<String, Tally> = BTreeMap::new();
    let mut series: BTreeMap<(&str, Parameter), Vec<Point>> = BTreeMap::new();
    let (mut dates, mut no_dates) = (BTreeSet::new(), BTreeSet::new());
    let amounts: BTreeSet<Parameter> = amounts().collect();
    for row in rows.iter().filter(|row| row.recording.is_none()) {
        drives.entry(row.drive.clone()).or_default().add(std::slice::from_ref(row));
        let Ok(night) = row.night.parse::<Date>() else {
            no_dates.insert(row.night.clone());
            continue;
        };
        dates.insert(night);
        for strength in row.strengths.iter().filter(|strength| amounts.contains(&strength.parameter)) {
            let point = Point { day: day_of(night), value: strength.value, std: strength.std };
            series.entry((&row.drive, strength.parameter)).or_default().push(point);
        }
    }
    let (Some(&from), Some(&to)) = (dates.first(), dates.last()) else {
        return Err(WearError::NoDates { found: first.night.clone() });
    };
    #[expect(clippy::cast_precision_loss, reason = "a number of drives and effects")]
    let each = FALSE_CHANGES / series.len().max(1) as f64;
    // Of one drive a few nights hardly tell how much they scatter; all drives together do.
    let mut of_parameter: BTreeMap<Parameter, Vec<f64>> = BTreeMap::new();
    for ((_, parameter), points) in &series {
        of_parameter.entry(*parameter).or_default().extend(squares(&telling(points.clone())));
    }
    let usual = |parameter: Parameter| of_parameter.get(&parameter).map_or(1.0, |squares| scatters(squares));
    let wear = |((drive, parameter), points): ((&str, Parameter), Vec<Point>)| {
        let limit = limits.of(parameter, machines.get(drive).map(|file| &file.machine));
        let trend = Trend::of(points, usual(parameter), each)?;
        Some(Wear { drive: drive.to_owned(), parameter, urgency: Urgency::of(&trend, limit, day_of(to)), limit, trend })
    };
    let mut all: Vec<Wear> = series.into_iter().filter_map(wear).collect();
    all.sort_by(|one, other| one.urgency.rank().cmp(&other.urgency.rank()).then(one.order().total_cmp(&other.order())));
    Ok(Wears { all, drives, nights: (from, to), no_dates, machines })
}

#[cfg(test)]
mod tests {
    use fleet::{Judgement, Strength};

    use super::*;
    use crate::words;

    fn row(drive: &str, night: &str, strengths: &[(Parameter, f64)]) -> Row {
        Row {
            drive: drive.into(),
            night: night.into(),
            recording: None,
            judgement: if strengths.is_empty() { Judgement::InBand } else { Judgement::Changed },
            link: None,
            words: String::new(),
            recordings: 2,
            of_limit: None,
            misfits: [None; 4],
            strengths: strengths.iter().map(|&(parameter, value)| Strength { parameter, value, std: 1e-14 }).collect(),
            version: String::new(),
            seconds: 0.0,
        }
    }

    #[test]
    fn what_reaches_its_limit_first_stands_first_and_a_night_that_tells_nothing_is_a_gap() {
        let leak = Parameter::InternalLeakage;
        let mut rows = Vec::new();
        for day in 1..=20 {
            let night = format!("2026-11-{day:02}");
            let grows = |by: f64| [(leak, 1e-12 + by * f64::from(day))];
            rows.push(row("steady", &night, &grows(0.0)));
            rows.push(row("slow", &night, &grows(2e-14)));
            let (level, soon, worn) = ([(leak, 3e-12)], [(leak, 1e-13 * f64::from(day))], [(leak, 9e-12)]);
            rows.push(row("level", &night, if day == 9 { &[] } else { &level }));
            rows.push(row("soon", &night, if day < 5 { &[] } else { &soon }));
            rows.push(row("gone", &night, &worn));
            rows.push(row("once", &night, if day == 14 { &worn } else { &[] }));
            rows.push(row("tonight", &night, if day == 20 { &worn } else { &[] }));
        }
        rows.push(row("soon", "the last one", &[(leak, 1.0)]));
        let limits = Limits::parse(["internal_leakage_conductance_m3_per_s_pa=4e-12"]).unwrap();
        let found = wears(&rows, &limits, BTreeMap::new()).unwrap();
        let order: Vec<&str> = found.all.iter().map(|wear| &*wear.drive).collect();
        assert_eq!(order, ["gone", "tonight", "soon", "slow", "once", "level", "steady"], "{:?}", found.all);
        assert_eq!(words::state(&found, &found.all[4]), "told in the night of 2026-11-14 alone");
        let Urgency::Reaches(reach) = found.all[2].urgency else { panic!("{:?}", found.all[2]) };
        assert_eq!(date_of(reach.expected).unwrap().to_string(), "2026-12-10");
        assert_eq!((found.all[2].trend.points.len(), found.all[5].trend.points.len()), (16, 19));
        assert!(found.all[5].urgency.is_steady() && found.no_dates.contains("the last one"));
        assert_eq!(found.nights.1.to_string(), "2026-11-20");
        assert_eq!(found.drives["soon"].of(Judgement::InBand), 4);
    }

    #[test]
    fn a_table_without_dates_and_a_limit_of_nothing_are_refused_in_words() {
        let refused = |rows: &[Row]| wears(rows, &Limits::default(), BTreeMap::new()).unwrap_err().to_string();
        assert!(refused(&[]).contains("no row"));
        assert!(refused(&[row("a", "tonight", &[])]).contains("`tonight`"));
        for (given, said) in [
            ("internal-leakage=4", "internal_leakage_conductance_m3_per_s_pa"),
            ("internal_leakage_conductance_m3_per_s_pa=a lot", "and a number"),
            ("oil=1", "no amount of an effect is called `oil`"),
            ("rubbish", "`rubbish`"),
        ] {
            let error = Limits::parse([given]).unwrap_err().to_string();
            assert!(error.contains(said), "{given}: {error}");
        }
    }
}
