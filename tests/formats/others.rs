//! Written files are read by the tools that people use: scipy, pyarrow.

use std::process::Command;

use recording::ChannelMap;
use system_tests::python::python_with;

/// Every column as the tool reads it: its name, and its values; `None` for a missing value.
type Columns = Vec<(String, Vec<Option<f64>>)>;

/// What the tool of `format` reads from the file written from `text`; `None` where the tool is not available.
fn read_by_others(format: &'static str, module: &str, text: &str) -> Option<Columns> {
    let python = python_with(module)?;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(format!("out.{format}"));
    let recording = recording::read_from("run.csv", text.as_bytes(), &ChannelMap::default()).unwrap();
    recording.write(&path, &[], &[]).unwrap();
    let output = Command::new(python).args(["-c", include_str!("others.py"), format]).arg(&path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let column = |line: &str| {
        let mut cells = line.split('\t');
        let name = cells.next().unwrap().to_owned();
        (name, cells.map(|cell| (cell != "none").then(|| cell.parse().unwrap())).collect())
    };
    Some(String::from_utf8(output.stdout).unwrap().lines().map(column).collect())
}

/// A recording with a missing value, a name with its unit, and one without.
const RECORDING: &str = "time [s],spool,position [mm]\n0,0,1.25\n0.5,,0.1\n1,-1,3e-7\n";

fn expected(names: [&str; 3]) -> Columns {
    let values = [[0.0, 0.5, 1.0].map(Some), [Some(0.0), None, Some(-1.0)], [1.25, 0.1, 3e-7].map(Some)];
    names.into_iter().zip(values).map(|(name, values)| (name.to_owned(), values.to_vec())).collect()
}

#[test]
pub(crate) fn scipy_reads_a_mat_file_that_is_written() {
    let Some(found) = read_by_others("mat", "scipy.io", RECORDING) else { return };
    assert_eq!(found, expected(["time_s", "spool", "position_mm"]));
}

#[test]
pub(crate) fn pyarrow_reads_a_parquet_file_that_is_written() {
    let Some(found) = read_by_others("parquet", "pyarrow.parquet", RECORDING) else { return };
    assert_eq!(found, expected(["time [s]", "spool", "position [mm]"]));
}
