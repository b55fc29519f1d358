//! Long work: without Python's lock, on as many threads as wanted, and ended by Ctrl-C.

use std::panic;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use identification::stop::{self, Request};
use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;
use report::refused::Refused;

use crate::error::{OrRaise, Raised};

/// How often Python is asked for a signal: that costs microseconds, and nobody notices a tenth of a second.
const ASKED_EVERY: Duration = Duration::from_millis(50);

/// The result of the work, which runs on `threads` threads, as many as there are cores where none are given.
///
/// Python runs on meanwhile. Its signals are looked after on the calling thread; where a handler raises, as that of Ctrl-C does, the work is stopped at
/// its next simulation and the exception goes on.
pub(crate) fn unlocked<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    work: impl FnOnce() -> Result<T, Refused> + Send,
) -> PyResult<T> {
    if threads == Some(0) {
        return Err(Refused::argument("threads", "0; expected at least 1, or None for all cores").raised(py));
    }
    let request = Request::default();
    let obeyed = request.clone();
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .thread_name(|index| format!("host-sim-{index}"))
        .start_handler(move |_| stop::obey(&obeyed))
        .build()
        .map_err(|error| Refused::argument("threads", error).raised(py))?;
    let (signal, outcome) = py.detach(|| {
        thread::scope(|scope| {
            let (done, ended) = mpsc::channel();
            let working = scope.spawn(move || {
                let outcome = pool.install(|| stop::caught(work));
                // Nobody listens any more only where this has been awaited already.
                let _ = done.send(());
                outcome
            });
            let mut signal = None;
            // A panic in the work disconnects.
            while ended.recv_timeout(ASKED_EVERY) == Err(RecvTimeoutError::Timeout) {
                if signal.is_none() {
                    signal = Python::attach(of_python).err();
                    if signal.is_some() {
                        request.make();
                    }
                }
            }
            (signal, working.join())
        })
    });
    // A signal that came as the work ended is raised all the same.
    if let Some(signal) = signal {
        return Err(signal);
    }
    match outcome {
        Ok(Ok(result)) => result.or_raise(py),
        Ok(Err(_)) => Err(Refused::of("the work was stopped").raised(py)),
        Err(payload) => panic::resume_unwind(payload),
    }
}

/// The exception of a handler of a signal that has come in meanwhile.
fn of_python(py: Python<'_>) -> PyResult<()> {
    py.check_signals()
}
