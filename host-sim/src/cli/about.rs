//! What a page says of how it was made: when, and by which command.

use std::env;
use std::path::PathBuf;

use jiff::tz::TimeZone;
use jiff::{Timestamp, ZonedDateTime};
use report::html::About;

use super::command_line::CommandLine;

/// A time that builds are given so that they repeat: <https://reproducible-builds.org/specs/source-date-epoch/>.
const GIVEN: &str = "SOURCE_DATE_EPOCH";

/// Now, by this command, of these machine files.
pub(crate) fn about(machine_files: &[PathBuf]) -> About {
    About {
        written: Some(now().strftime("%Y-%m-%d %H:%M %:z").to_string()),
        command: Some(CommandLine::of_process().to_string()),
        machine_files: machine_files.iter().map(|path| path.display().to_string()).collect(),
    }
}

fn now() -> ZonedDateTime {
    let given = env::var(GIVEN).ok().and_then(|seconds| Timestamp::from_second(seconds.parse().ok()?).ok());
    given.map_or_else(ZonedDateTime::now, |given| given.to_zoned_datetime(TimeZone::UTC))
}
