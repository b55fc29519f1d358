//! Time stamps that are coarser than the sampling: several rows share one, again and again. The rows were sampled one after the other, so
//! they are spread evenly. A row that only now and then repeats a time is left out instead.

use super::stamp_clock::{Even, Stamp, Usual};
use crate::recording::{LeftOut, Note};

/// Fewest stamps that show how often one is shared, or a clock.
pub(crate) const LEAST_STAMPS: usize = 16;
/// Stamps are coarse where more than this share of them carry several rows: with a third fewer stamps than rows every third does.
const SHARED: f64 = 0.25;
/// Rows that share a stamp were sampled apart where they differ in more than this share of such stamps; else a row was written twice.
const DIFFERENT: f64 = 0.5;
/// A step of more than this many times the usual one lacks rows.
const GAP: f64 = 1.5;

/// How rows with coarse stamps are spread. The last rows keep their stamps as long as further rows may follow.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CoarseStamps {
    usual: Usual,
    /// The number of rows that are spread.
    spread: usize,
    /// The time of the last of them, s.
    last_s: f64,
    /// Whether it has been said how.
    is_told: bool,
}

impl CoarseStamps {
    /// Looks at rows of which those that repeat a time were left out. If the stamps are coarse, all of them are put back among the others, in
    /// their order. Columns begin with time.
    pub(crate) fn found(columns: &mut [&mut Vec<f64>], left_out: &mut LeftOut) -> Option<Self> {
        let width = columns.len();
        let stamps = columns[0].len();
        let cells = |index: usize| &left_out.cells[index * width..][..width];
        let repeats = |index: usize| {
            let before = left_out.after[index].checked_sub(1)?;
            let row: Vec<f64> = cells(index).iter().copied().collect::<Option<_>>()?;
            (row[0].to_bits() == columns[0][before].to_bits()).then_some((before, row))
        };
        let (mut shared, mut different) = (0, 0);
        let (mut last, mut last_different) = (None, None);
        for (before, row) in (0..left_out.after.len()).filter_map(repeats) {
            shared += usize::from(last.replace(before) != Some(before));
            let differs = (1..width).any(|index| row[index].to_bits() != columns[index][before].to_bits());
            if differs {
                different += usize::from(last_different.replace(before) != Some(before));
            }
        }
        let are_coarse = stamps >= LEAST_STAMPS
            && f64::from(u32::try_from(shared).ok()?) > SHARED * stamps as f64
            && f64::from(u32::try_from(different).ok()?) > DIFFERENT * f64::from(u32::try_from(shared).ok()?);
        if !are_coarse {
            return None;
        }
        let mut events: Vec<Event> = Vec::new();
        let mut next = 0;
        for row in 0..=stamps {
            while next < left_out.after.len() && left_out.after[next] == row {
                events.push(repeats(next).map_or_else(|| Event::Out(cells(next).to_vec()), |(_, row)| Event::Row(row)));
                next += 1;
            }
            if row < stamps {
                events.push(Event::Row(columns.iter().map(|column| column[row]).collect()));
            }
        }
        let usual = usual(columns[0], &events);
        for column in columns.iter_mut() {
            column.clear();
        }
        *left_out = LeftOut::default();
        for event in events {
            match event {
                Event::Row(row) => {
                    for (column, value) in columns.iter_mut().zip(row) {
                        column.push(value);
                    }
                }
                Event::Out(cells) => {
                    left_out.after.push(columns[0].len());
                    left_out.cells.extend(cells);
                }
            }
        }
        Some(Self { usual, spread: 0, last_s: f64::NEG_INFINITY, is_told: false })
    }

    /// The number of rows that wait to be spread together with those that follow: those of the last stamps.
    pub(crate) fn waiting(&self, times_s: &[f64]) -> usize {
        let stamps = times_s[self.spread..].chunk_by(|a, b| a.to_bits() == b.to_bits());
        stamps.rev().take(LEAST_STAMPS).map(<[f64]>::len).sum()
    }

    /// The first rows have been taken away.
    pub(crate) fn forget(&mut self, rows: usize) {
        self.spread -= rows;
    }

    /// Spreads the rows that are not spread yet, but those of the last stamps if further rows may follow. The first time it says how.
    pub(crate) fn spread(&mut self, times_s: &mut [f64], is_at_end: bool) -> Option<Note> {
        let to = times_s.len() - if is_at_end { 0 } else { self.waiting(times_s) };
        let next_s = times_s.get(to).copied();
        let times_s = &mut times_s[self.spread..to];
        let stamps = Stamp::all_of(times_s, next_s);
        let mut rest = stamps.as_slice();
        let (mut clocks, mut within_stamps) = (0, 0);
        let mut longest: Option<Even> = None;
        while let Some((stamp, others)) = rest.split_first() {
            let even = if let Some((fit, clock)) = Even::longest(rest, self.usual) {
                rest = &rest[fit..];
                clocks += 1;
                longest = longest.filter(|longest| longest.rows >= clock.rows).or(Some(clock));
                clock
            } else {
                rest = others;
                within_stamps += stamp.rows;
                stamp.spread(self.usual, self.last_s == f64::NEG_INFINITY)
            };
            even.write(times_s, &mut self.last_s);
        }
        self.spread = to;
        let Usual { step_s, interval_s } = self.usual;
        let interval_s = longest.map_or(interval_s, |longest| longest.interval_s);
        let note = Note::CoarseTimes { step_s, interval_s, clocks, within_stamps };
        (!std::mem::replace(&mut self.is_told, true)).then_some(note)
    }
}

/// A row of the file: one with a time, or one that stays left out.
enum Event {
    Row(Vec<f64>),
    Out(Vec<Option<f64>>),
}

/// The usual step of the stamps, and the usual interval of the rows: the step over the mean number of rows of the stamps that another
/// follows at this step.
fn usual(stamps_s: &[f64], events: &[Event]) -> Usual {
    let mut steps: Vec<f64> = stamps_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    let step_s = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let mut counts = vec![0_usize; stamps_s.len()];
    let mut at = 0;
    for event in events {
        if let Event::Row(row) = event {
            at = (at..stamps_s.len()).find(|&at| stamps_s[at].to_bits() == row[0].to_bits()).unwrap_or(at);
            counts[at] += 1;
        }
    }
    let (mut span_s, mut rows) = (0.0, 0.0);
    for (pair, count) in stamps_s.windows(2).zip(&counts).skip(1) {
        if pair[1] - pair[0] < GAP * step_s {
            span_s += pair[1] - pair[0];
            rows += *count as f64;
        }
    }
    Usual { step_s, interval_s: if rows > 0.0 { span_s / rows } else { step_s } }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use crate::formats::read::parts_of;
    use crate::{ChannelMap, Note, Recording, Signal, read_from};

    /// A ramp sampled at this interval, its times rounded by `stamp`, as a text.
    fn text(rows: u32, interval_s: f64, stamp: impl Fn(f64) -> f64) -> String {
        let mut text = String::from("time [s],spool\n");
        for row in 0..rows {
            let time_s = f64::from(row) * interval_s;
            writeln!(text, "{:.4},{time_s:.4}", stamp(time_s)).unwrap();
        }
        text
    }

    fn read(text: &str) -> Recording {
        read_from("run.csv", text.as_bytes(), &ChannelMap::default()).unwrap()
    }

    /// Largest difference of times from when the rows were sampled, but for a common one.
    fn off_s(recording: &Recording) -> f64 {
        let sampled = recording.signal(Signal::Spool).unwrap();
        let off: Vec<f64> = recording.time_s().iter().zip(sampled).map(|(time, sampled)| time - sampled).collect();
        let middle = off[off.len() / 2];
        off.iter().map(|off| (off - middle).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn rows_within_coarse_stamps_are_spread_evenly() {
        let stamps: [fn(f64) -> f64; 2] =
            [|time_s| (time_s * 100.0).round() / 100.0, |time_s| (time_s * 100.0 + 1e-6).floor() / 100.0];
        for stamp in stamps {
            let even = read(&text(2003, 2e-3, stamp));
            assert_eq!(even.rows(), 2003);
            assert!(off_s(&even) < 1e-9, "{}", off_s(&even));
            let [Note::CoarseTimes { step_s, interval_s, .. }] = even.notes() else { panic!("{:?}", even.notes()) };
            assert!((step_s - 0.01).abs() < 1e-12 && (interval_s - 2e-3).abs() < 1e-6, "{step_s} {interval_s}");
        }
        let whole = read(&text(200, 2e-3, stamps[1]));
        assert!(whole.time_s().iter().zip(whole.signal(Signal::Spool).unwrap()).all(|(a, b)| (a - b).abs() < 1e-12));
        let told = "time stamps are 10.0 ms apart and 5 rows share one: they are spread evenly, 2.00 ms apart";
        assert_eq!(whole.notes()[0].to_string(), told);
    }

    /// Stamps of 10 ms that come up to 1 ms early or late.
    fn jittered(time_s: f64) -> f64 {
        let late_ms = |stamp: f64| (7.3 * stamp).sin().round();
        let at_ms = 1e3 * time_s + 1e-6;
        let stamp = (at_ms / 10.0).floor();
        let before = f64::from(at_ms < 10.0 * stamp + late_ms(stamp));
        let after = f64::from(at_ms >= 10.0 * (stamp + 1.0) + late_ms(stamp + 1.0));
        (stamp + after - before).max(0.0) / 100.0
    }

    #[test]
    fn rows_within_uneven_stamps_are_on_one_even_clock() {
        type Stamps = (f64, fn(f64) -> f64);
        let timer: fn(f64) -> f64 = |time_s| (time_s / 15.625e-3).floor() * 15.625e-3;
        let of_10_ms: [Stamps; 3] = [
            (3e-3, |time_s| (time_s * 100.0 + 1e-6).floor() / 100.0),
            (1.07e-3, |time_s| (time_s * 100.0).round() / 100.0),
            (1.07e-3, |time_s| (time_s * 100.0).ceil() / 100.0),
        ];
        for (interval_s, stamp) in [(1e-3, timer), (1e-3, jittered), (7e-3, timer)].into_iter().chain(of_10_ms) {
            for rows in [400, 2003, 20_011] {
                let even = read(&text(rows, interval_s, stamp));
                let off = off_s(&even) / interval_s;
                assert!(even.rows() == rows as usize && off < 0.3, "{interval_s} s, {rows} rows: off by {off} rows");
                let steps: Vec<f64> = even.time_s().windows(2).map(|pair| pair[1] - pair[0]).collect();
                assert!(steps.iter().all(|step| (step - steps[0]).abs() < 1e-9), "{interval_s} s: uneven");
                let [Note::CoarseTimes { clocks: 1, within_stamps: 0, .. }] = even.notes() else {
                    panic!("{:?}", even.notes())
                };
            }
        }
    }

    #[test]
    fn after_a_pause_rows_are_on_a_clock_of_their_own() {
        let timer = |time_s: f64| (time_s / 15.625e-3).floor() * 15.625e-3;
        for pause_s in [0.012, 0.02, 0.5] {
            let mut text = String::from("time [s],spool\n");
            for row in 0..4000 {
                let time_s = 1e-3 * f64::from(row) + if row < 2345 { 0.0 } else { pause_s };
                writeln!(text, "{:.4},{time_s:.4}", timer(time_s)).unwrap();
            }
            let recording = read(&text);
            let Note::CoarseTimes { clocks: 2, within_stamps: 0, .. } = recording.notes()[0] else {
                panic!("{pause_s} s: {:?}", recording.notes())
            };
            let steps: Vec<f64> = recording.time_s().windows(2).map(|pair| pair[1] - pair[0]).collect();
            let longest = (0..steps.len()).max_by(|a, b| steps[*a].total_cmp(&steps[*b])).unwrap();
            assert!(longest.abs_diff(2344) <= 15, "{pause_s} s: after row {longest}");
            assert!((steps[longest] - pause_s - 1e-3).abs() < 1e-3, "{pause_s} s: {} s", steps[longest]);
            let told = recording.notes()[0].to_string();
            assert!(told.ends_with("they are spread evenly in each of 2 stretches, 1.00 ms apart"), "{told}");
        }
    }

    #[test]
    fn where_the_rate_changes_a_clock_of_its_own_begins() {
        // From 1000 to 500 rows a second.
        let mut text = String::from("time [s],spool\n");
        for row in 0..2000 {
            let time_s = 1e-3 * f64::from(row) + 1e-3 * f64::from((row - 1000).max(0));
            writeln!(text, "{:.2},{time_s:.4}", (time_s * 100.0 + 1e-6).floor() / 100.0).unwrap();
        }
        let recording = read(&text);
        assert!(matches!(recording.notes(), [Note::CoarseTimes { clocks: 2, within_stamps: 0, .. }]));
        let off = |(time_s, sampled_s): (&f64, &f64)| (time_s - sampled_s).abs() > 1e-9;
        let rows_off = recording.time_s().iter().zip(recording.signal(Signal::Spool).unwrap()).filter(|row| off(*row));
        assert!(off_s(&recording) < 5e-3 && rows_off.count() < 5, "those of one stamp");
    }

    #[test]
    fn rows_that_fit_no_clock_are_spread_within_their_stamps() {
        let mut text = String::from("time [s],spool\n");
        let mut rows = 0;
        for stamp in 0..100 {
            for _ in 0..[1, 2, 1, 40][stamp % 4] {
                rows += 1;
                writeln!(text, "{},{rows}", 0.01 * stamp as f64).unwrap();
            }
        }
        let recording = read(&text);
        assert_eq!(recording.rows(), rows);
        let Note::CoarseTimes { clocks: 0, within_stamps, .. } = recording.notes()[0] else {
            panic!("{:?}", recording.notes())
        };
        assert_eq!(within_stamps, rows);
        for (time_s, row) in recording.time_s().iter().zip(text.lines().skip(1)) {
            let stamp_s: f64 = row.split(',').next().unwrap().parse().unwrap();
            assert!((stamp_s..stamp_s + 0.01).contains(time_s), "{time_s} s of {stamp_s} s");
        }
        let told = recording.notes()[0].to_string();
        assert!(told.contains("they fit no even clock and are spread within each stamp, about "), "{told}");
    }

    #[test]
    fn times_that_rows_do_not_share_stay_as_they_are() {
        for stamp in [
            |time_s: f64| time_s,
            |time_s: f64| (time_s * 1e3).round() / 1e3,
            |time_s: f64| time_s + 1e-4 * (1e5 * time_s).sin(),
        ] {
            let text = text(2000, 1.25e-3, stamp);
            let written: Vec<u64> = text
                .lines()
                .skip(1)
                .map(|line| line.split(',').next().unwrap().parse::<f64>().unwrap().to_bits())
                .collect();
            let recording = read(&text);
            assert!(recording.notes().is_empty() && recording.time_s().iter().map(|time| time.to_bits()).eq(written));
        }
    }

    #[test]
    fn a_gap_stays_a_gap_and_rows_with_an_empty_cell_stay_out() {
        let stamp = |time_s: f64| ((time_s + if time_s > 1.0 { 0.5 } else { 0.0 }) * 100.0).round() / 100.0;
        let mut text = text(1000, 2e-3, stamp);
        text.push_str("3.0,\n");
        let recording = read(&text);
        assert_eq!(recording.rows(), 1000);
        assert!(recording.notes().iter().any(|note| matches!(note, Note::Gaps { count: 1, .. })));
        assert!(recording.notes().iter().any(|note| matches!(note, Note::IncompleteRows { rows: 1, .. })));
        let longest = recording.time_s().windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        assert!((longest - 0.502).abs() < 0.01, "{longest}");
    }

    #[test]
    fn rows_that_are_written_twice_and_rare_repetitions_are_left_out() {
        let mut twice = String::from("time [s],spool\n");
        let mut rare = twice.clone();
        for row in 0..200 {
            let line = format!("{:.3},{:.3}\n", 0.002 * f64::from(row), 0.01 * f64::from(row));
            twice += &(line.clone() + &line);
            rare += &line;
            if row % 7 == 3 {
                writeln!(rare, "{:.3},9", 0.002 * f64::from(row)).unwrap();
            }
        }
        for text in [twice, rare] {
            let recording = read(&text);
            assert_eq!(recording.rows(), 200);
            assert!(matches!(recording.notes(), [Note::DuplicateTimes { .. }]), "{:?}", recording.notes());
        }
    }

    #[test]
    fn in_parts_rows_are_spread_as_in_the_whole_and_told_once() {
        let even = text(9000, 2e-3, |time_s| (time_s * 100.0).round() / 100.0);
        let uneven = text(9000, 1e-3, |time_s| (time_s / 15.625e-3).floor() * 15.625e-3);
        for (text, most_s) in [(even, 1e-12), (uneven, 2e-4)] {
            let whole = read(&text);
            let mut parts = parts_of("run.csv", Box::new(text.as_bytes()), &ChannelMap::default(), 2500).unwrap();
            let (mut time_s, mut notes) = (Vec::new(), 0);
            while let Some(part) = parts.read_next().unwrap() {
                time_s.extend_from_slice(part.recording.time_s());
                notes += part.recording.notes().len();
                parts.forget_before(usize::MAX);
            }
            assert_eq!((time_s.len(), notes), (9000, 1));
            let off = time_s.iter().zip(whole.time_s()).map(|(part, whole)| (part - whole).abs()).fold(0.0, f64::max);
            assert!(off < most_s, "{off}");
        }
    }
}
