//! What stands above the rows of a text: Excel's line `sep=;`, the header, a row of units.

use super::clock;
use super::decimal_mark::is_missing;
use super::lines::{Cells, Lines, Splitter, TextLine};
use crate::channel_map::ChannelMap;
use crate::error::RecordingError;
use crate::files::source_error::{Place, is_number};
use crate::formats::text_fault::TextFault;
use crate::header::{Offer, is_same_unit, leave_unused};
use crate::signal::{Signal, split_header};
use crate::unit::Unit;

/// The header of a text.
pub(crate) struct Heading {
    file: String,
    line: (usize, String),
    pub(crate) separator: u8,
    /// The names, without empty ones at the end: those of a comma that closes every line.
    pub(crate) names: Vec<String>,
    /// What the row below says of the unit of each, if it is a row of units.
    units: Vec<Option<String>>,
    /// The number and text of that row.
    units_line: (usize, String),
    /// Columns whose first cell is a date or a time of day.
    stamped: Vec<bool>,
    /// Columns whose first cell is a date or a time of day in a form that is not read, with that cell.
    unreadable: Vec<(usize, Place, String)>,
}

impl Heading {
    /// Reads the header.
    pub(crate) fn read(lines: &mut Lines<'_>) -> Result<(Self, Splitter), RecordingError> {
        let file = lines.file_name().to_owned();
        let (header, mut splitter) = lines.header()?;
        let line = (header.number(), header.text.to_owned());
        let mut names: Vec<String> = splitter.split(header)?.iter().map(str::to_owned).collect();
        while names.len() > 1 && names.last().is_some_and(String::is_empty) {
            names.pop();
        }
        let (units, stamped) = (vec![None; names.len()], vec![false; names.len()]);
        let units_line = (0, String::new());
        Ok((
            Self {
                file,
                line,
                separator: splitter.separator(),
                names,
                units,
                units_line,
                stamped,
                unreadable: Vec::new(),
            },
            splitter,
        ))
    }

    /// Looks at the row below: takes it, if it is a row of units, and finds dates in the first row of numbers.
    pub(crate) fn look_below(&mut self, lines: &mut Lines<'_>, splitter: &mut Splitter) -> Result<(), RecordingError> {
        for may_be_units in [true, false] {
            let Some(below) = lines.next()? else { return Ok(()) };
            // What is wrong with the line is said when it is read as a row.
            let Ok(cells) = splitter.split(below) else {
                lines.put_back();
                return Ok(());
            };
            if may_be_units && are_units(&self.names, cells) {
                self.units_line = (below.number(), below.text.to_owned());
                self.units = (0..self.names.len()).map(|index| unit_text(cells.get(index))).collect();
                continue;
            }
            self.stamped = (0..self.names.len()).map(|index| clock::is_stamp(cells.get(index))).collect();
            let unreadable = (0..self.names.len()).filter(|index| clock::is_unreadable(cells.get(*index)));
            let with_place = |index| (index, below.cell(self.separator, index), cells.get(index).to_owned());
            self.unreadable = unreadable.map(with_place).collect();
            lines.put_back();
            return Ok(());
        }
        Ok(())
    }

    /// The columns by their names.
    pub(crate) fn offers(&self) -> Vec<Offer> {
        let of = |index: usize| {
            let mut offer = Offer::beside(&self.names[index], self.units[index].as_deref());
            if let Some(clash) = &mut offer.clash {
                let (number, text) = &self.units_line;
                clash.beside_at = Some(TextLine::of(&self.file, *number, text).cell(self.separator, index));
            }
            offer
        };
        (0..self.names.len()).map(of).collect()
    }

    /// The columns by their names, but for those that the map leaves unused.
    fn offers_of(&self, map: &ChannelMap) -> Vec<Offer> {
        let mut offers = self.offers();
        leave_unused(&mut offers, map);
        offers
    }

    /// The columns by their names; a column of dates that is time, by its name or by the map, has times in s.
    pub(crate) fn offers_with_stamps(&self, map: &ChannelMap) -> Vec<Offer> {
        let mut offers = self.offers_of(map);
        for (offer, _) in offers.iter_mut().zip(&self.stamped).filter(|(_, stamped)| **stamped) {
            if is_time(offer, map) {
                offer.is_in_seconds();
            }
        }
        offers
    }

    /// Whether a column is time by its name or the map.
    #[cfg(feature = "xlsx")]
    pub(crate) fn has_time(&self, map: &ChannelMap) -> bool {
        self.offers_of(map).iter().any(|offer| is_time(offer, map))
    }

    /// Checks that the column of time, if it has dates, has such as are read.
    pub(crate) fn check_times(&self, map: &ChannelMap) -> Result<(), RecordingError> {
        let offers = self.offers_of(map);
        match self.unreadable.iter().find(|(index, ..)| is_time(&offers[*index], map)) {
            Some((index, place, found)) => {
                let fault = TextFault::UnreadableTime { header: self.names[*index].clone(), found: found.clone() };
                Err(RecordingError::Text { place: place.clone(), fault })
            }
            None => Ok(()),
        }
    }

    /// Whether the times of a column are dates or times of day.
    pub(crate) fn is_stamped(&self, index: usize) -> bool {
        self.stamped[index]
    }

    /// The unit of a column, where it has a known one.
    pub(crate) fn unit(&self, index: usize) -> Option<Unit> {
        let in_name = split_header(&self.names[index]).1;
        in_name.or(self.units[index].as_deref()).and_then(Unit::parse)
    }

    pub(crate) fn place(&self, index: usize) -> Place {
        TextLine::of(&self.file, self.line.0, &self.line.1).cell(self.separator, index)
    }

    /// The error of a text without time.
    pub(crate) fn without_time(&self) -> RecordingError {
        let place = self.place(0);
        match self.names.as_slice() {
            [one] if one.parse::<f64>().is_err() => {
                // Two units in brackets, or two words as far apart as in columns.
                let has_blanks = one.contains("  ") || one.matches('[').count() > 1;
                RecordingError::Text { place, fault: TextFault::NoSeparator { has_blanks } }
            }
            _ => RecordingError::NoTimeColumn { place, present: self.names.clone() },
        }
    }
}

/// Whether a column is time by its name or the map.
fn is_time(offer: &Offer, map: &ChannelMap) -> bool {
    offer.is_named(Signal::Time) || map.get(Signal::Time).is_some_and(|mapping| offer.is_meant_by(mapping))
}

/// Units of other programs, which are not read: they make a row one of units, and contradict a header.
const OTHERS: [&str; 24] = [
    "cm", "dm", "km", "in", "inch", "ft", "h", "min", "ns", "kV", "A", "mbar", "hPa", "GPa", "kgf", "lbf", "daN", "MN",
    "l/s", "l/h", "m3/h", "gpm", "°F", "degF",
];

/// Whether these cells are units: at least one is, and none is a number but the 1 of a pure number. A sign of a missing value is an empty cell.
fn are_units(names: &[String], cells: Cells<'_>) -> bool {
    let mut any = false;
    for (index, cell) in cells.iter().enumerate() {
        let Some(text) = unit_text(cell) else { continue };
        let is_number = is_number(&text);
        let may_be_pure = || names.get(index).is_none_or(|name| may_be_pure(name));
        if is_number && !(text == "1" && may_be_pure()) || clock::is_stamp(cell) {
            return false;
        }
        any |= !is_number && text != "-" && (Unit::parse(&text).is_some() || OTHERS.contains(&text.as_str()));
    }
    any
}

/// Whether the unit of a column with this name may be 1.
fn may_be_pure(name: &str) -> bool {
    let (short, unit) = split_header(name);
    unit.is_none_or(|unit| is_same_unit(unit, "1")) && Signal::parse(short).is_none_or(Signal::is_dimensionless)
}

/// A unit with or without brackets around it; `None` for a cell without a value.
fn unit_text(cell: &str) -> Option<String> {
    if is_missing(cell) {
        return None;
    }
    let inner = [('[', ']'), ('(', ')'), ('<', '>')]
        .into_iter()
        .find_map(|(open, close)| cell.strip_prefix(open).and_then(|rest| rest.strip_suffix(close)));
    Some(inner.unwrap_or(cell).trim()).filter(|text| !text.is_empty()).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use crate::{ChannelMap, RecordingError, Signal, read_from};

    fn read(text: &str) -> Result<crate::Recording, RecordingError> {
        read_from("run.csv", text.as_bytes(), &ChannelMap::default())
    }

    #[test]
    fn a_row_of_units_below_the_header_is_read() {
        for units in ["ms;mm;1;bar", "[ms];[mm];[1];[bar]", "(ms);(mm);(-);(bar)", "ms;mm;;bar"] {
            let text = format!("time;position;spool;pressure_a\n{units}\n0;1,5;0,1;70\n10;2,5;0,2;71\n");
            let recording = read(&text).unwrap();
            assert_eq!(recording.time_s(), [0.0, 0.01], "{units}");
            assert_eq!(recording.signal(Signal::Position).unwrap(), [0.0015, 0.0025]);
            assert_eq!(recording.signal(Signal::PressureA).unwrap(), [70e5, 71e5]);
            assert_eq!(recording.column(Signal::Position).unwrap().header, "position [mm]");
        }
        for units in ["s,mm", "sec,[mm]", ",(mm)", "s,", "s,n/a"] {
            let both = read(&format!("time [s],position [mm]\n{units}\n0,1\n1,2\n")).unwrap();
            assert_eq!(both.signal(Signal::Position).unwrap(), [0.001, 0.002], "{units}");
        }
        let map = ChannelMap::from_arguments(["position=Weg", "time=Zeit"]).unwrap();
        let mapped = read_from("r.csv", &b"Weg;Zeit\nmm;s\n1,5;0\n2,5;1\n"[..], &map).unwrap();
        assert_eq!(mapped.signal(Signal::Position).unwrap(), [0.0015, 0.0025]);
        assert!(matches!(read("time,position\n0,1\n1,2\n"), Err(RecordingError::MissingUnit { .. })));
        let unused = read("time,position,x\ns,mm,NaN\n0,1,2\n1,2,2\n").unwrap();
        assert_eq!(unused.signal(Signal::Position).unwrap(), [0.001, 0.002]);
        // Neither words nor a row of numbers is a row of units.
        assert_eq!(read("time [s],spool,N\n1,1,N\n2,1,N\n").unwrap().time_s(), [1.0, 2.0]);
        let words = read("time [s],position [mm]\nfloat,float\n0,1\n1,2\n").unwrap_err();
        assert!(matches!(words, RecordingError::NotANumber { .. }), "{words}");
        let beside = read("time [s],position [mm]\n,CH1\n0,1\n1,2\n").unwrap_err();
        assert!(matches!(beside, RecordingError::NotANumber { .. }), "{beside}");
    }

    #[test]
    fn a_row_of_units_that_contradicts_the_header_is_refused_with_both_cells() {
        let told = read("time [s],position [mm]\ns,cm\n0,1\n1,2\n").unwrap_err().to_string();
        let expected = "run.csv:1:10: column `position [mm]` has the unit `mm` in its name and `cm` in the row of units, line 2 column 3; expected one \
                        unit: correct the header or the row of units";
        assert_eq!(told, expected);
        for text in ["time [s],position [mm]\n,m", "time [s],position [mm]\n,cm", "time [ms],position [mm]\ns,mm"] {
            let told = read(&format!("{text}\n0,1\n1,2\n")).unwrap_err();
            assert!(matches!(told, RecordingError::Text { .. }), "{told}");
        }
        // Behind an underscore, too, where the column is mapped; a letter may stand for something else.
        let map = ChannelMap::from_arguments(["position=Weg_mm", "force=Kraft_s"]).unwrap();
        let read_mapped = |text: &str| read_from("r.csv", text.as_bytes(), &map);
        assert!(read_mapped("time [s],Weg_mm,Kraft_s\ns,cm,N\n0,1,2\n1,2,2\n").is_err());
        let agreed = read_mapped("time [s],Weg_mm,Kraft_s\ns,mm,N\n0,1,2\n1,2,2\n").unwrap();
        assert_eq!(agreed.signal(Signal::Position).unwrap(), [0.001, 0.002]);
        // A column that nobody needs does not matter, nor does one that is left out.
        assert_eq!(read("time [s],spool,x [mm]\ns,1,cm\n0,1,1\n1,2,1\n").unwrap().rows(), 2);
        assert!(read("time [s],position\n,cm\n0,1\n1,2\n").unwrap_err().to_string().contains("unknown unit `cm`"));
    }

    #[test]
    fn the_line_that_tells_excel_the_separator_is_read() {
        let rows = |mark: char| format!("time [s]{mark}x, y{mark}position [mm]\n0{mark}9{mark}1\n1{mark}9{mark}2\n");
        for (line, mark) in
            [("sep=;", ';'), ("SEP=;", ';'), ("\"sep=;\"", ';'), ("sep=;;;", ';'), ("sep=\t", '\t'), ("sep=|", '|')]
        {
            let recording = read(&format!("\u{feff}{line}\r\n{}", rows(mark))).unwrap();
            assert_eq!(recording.signal(Signal::Position).unwrap(), [0.001, 0.002], "{line}");
        }
        let comma = read("sep=,\ntime [s],position [mm]\n0,1\n1,2\n").unwrap();
        assert_eq!(comma.signal(Signal::Position).unwrap(), [0.001, 0.002]);
        assert!(matches!(read("sep=;\n"), Err(RecordingError::Empty { .. })));
        for mark in ['|', ':'] {
            let told = if mark == ':' { "sep=:\n" } else { "" };
            let other = read(&format!("{told}{}", rows(mark).replace("x, y", "x"))).unwrap();
            assert_eq!(other.signal(Signal::Position).unwrap(), [0.001, 0.002], "{mark}");
        }
    }

    #[test]
    fn a_header_behind_a_mark_is_read_and_an_error_of_a_spreadsheet_is_a_cell() {
        for header in ["# time [s],position [mm]", "#time [s],position [mm]", "# made by x\n# time [s],position [mm]"] {
            let recording = read(&format!("{header}\n0,1\n0.5,2\n")).unwrap();
            assert_eq!(recording.time_s(), [0.0, 0.5], "{header}");
        }
        let indexed = read("#,time [s],position [mm]\n0,0,1\n1,0.5,2\n").unwrap();
        assert_eq!(indexed.time_s(), [0.0, 0.5]);
        let missing = read("time [s],position [mm]\n0,1\n#N/A,2\n#NV,2\n0.3,4\n").unwrap();
        assert_eq!((missing.rows(), missing.notes().len()), (2, 1), "{:?}", missing.notes());
        let error = read("time [s],position [mm]\n0,1\n#DIV/0!,2\n0.3,4\n").unwrap_err().to_string();
        assert!(error.starts_with("run.csv:3:1: column `time [s]` holds `#DIV/0!`"), "{error}");
        let comment = read("time [s],position [mm]\n0,1\n# 2,3\n0.3,4\n").unwrap();
        assert_eq!((comment.rows(), comment.notes().len()), (2, 0));
    }

    #[test]
    fn what_ends_a_file_of_dos_or_a_loss_of_power_leaves_is_no_row() {
        for end in ["\u{1a}", "\n\u{1a}", "\n\u{1a}\n", "\n\0\0\0\0", "\0\0"] {
            assert_eq!(
                read(&format!("time [s],position [mm]\n0,1\n0.5,2{end}")).unwrap().time_s(),
                [0.0, 0.5],
                "{end:?}"
            );
        }
    }

    #[test]
    fn a_header_without_a_separator_says_so() {
        for (text, told) in [
            ("time [s]   command [V]\n0   1\n", "separated by blanks"),
            ("time [s] command [V]\n0 1\n", "separated by blanks"),
            ("time  spool\n0\t1\n", "separated by blanks"),
            ("time:spool\n0:1\n", "a header of one cell"),
            ("Made by Somebody\ntime [s],spool\n", "lines above the header begin with `#`"),
        ] {
            let refused = read(text).unwrap_err().to_string();
            assert!(refused.contains(told) && refused.contains("`sep=:`"), "{refused}");
        }
    }

    #[test]
    fn a_separator_at_the_end_of_lines_is_no_cell() {
        for text in [
            "time [s],spool,\n0,1,\n1,2,\n",
            "time [s],spool\n0,1,\n1,2,\n",
            "time [s],spool,\n0,1\n1,2\n",
            "time [s];spool;;\n0;1\n1;2;\n",
        ] {
            let recording = read(text).unwrap();
            assert_eq!(recording.signal(Signal::Spool).unwrap(), [1.0, 2.0], "{text}");
            assert!(recording.ignored().is_empty());
        }
        assert!(matches!(read("time [s],spool\n0,1,5\n1,2,\n"), Err(RecordingError::RaggedRow { .. })));
    }

    #[test]
    fn time_is_found_in_any_column_and_never_taken_from_an_index() {
        for text in [
            ",time [s],position [mm]\n0,0.5,1\n1,0.6,2\n",
            "Unnamed: 0,position [mm],time [s]\n0,1,0.5\n1,2,0.6\n",
            "position [mm];index;time [s];\n1;0;0,5\n2;1;0,6\n",
        ] {
            let recording = read(text).unwrap();
            assert_eq!(recording.time_s(), [0.5, 0.6], "{text}");
            assert_eq!(recording.signal(Signal::Position).unwrap(), [0.001, 0.002]);
            assert_eq!(recording.columns()[0].signal, Signal::Time);
        }
        let refused = read(",Zeit [s],position [mm]\n0,0.5,1\n1,0.6,2\n").unwrap_err();
        let told = refused.to_string();
        let begins = "run.csv:1:1: no column is time; expected a column `time [s]` (or ms, µs), or --map \"time=Zeit [s]\"; other columns";
        assert!(told.starts_with(begins) && told.ends_with("The file has: Zeit [s], position [mm]"), "{told}");
        assert!(ChannelMap::from_arguments(["time= [s]"]).is_err());
        for name in ["index", "Unnamed: 0", "Nr."] {
            let map = ChannelMap::from_arguments([format!("time={name} [s]").as_str()]).unwrap();
            let read = |text: &str| read_from("run.csv", text.replace("index", name).as_bytes(), &map);
            let index = read("index,time [s],position [mm]\n0,0.5,1\n1,0.6,2\n2,0.7,3\n").unwrap_err();
            assert!(matches!(index, RecordingError::Index { .. }), "{index}");
            // Times that pandas had as its index are times.
            assert_eq!(read("index,position [mm]\n0.5,1\n0.6,2\n").unwrap().time_s(), [0.5, 0.6]);
        }
    }

    #[test]
    fn a_last_line_that_is_cut_off_is_not_read() {
        let whole = "time [s],position [mm],spool\n0,1.25,0.125\n1,2.25,0.250\n2,3.25,0.375\n3,4.25,0.500";
        assert_eq!(read(whole).unwrap().rows(), 4);
        assert!(read(whole).unwrap().notes().is_empty());
        let begins = whole.rfind('3').unwrap();
        for end in begins + 1..whole.len() {
            let recording = read(&whole[..end]).unwrap();
            assert_eq!((recording.rows(), recording.time_s()[2]), (3, 2.0), "{}", &whole[..end]);
            let told: Vec<String> = recording.notes().iter().map(ToString::to_string).collect();
            assert_eq!(told, ["line 5, the last one, is cut off and is not read"]);
        }
        // A line of words below the rows is none of them.
        for words in
            ["End of file", "End of file,,", "Average,1.5,100", "Max,,", "--- END ---", "// made by,a,b", "% end"]
        {
            let rows = "time [s],position [mm],spool\n0,1.25,0.125\n1,2.25,0.250\n";
            let last = read(&format!("{rows}{words}\n")).unwrap();
            let told: Vec<String> = last.notes().iter().map(ToString::to_string).collect();
            assert!(
                last.rows() == 2 && told.len() == 1 && told[0].starts_with("line 4, the last one, begins with `"),
                "{told:?}"
            );
            let more = read(&format!("{rows}{words}\nMin,1,2\n")).unwrap_err().to_string();
            assert!(
                more.starts_with("run.csv:4:1: a line of words, `")
                    && more.ends_with("delete the line, or begin it with `#`"),
                "{more}"
            );
        }
        // With rows behind it, it is not cut off.
        assert!(matches!(read("time [s],spool\n0,1\n1\n2,1\n"), Err(RecordingError::RaggedRow { .. })));
    }
}
