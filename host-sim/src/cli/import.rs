//! `host-sim import`: a recording that the firmware has streamed out.

use std::fs::File;
use std::io::Read;
use std::path::PathBuf;

use serde_json::json;

use super::Outcome;
use super::console::Console;
use super::ending::{DOCUMENT, TEXT, is_standard_output};
use super::error::CliError;
use super::target::{check_one_output, check_targets, tell, write_or_print};
use crate::frames::{self, ImportError, MAX_CAPTURE_BYTES};

/// Arguments of `import`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  host-sim import --frames recorder.bin --out run.csv

Reads what the firmware's recorder streams out over a serial line, as it was captured, and writes a \
recording: one row a control period, SI units. A recording ends at its end or where frames are missing: \
rows behind a gap are left out and counted, as they may be those of another recording. A capture may \
hold several recordings: --which says which one.")]
pub struct Arguments {
    /// Captured bytes
    #[arg(long, value_name = "recorder.bin")]
    frames: PathBuf,
    /// Which recording of several, counted from 1
    #[arg(long, value_name = "number")]
    which: Option<usize>,
    /// Where to write the recording (CSV); - is standard output
    #[arg(long, value_name = "R.csv")]
    out: PathBuf,
    /// Write what was found in the capture for programs; `-` prints it in place of the text
    #[arg(long, value_name = "I.json")]
    json: Option<PathBuf>,
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let out = Some(arguments.out.as_path()).filter(|out| !is_standard_output(out));
    check_one_output(&arguments.out, arguments.json.as_deref())?;
    let document = ("--json", arguments.json.as_deref(), DOCUMENT);
    check_targets(&[("--out", out, TEXT), document], std::slice::from_ref(&arguments.frames))?;
    let mut bytes = Vec::new();
    File::open(&arguments.frames)
        .and_then(|file| file.take(MAX_CAPTURE_BYTES + 1).read_to_end(&mut bytes))
        .map_err(|cause| CliError::Unread { path: arguments.frames.clone(), cause })?;
    let failed = |cause| CliError::Import { frames: arguments.frames.clone(), cause };
    if bytes.len() as u64 > MAX_CAPTURE_BYTES {
        return Err(failed(ImportError::TooLarge));
    }
    let stream = frames::stream(&bytes).map_err(failed)?;
    let (losses, rows_of_none) = (stream.losses, stream.rows_of_none);
    let held = stream.recordings.len();
    let recording = stream.chosen(arguments.which).map_err(failed)?;
    let csv = recording.csv().map_err(failed)?;
    let name = arguments.frames.display();
    if losses.missing + losses.refused > 0 || recording.rows_lost() > 0 {
        console.note(format!(
            "{name}: {} of {} rows are lost ({} frames missing, {} damaged or foreign)",
            recording.rows_lost(),
            recording.rows_sent,
            losses.missing,
            losses.refused
        ));
    }
    if rows_of_none > 0 {
        console.note(format!(
            "{name}: {rows_of_none} rows stand behind a gap in the frames or after an end, and may be those of a recording whose header was lost: \
             they are left out. Stream it out once more to have them"
        ));
    }
    write_or_print(&arguments.out, &csv, console)?;
    let document = || {
        json!({
            "schema": "host-sim/import/1",
            "machine": recording.machine,
            "frames": arguments.frames.display().to_string(),
            "out": arguments.out.display().to_string(),
            "recordings": held,
            "which": arguments.which.unwrap_or(1),
            "tick_ms": 1e3 * recording.tick_s,
            "rows_sent": recording.rows_sent,
            "rows_lost": recording.rows_lost(),
            "trigger_row": recording.trigger,
            "frames_missing": losses.missing,
            "frames_refused": losses.refused,
            "rows_of_none": rows_of_none,
        })
    };
    tell(arguments.json.as_deref(), document, console)?;
    Ok(Outcome::Done)
}
