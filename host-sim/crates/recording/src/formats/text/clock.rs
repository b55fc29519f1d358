//! Times of a text that are written as dates and times of day.

use chrono::{DateTime, NaiveDate, NaiveDateTime, NaiveTime};

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
}

#[derive(Clone, Copy, Debug)]
struct Reading {
    at: NaiveDateTime,
    has_date: bool,
}

impl StampClock {
    /// Seconds since the first reading; `None` for what is no time, or a time of another kind than the first.
    pub(crate) fn seconds(&mut self, text: &str) -> Option<f64> {
        let reading = reading(text)?;
        let first = *self.first.get_or_insert(reading);
        if first.has_date != reading.has_date {
            return None;
        }
        let passed = reading.at - first.at;
        // Whole seconds and the rest apart: a double does not hold the nanoseconds of a year.
        Some(passed.num_seconds() as f64 + f64::from(passed.subsec_nanos()) * 1e-9)
    }
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
        return Some(Reading { at: with_zone.naive_utc(), has_date: true });
    }
    let bare = text.trim_end_matches('Z');
    let dated = WITH_DATE.iter().find_map(|form| NaiveDateTime::parse_from_str(bare, form).ok());
    if let Some(at) = dated {
        return Some(Reading { at, has_date: true });
    }
    let at = NaiveDate::default().and_time(NaiveTime::parse_from_str(bare, OF_DAY).ok()?);
    Some(Reading { at, has_date: false })
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
        ] {
            let mut clock = StampClock::default();
            assert_eq!(clock.seconds(first), Some(0.0));
            let passed = clock.seconds(second).unwrap();
            assert!((passed - 0.012).abs() < 1e-12, "{first} {second}: {passed}");
        }
        let mut clock = StampClock::default();
        assert_eq!(clock.seconds("2024-05-06T07:08:59.123456789"), Some(0.0));
        assert_eq!(clock.seconds("2025-05-06T07:08:59.123456790"), Some(365.0 * 86400.0 + 1e-9));
        assert_eq!(clock.seconds("07:08:59"), None);
        for other in ["5/6/2024 07:08:59", "12.5", "Tuesday", "07:08", "25:00:00", ""] {
            assert!(!is_stamp(other), "{other}");
        }
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
