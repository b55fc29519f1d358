//! All nights of a data set into a table, on every core, in any order.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::dataset::{Night, nights};
use crate::night::{How, judge};
use crate::row::Row;
use crate::table::{Table, TableError};

/// Why a run ended before its end.
#[derive(Debug, thiserror::Error)]
pub enum FleetError {
    /// The data set cannot be listed.
    #[error("{}: {cause}", path.display())]
    Dataset {
        /// The folder.
        path: PathBuf,
        /// Why.
        cause: std::io::Error,
    },
    /// There is no night in it.
    #[error("{}: no night of any drive; expected folders as drive=press-1/date=2026-11-30 with recordings, and drive=press-1/machine.toml", path.display())]
    NoNights {
        /// The folder.
        path: PathBuf,
    },
    /// The table.
    #[error(transparent)]
    Table(#[from] TableError),
}

/// Rows that are kept back at most before they are written.
const KEPT_ROWS: usize = 512;

/// How long rows are kept back at most, so far into a run: as much is judged again when it is killed. A tenth of what the run took so far, and never more than
/// 20 s: a long run then writes few parts.
fn kept(elapsed: Duration) -> Duration {
    (elapsed / 10).clamp(Duration::from_millis(500), Duration::from_secs(20))
}

/// Judged nights that wait for the table at most.
const WAITING: usize = 64;

/// The nights of a data set that a table does not have yet.
#[derive(Debug)]
pub struct Pending {
    nights: Vec<Night>,
    table: Table,
}

impl Pending {
    /// Opens the table, and finds what it lacks.
    ///
    /// # Errors
    /// The data set cannot be listed or has no night, or the table cannot be used.
    pub fn of(dataset: &Path, folder: &Path) -> Result<Self, FleetError> {
        let all = nights(dataset).map_err(|cause| FleetError::Dataset { path: dataset.to_owned(), cause })?;
        if all.is_empty() {
            return Err(FleetError::NoNights { path: dataset.to_owned() });
        }
        let table = Table::open(folder)?;
        Ok(Self { nights: all.into_iter().filter(|night| !table.has(&night.drive, &night.name)).collect(), table })
    }

    /// How many there are.
    #[must_use]
    pub fn nights(&self) -> usize {
        self.nights.len()
    }

    /// Judges them on every thread of the current pool; `told` is given the rows of each.
    ///
    /// # Errors
    /// The table cannot be written; what was written before stays, and the next run goes on there.
    pub fn run(self, how: &How, told: &(dyn Fn(&[Row]) + Sync)) -> Result<(), FleetError> {
        let Self { nights, mut table } = self;
        let (to_table, judged) = sync_channel::<Vec<Row>>(WAITING);
        thread::scope(|scope| {
            let writer = scope.spawn(move || {
                let began = Instant::now();
                let (mut rows_kept, mut since) = (Vec::new(), began);
                loop {
                    let left = kept(began.elapsed()).saturating_sub(since.elapsed());
                    let next = judged.recv_timeout(left);
                    let is_over = matches!(next, Err(RecvTimeoutError::Disconnected));
                    if let Ok(rows) = next {
                        told(&rows);
                        rows_kept.extend(rows);
                    }
                    if is_over || rows_kept.len() >= KEPT_ROWS || since.elapsed() >= kept(began.elapsed()) {
                        table.append(&rows_kept)?;
                        rows_kept.clear();
                        since = Instant::now();
                    }
                    if is_over {
                        return Ok(());
                    }
                }
            });
            // A writer that has failed takes nothing more: then nothing more is judged.
            let _ = nights.par_iter().try_for_each(|night| to_table.send(judge(night, how)));
            drop(to_table);
            writer.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    }
}
