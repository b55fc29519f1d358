//! Time stamps that are coarser than the sampling: several rows share one, again and again. The rows were sampled one after the other, so
//! they are spread evenly within their stamps. A row that only now and then repeats a time is left out instead.

use crate::recording::{LeftOut, Note};

/// Fewest stamps that show how often one is shared.
const LEAST_STAMPS: usize = 16;
/// Stamps are coarse where more than this share of them carry several rows: with a third fewer stamps than rows every third does.
const SHARED: f64 = 0.25;
/// Rows that share a stamp were sampled apart where they differ in more than this share of such stamps; else a row was written twice.
const DIFFERENT: f64 = 0.5;
/// A step of more than this many times the usual one lacks rows.
const GAP: f64 = 1.5;

/// How rows are spread within coarse stamps, and the rows of the last stamp as long as more may follow.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CoarseStamps {
    /// From one stamp to the next, s.
    step_s: f64,
    /// From one row to the next, s.
    interval_s: f64,
    /// The values of each row, its stamp first.
    group: Vec<Vec<f64>>,
    /// Whether a row of an earlier stamp has been handed on.
    has_begun: bool,
}

/// Where the rows of a stamp lie in it: those of the first are its last, those of the last its first.
#[derive(Clone, Copy)]
enum Place {
    AtEnd,
    Middle,
    AtStart,
}

impl CoarseStamps {
    /// Looks at rows of which those that repeat a time were left out. If the stamps are coarse, all of them are put back among the others, in
    /// their order and spread, but those of the last stamp. Columns begin with time.
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
        let (step_s, interval_s) = usual(columns[0], &events);
        let mut spread = Self { step_s, interval_s, group: Vec::new(), has_begun: false };
        for column in columns.iter_mut() {
            column.clear();
        }
        *left_out = LeftOut::default();
        for event in events {
            match event {
                Event::Row(row) => spread.push(row, columns),
                Event::Out(cells) => {
                    left_out.after.push(columns[0].len() + spread.group.len());
                    left_out.cells.extend(cells);
                }
            }
        }
        Some(spread)
    }

    /// What is said of it.
    pub(crate) fn note(&self) -> Note {
        Note::CoarseTimes { step_s: self.step_s, interval_s: self.interval_s }
    }

    /// The number of rows that are not yet spread.
    pub(crate) fn waiting(&self) -> usize {
        self.group.len()
    }

    /// The stamp of the last row.
    pub(crate) fn last_s(&self) -> Option<f64> {
        self.group.last().map(|row| row[0])
    }

    /// Takes the next row; with a new stamp, the rows of the last one are spread.
    pub(crate) fn push(&mut self, row: Vec<f64>, columns: &mut [&mut Vec<f64>]) {
        if let Some(stamp_s) = self.last_s().filter(|stamp_s| row[0] > *stamp_s) {
            let slot_s = self.step_s.min(row[0] - stamp_s);
            self.spread(slot_s, if self.has_begun { Place::Middle } else { Place::AtEnd }, columns);
        }
        self.group.push(row);
    }

    /// Spreads the rows of the last stamp.
    pub(crate) fn finish(&mut self, columns: &mut [&mut Vec<f64>]) {
        self.spread(self.step_s, Place::AtStart, columns);
    }

    fn spread(&mut self, slot_s: f64, place: Place, columns: &mut [&mut Vec<f64>]) {
        let rows = self.group.len() as f64;
        let apart_s = self.interval_s.min(slot_s / rows);
        // A full stamp begins with its own time.
        let begins_s = match place {
            Place::AtStart => 0.0,
            Place::Middle => 0.5 * (slot_s - rows * apart_s),
            Place::AtEnd => slot_s - rows * apart_s,
        };
        for (index, row) in self.group.drain(..).enumerate() {
            columns[0].push(row[0] + begins_s + index as f64 * apart_s);
            for (column, value) in columns[1..].iter_mut().zip(&row[1..]) {
                column.push(*value);
            }
        }
        self.has_begun = true;
    }
}

/// A row of the file: one with a time, or one that stays left out.
enum Event {
    Row(Vec<f64>),
    Out(Vec<Option<f64>>),
}

/// The usual step of the stamps, and the usual interval of the rows: the step over the mean number of rows of the stamps that another
/// follows at this step.
fn usual(stamps_s: &[f64], events: &[Event]) -> (f64, f64) {
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
    (step_s, if rows > 0.0 { span_s / rows } else { step_s })
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
            let [Note::CoarseTimes { step_s, interval_s }] = even.notes() else { panic!("{:?}", even.notes()) };
            assert!((step_s - 0.01).abs() < 1e-12 && (interval_s - 2e-3).abs() < 1e-6, "{step_s} {interval_s}");
            // A sampling that does not fit into the stamps: within a row.
            let uneven = read(&text(2000, 3e-3, stamp));
            assert!(uneven.rows() == 2000 && off_s(&uneven) < 2.5e-3, "{}", off_s(&uneven));
        }
        let told = read(&text(200, 2e-3, stamps[0])).notes()[0].to_string();
        assert!(told.starts_with("time stamps are 10.0 ms apart and 5.00 rows share one"), "{told}");
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
        let text = text(9000, 2e-3, |time_s| (time_s * 100.0).round() / 100.0);
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
        assert!(off < 1e-5, "{off}");
    }
}
