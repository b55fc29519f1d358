//! Times of a text that are written as dates and times of day.

use chrono::{DateTime, NaiveDate, NaiveDateTime, NaiveTime, TimeDelta};

/// Forms of a time with its date; a fraction of a second may follow.
const WITH_DATE: [&str; 5] = [
    "%Y-%m-%dT%H:%M:%S%.f",
    "%Y-%m-%d %H:%M:%S%.f",
    "%Y%m%dT%H%M%S%.f",
    "%Y/%m/%d %H:%M:%S%.f",
    "%d.%m.%Y %H:%M:%S%.f",
];
/// A day of an unusual time of day.
const OF_DAY: &str = "%H:%M:%S%.f";

/// A clock of dates or of times of day, which counts from its first reading.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StampClock {
    first: Option<Reading>,
    /// The last time of day, without midnights.
    of_day: Option<NaiveDateTime>,
    midnights: i32,
}

#[derive(Clone, Copy, Debug)]
struct Reading {
    at: NaiveDateTime,
    has_date: bool,
    /// Whether it begins anew at midnight.
    is_of_day: bool,
}

/// A time of day that is smaller by more than this than the one before is of the next day.
const MOST_BACK: TimeDelta = TimeDelta::hours(23);

impl StampClock {
    /// Seconds since the first reading; `None` for what is no time, or a time of another kind than the first.
    pub(crate) fn seconds(&mut self, text: &str) -> Option<f64> {
        let reading = reading(text)?;
        let first = *self.first.get_or_insert(reading);
        if first.has_date != reading.has_date {
            return None;
        }
        if reading.is_of_day {
            let back = self.of_day.map_or(TimeDelta::zero(), |last| last - reading.at);
            // A time of the day before is out of order, and the next one passes midnight once more.
            let is_day_before = -back > MOST_BACK && self.midnights > 0;
            self.midnights += i32::from(back > MOST_BACK) - i32::from(is_day_before);
            self.of_day = Some(reading.at);
        }
        let passed = reading.at - first.at + TimeDelta::days(1) * self.midnights;
        // In whole nanoseconds as long as they fit: 0.03 and not 0.030000000000000002.
        let whole = || passed.num_seconds() as f64 + f64::from(passed.subsec_nanos()) * 1e-9;
        Some(passed.num_nanoseconds().map_or_else(whole, |nanoseconds| nanoseconds as f64 / 1e9))
    }
}

/// Whether a text looks like a date or a time of day and is none that a [`StampClock`] reads: `5/6/2024 10:00`, `10:00:00 PM`.
pub(crate) fn is_unreadable(text: &str) -> bool {
    let marks = text.chars().skip(1).filter(|mark| matches!(mark, '/' | ':' | '-' | '.')).count();
    let has_mark = text.contains([':', '/']) || marks > 1;
    text.starts_with(|first: char| first.is_ascii_digit())
        && has_mark
        && text.parse::<f64>().is_err()
        && !is_stamp(text)
}

/// Whether a text is a time that a [`StampClock`] reads.
pub(crate) fn is_stamp(text: &str) -> bool {
    reading(text).is_some()
}

fn reading(text: &str) -> Option<Reading> {
    let text = text.trim();
    // Without this, every cell of numbers would be tried in every form.
    if !text.contains([':', 'T']) || text.len() > 40 {
        return None;
    }
    let text = text.replacen(',', ".", 1);
    if let Ok(with_zone) = DateTime::parse_from_rfc3339(&text.replacen(' ', "T", 1)) {
        return Some(Reading { at: with_zone.naive_utc(), has_date: true, is_of_day: false });
    }
    let bare = text.trim_end_matches('Z');
    // Of `5/6/24` and `05.06.24` nobody can say what is the year.
    let year = |form: &str| if form.starts_with("%Y") { Some(bare) } else { bare.splitn(3, '.').nth(2) };
    let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
    let has_year = |form: &&&str| year(form).is_some_and(|year| digits(year) >= 4);
    let dated = WITH_DATE.iter().filter(has_year).find_map(|form| NaiveDateTime::parse_from_str(bare, form).ok());
    if let Some(at) = dated {
        // Times of day of a workbook are those of its first day.
        let is_of_day = Some(at.date()) == NaiveDate::from_ymd_opt(1899, 12, 30);
        return Some(Reading { at, has_date: true, is_of_day });
    }
    let is_of_day = bare.starts_with(|first: char| first.is_ascii_digit()) && !bare.contains("day");
    let passed = match bare.split_once(" day") {
        // A duration as pandas writes it: 0 days 00:00:00.002000.
        Some((days, rest)) => {
            let of_day = NaiveTime::parse_from_str(rest.trim_start_matches('s').trim_start(), OF_DAY).ok()?;
            TimeDelta::try_days(days.parse().ok()?)? + (of_day - NaiveTime::MIN)
        }
        None => match bare.strip_prefix("PT") {
            Some(duration) => iso_duration(duration)?,
            None => NaiveTime::parse_from_str(bare, OF_DAY).ok()? - NaiveTime::MIN,
        },
    };
    let at = NaiveDate::default().and_time(NaiveTime::MIN).checked_add_signed(passed)?;
    Some(Reading { at, has_date: false, is_of_day })
}

/// A duration as ISO 8601 and Polars write it behind `PT`: `1H2M3.25S`.
fn iso_duration(text: &str) -> Option<TimeDelta> {
    let (mut rest, mut nanoseconds) = (text, 0.0);
    for (letter, unit_ns) in [('H', 3600e9), ('M', 60e9), ('S', 1e9)] {
        if let Some((number, after)) = rest.split_once(letter) {
            nanoseconds += (number.parse::<f64>().ok()? * unit_ns).round();
            rest = after;
        }
    }
    let is_whole = rest.is_empty() && !text.is_empty() && nanoseconds.abs() < 9e18;
    #[expect(clippy::cast_possible_truncation, reason = "within the range of an i64, as checked")]
    is_whole.then_some(TimeDelta::nanoseconds(nanoseconds as i64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ChannelMap, RecordingError, Signal, read_from};

    #[test]
    fn times_count_from_the_first_in_every_form() {
        for [first, second] in [
            ["2024-05-06T07:08:59.990", "2024-05-06T07:09:00.002"],
            ["2024-05-06 07:08:59,99", "2024-05-06 07:09:00,002"],
            ["2024-05-06T07:08:59.990Z", "2024-05-06T07:09:00.002Z"],
            ["2024-05-06T07:08:59.990+02:00", "2024-05-06T05:09:00.002Z"],
            ["20240506T070859.990", "20240506T070900.002"],
            ["06.05.2024 07:08:59,990", "06.05.2024 07:09:00,002"],
            ["2024/12/31 23:59:59.990", "2025/01/01 00:00:00.002"],
            ["07:08:59.990", "07:09:00.002"],
            ["0 days 23:59:59.990", "1 days 00:00:00.002"],
            ["PT59.99S", "PT1M0.002S"],
        ] {
            let mut clock = StampClock::default();
            assert_eq!(clock.seconds(first), Some(0.0));
            let passed = clock.seconds(second).unwrap();
            assert!((passed - 0.012).abs() < 1e-12, "{first} {second}: {passed}");
        }
        let mut clock = StampClock::default();
        assert_eq!(clock.seconds("2024-05-06T07:08:59.123456789"), Some(0.0));
        assert_eq!(clock.seconds("2025-05-06T07:08:59.123456790"), Some(31_536_000_000_000_001.0 / 1e9));
        assert_eq!(clock.seconds("07:08:59"), None);
        for other in [
            "5/6/24 07:08:59",
            "05-06-24 07:08:59",
            "05.06.24 07:08:59",
            "24.05.06 07:08:59",
            "5/6/2024 07:08:59",
            "12.5",
            "Tuesday",
            "07:08",
            "25:00:00",
            "",
            "PT",
            "PTxS",
            "x days 00:00:00",
        ] {
            assert!(!is_stamp(other), "{other}");
        }
    }

    #[test]
    fn times_of_day_pass_midnight() {
        for date in ["", "1899-12-30T"] {
            let mut clock = StampClock::default();
            let times = ["23:59:59.900", "00:00:00.000", "12:00:00", "23:59:59.900", "00:00:00.100"];
            let found: Vec<f64> = times.iter().map(|time| clock.seconds(&format!("{date}{time}")).unwrap()).collect();
            assert_eq!(found, [0.0, 0.1, 43_200.1, 86_400.0, 86_400.2]);
            // A time of the day before is a step back, and the next one passes the same midnight.
            let again = ["23:59:59.999", "00:00:00.200"].map(|time| clock.seconds(&format!("{date}{time}")).unwrap());
            assert!(again[0] < 86_400.2 && (again[1] - 86_400.3).abs() < 1e-9, "{again:?}");
            // A smaller step back is none.
            assert!(clock.seconds("00:00:00.000").is_none_or(|back| back < 86_400.2));
        }
        // Nor do dates and durations begin anew.
        for [first, second] in [["2024-05-06T23:59:59", "2024-05-06T00:00:00"], ["0 days 23:59:59", "0 days 00:00:00"]]
        {
            let mut clock = StampClock::default();
            clock.seconds(first).unwrap();
            assert!(clock.seconds(second).unwrap() < 0.0);
        }
    }

    #[test]
    fn times_that_are_not_read_say_which_are() {
        for written in
            ["5/6/2024 10:00:00.000", "5/6/24 10:00:00", "10:00:00 PM", "10:00", "06-May-2024 10:00:00", "5.6.24"]
        {
            for header in ["time", "time [s]"] {
                let told =
                    read_from("run.csv", format!("{header},spool\n{written},1\n").as_bytes(), &ChannelMap::default());
                let told = told.unwrap_err().to_string();
                assert!(told.contains(written) && told.contains("2024-05-06T07:08:09.125"), "{told}");
                assert_eq!(told.contains("the day or the month"), written.contains('/'), "{told}");
                assert!(told.starts_with("run.csv:2:1: "), "{told}");
            }
        }
        assert!(
            ["12.5", "-1e-3", "1e-3", "07:08:09", "2024-05-06T07:08:09", "x", ""]
                .iter()
                .all(|text| !is_unreadable(text))
        );
    }

    #[test]
    fn a_recording_with_dates_needs_no_unit_of_time() {
        let text =
            "spool;time\n0,1;2024-05-06T07:08:09,000\n0,2;2024-05-06T07:08:09,010\n0,3;2024-05-06T07:08:09,020\n";
        let recording = read_from("run.csv", text.as_bytes(), &ChannelMap::default()).unwrap();
        assert_eq!(recording.time_s(), [0.0, 0.01, 0.02]);
        assert_eq!(recording.columns()[0].header, "time [s]");
        let map = ChannelMap::from_arguments(["time=Zeitstempel"]).unwrap();
        let mapped = text.replace(";time", ";Zeitstempel");
        let recording = read_from("run.csv", mapped.as_bytes(), &map).unwrap();
        assert_eq!(recording.signal(Signal::Spool).unwrap(), [0.1, 0.2, 0.3]);
        let broken = text.replace("09,020", "09,o20");
        let refused = read_from("run.csv", broken.as_bytes(), &ChannelMap::default()).unwrap_err();
        assert!(matches!(refused, RecordingError::NotAStamp { .. }), "{refused}");
    }
}
