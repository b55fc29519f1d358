//! Other people's troubles, where they are available: what each command answers, as a table.
//!
//! `RENEW=1 cargo test -p host-sim --features virtual-plant --test cli troubles` writes `troubles.md`. The two of the FMU are tests of `tests/export`;
//! each kind has tests on inputs of the project's own besides.

use std::fmt::Write as _;

use super::at_hand::shared;
use super::process::{root, run, text};

/// A command, the exit status that is right, and what the line that answers holds (each gap of it one space).
const ASKED: [(&str, i32, &str); 24] = [
    ("diagnose absolute-pressures/folder", 0, "taken as absolute; if they are"),
    ("diagnose absolute-pressures/folder", 0, "nothing missing"),
    ("diagnose clipped-sensor/clip40", 0, "the end of its sensor's range"),
    ("diagnose clipped-sensor/clip40", 0, "nothing missing"),
    ("diagnose coarse-stamps/rounded10ms", 0, "they are spread evenly"),
    ("diagnose coarse-stamps/rounded10ms", 0, "nothing missing"),
    ("inspect command-tenth/r.csv --machine command-tenth/machine.toml", 0, "10 times as far as gain_per_v says"),
    ("inspect csv-nan/r.csv", 0, "15 rows have an empty cell and are left out"),
    ("inspect excel-sep-line/r.csv", 0, "398 rows, 0.7940 s"),
    ("import --frames import-lost-header/capture.bin --out OUT/run", 0, "40 rows stand behind a gap in the frames"),
    ("inspect map-underscore-unit/kolben.mat --map position=Kolbenweg_mm", 0, "Kolbenweg_mm [mm] 149.0 185.3 mm"),
    ("inspect map-underscore-unit/kolben.parquet --map position=Kolbenweg_mm", 0, "Kolbenweg_mm [mm] 149.0 185.3 mm"),
    ("inspect map-underscore-unit/run.mat --map position=run.position_mm", 0, "run.position_mm [mm] 149.0 185.3 mm"),
    ("inspect mat-refusals/controldesk.mat", 0, "position [mm] 149.0 185.3 mm"),
    ("inspect mat-refusals/v4.mat", 0, "position [mm] 149.0 185.3 mm"),
    ("inspect mdf-composition/struct.mf4", 0, "Bench.position, Bench.command: no known signal; --map names them"),
    ("inspect mdf-partial-conversion/type3.mf4", 2, "asammdf exports them"),
    ("inspect mdf-partial-conversion/type7.mf4", 0, "position [mm] 149.0 185.3 mm"),
    ("inspect pandas-index-first/r.csv", 0, "1501 rows, 3.000 s"),
    ("inspect parquet-duration/timedelta_index.parquet", 0, "1501 rows, 3.000 s"),
    ("diagnose start-state/folder", 0, "nothing missing"),
    (
        "inspect thousands-mark/r.csv --machine thousands-mark/machine.toml",
        2,
        "holds `1.004` with a point, and column `time [s]` holds `0,000`",
    ),
    (
        "inspect twincat-unscaled/unscaled.csv --machine twincat-unscaled/machine.toml",
        0,
        "the header states a scale factor or offset",
    ),
    ("diagnose unit-absorbed/folder", 2, "position seems to be a tenth of what it should be"),
];

#[test]
fn other_peoples_troubles_are_answered() {
    let Some(folder) = shared("troubles") else { return };
    let out = tempfile::tempdir().unwrap();
    let mut table = "| command | exit | the line that answers |\n|---|---|---|\n".to_owned();
    for (command, status, answer) in ASKED {
        let arguments = command.replace("OUT", &out.path().display().to_string());
        let output = run(&folder, &arguments.split(' ').collect::<Vec<_>>());
        let said = text(&output.stderr) + &text(&output.stdout);
        assert_eq!(output.status.code(), Some(status), "{command}: {said}");
        let spaced_once = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
        let line = said.lines().map(spaced_once).find(|line| line.contains(answer));
        let line = line.unwrap_or_else(|| panic!("{command}: no line holds `{answer}`:\n{said}"));
        writeln!(table, "| `{command}` | {status} | {line} |").unwrap();
    }
    let kept = root().join("host-sim/tests/cli/troubles.md");
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(&kept, &table).unwrap();
    }
    assert_eq!(std::fs::read_to_string(kept).unwrap(), table, "RENEW=1 writes it anew");
}
