//! Columns that another program holds in memory, such as those of a data frame.

use std::fmt;

use super::columns::{Contents, Offered, recording};
use crate::channel_map::ChannelMap;
use crate::error::RecordingError;
use crate::recording::Recording;

/// A column in memory.
#[derive(Debug)]
pub struct ColumnInMemory<'a> {
    /// Its name, with its unit in brackets or after an underscore where `unit` does not give it.
    pub name: String,
    /// The unit of its values.
    pub unit: Option<String>,
    /// The number of its values.
    pub rows: usize,
    /// What it holds, in its unit.
    pub held: Held<'a>,
}

/// What a column in memory holds.
pub enum Held<'a> {
    /// Numbers; NaN where there is none. They are asked for once, and only where the column is a known signal.
    Numbers(Box<dyn Fn() -> Vec<f64> + 'a>),
    /// Something else, named for a message: "text".
    Other(&'static str),
}

impl fmt::Debug for Held<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Held::Numbers(_) => "numbers",
            Held::Other(what) => what,
        })
    }
}

impl Recording {
    /// The recording that columns in memory hold, by the rules for a file without lines: the names, units, missing values and times of Parquet.
    ///
    /// `name` stands for the file in messages and results.
    ///
    /// ```
    /// use recording::{ChannelMap, ColumnInMemory, Held, Recording, Signal};
    ///
    /// let column = |name: &str, values: [f64; 3]| ColumnInMemory {
    ///     name: name.to_owned(),
    ///     unit: None,
    ///     rows: values.len(),
    ///     held: Held::Numbers(Box::new(move || values.to_vec())),
    /// };
    /// let columns = vec![column("time_ms", [0.0, 1.0, 2.0]), column("position [mm]", [125.0, 125.5, 126.0])];
    /// let recording = Recording::of_columns("run", columns, &ChannelMap::default())?;
    /// assert_eq!(recording.signal(Signal::Position), Some([0.125, 0.1255, 0.126].as_slice()));
    /// # Ok::<(), recording::RecordingError>(())
    /// ```
    pub fn of_columns(name: &str, columns: Vec<ColumnInMemory<'_>>, map: &ChannelMap) -> Result<Self, RecordingError> {
        let offered = |column: &ColumnInMemory<'_>| {
            let (name, unit) = (column.name.clone(), column.unit.clone());
            Offered { name, also: Vec::new(), unit, is_typed: false, base: 0, clock: false }
        };
        let offered = columns.iter().map(offered).collect();
        recording(name, &InMemory { offered, columns }, map)
    }
}

struct InMemory<'a> {
    offered: Vec<Offered>,
    columns: Vec<ColumnInMemory<'a>>,
}

impl Contents for InMemory<'_> {
    const KIND: &'static str = "column";

    fn offered(&self) -> &[Offered] {
        &self.offered
    }

    /// All belong to the times of one table; a column that is shorter or longer is an error.
    fn rows(&self, _: usize) -> usize {
        self.columns.first().map_or(0, |column| column.rows)
    }

    fn instead(&self, index: usize) -> Option<&'static str> {
        match self.columns[index].held {
            Held::Numbers(_) => None,
            Held::Other(what) => Some(what),
        }
    }

    fn values(&self, index: usize) -> Result<Vec<f64>, RecordingError> {
        Ok(match &self.columns[index].held {
            Held::Numbers(values) => values(),
            Held::Other(_) => Vec::new(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::source_error::Explained;
    use crate::signal::Signal;

    fn column(name: &str, values: &[f64]) -> ColumnInMemory<'static> {
        let values = values.to_vec();
        let held = Held::Numbers(Box::new(move || values.clone()));
        ColumnInMemory { name: name.to_owned(), unit: None, rows: 3, held }
    }

    fn read(columns: Vec<ColumnInMemory<'_>>) -> Result<Recording, RecordingError> {
        Recording::of_columns("run", columns, &ChannelMap::default())
    }

    #[test]
    fn a_unit_beside_the_name_counts_like_one_in_it() {
        let time = || column("time [s]", &[0.0, 1.0, 2.0]);
        let mut apart = column("position", &[1.0, 2.0, 3.0]);
        apart.unit = Some("mm".to_owned());
        let one = read(vec![time(), apart]).unwrap();
        assert_eq!(one, read(vec![time(), column("position [mm]", &[1.0, 2.0, 3.0])]).unwrap());
        assert_eq!(one.column(Signal::Position).unwrap().header, "position [mm]");
    }

    #[test]
    fn a_column_that_is_left_unused_is_not_known_by_any_of_its_names() {
        let columns =
            || vec![column("time_s", &[0.0, 1.0, 2.0]), column("position_mm", &[1.0; 3]), column("spool", &[0.0; 3])];
        for header in ["position_mm", "position [mm]"] {
            let mut map = ChannelMap::default();
            map.leave_unused(header);
            let read = Recording::of_columns("run", columns(), &map).unwrap();
            assert!(!read.has(Signal::Position) && read.has(Signal::Spool), "{header}");
            assert_eq!(read.ignored(), ["position_mm"]);
        }
        let mut map = ChannelMap::default();
        map.leave_unused("time_s");
        assert!(matches!(Recording::of_columns("run", columns(), &map), Err(RecordingError::NoTimes { .. })));
    }

    #[test]
    fn an_error_names_column_and_row() {
        let error = read(vec![column("time [s]", &[0.0, 2.0, 1.0]), column("spool", &[0.0; 3])]).unwrap_err();
        assert_eq!((&*error.place().file, error.place().row()), ("run", Some(3)));
        assert_eq!(error.key().as_deref(), Some("time"));
        let infinite = read(vec![column("time [s]", &[0.0, 1.0, 2.0]), column("spool", &[0.0, f64::INFINITY, 0.0])]);
        let infinite = infinite.unwrap_err();
        assert_eq!((infinite.place().row(), infinite.key().as_deref()), (Some(2), Some("spool")));
    }

    #[test]
    fn text_is_refused_only_where_it_is_a_known_signal() {
        let text = |name: &str| ColumnInMemory { held: Held::Other("text"), ..column(name, &[]) };
        let time = || column("time [s]", &[0.0, 1.0, 2.0]);
        let spool = || column("spool", &[0.0, 0.1, 0.2]);
        assert_eq!(read(vec![time(), text("remark"), spool()]).unwrap().columns().len(), 2);
        let error = read(vec![time(), text("position [mm]"), spool()]).unwrap_err();
        assert!(matches!(error, RecordingError::NotNumbers { .. }), "{error}");
    }

    #[test]
    fn columns_of_different_lengths_are_refused() {
        let mut short = column("spool", &[0.0, 0.1]);
        short.rows = 2;
        let error = read(vec![column("time [s]", &[0.0, 1.0, 2.0]), short]).unwrap_err();
        assert!(matches!(error, RecordingError::LengthMismatch { found: 2, expected: 3, .. }), "{error}");
    }
}
