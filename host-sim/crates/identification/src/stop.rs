//! Ends a computation that nobody waits for any more.
//!
//! A search takes minutes, and whoever started it may lose interest: Ctrl-C in Python, where ending the process is no answer. The threads that
//! compute [`obey`] a request; once that is made, the next simulation, or the next item of [`parallel`](crate::parallel), unwinds the stack with
//! [`Stopped`] as its payload. It is no panic: no message is printed. [`caught`] turns it into a value again. Nothing half-computed remains, since
//! all results are returned. A thread that obeys nothing, as in the program, never unwinds.

use std::cell::RefCell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A request to stop, shared by whoever makes it and the threads that obey it.
#[derive(Clone, Debug, Default)]
pub struct Request(Arc<AtomicBool>);

impl Request {
    /// Asks the threads that obey it to stop.
    pub fn make(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    fn is_made(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// What a computation that was asked to stop leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped;

thread_local! {
    static OBEYED: RefCell<Option<Request>> = const { RefCell::new(None) };
}

/// From here on this thread stops when it is asked to.
pub fn obey(request: &Request) {
    OBEYED.set(Some(request.clone()));
}

/// Unwinds with [`Stopped`] where this thread was asked to stop.
pub fn here() {
    let is_asked = OBEYED.with_borrow(|request| request.as_ref().is_some_and(Request::is_made));
    if is_asked {
        panic::resume_unwind(Box::new(Stopped));
    }
}

/// The result of the work; [`Stopped`] where it was stopped. A panic goes on as a panic.
///
/// # Errors
/// If the work was asked to stop and did.
pub fn caught<T>(work: impl FnOnce() -> T) -> Result<T, Stopped> {
    panic::catch_unwind(AssertUnwindSafe(work)).map_err(|payload| match payload.downcast_ref::<Stopped>() {
        Some(stopped) => *stopped,
        None => panic::resume_unwind(payload),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel;

    fn pool(request: &Request) -> rayon::ThreadPool {
        let obeyed = request.clone();
        rayon::ThreadPoolBuilder::new().num_threads(2).start_handler(move |_| obey(&obeyed)).build().unwrap()
    }

    #[test]
    fn a_request_stops_all_threads_that_obey_it_and_no_other() {
        let request = Request::default();
        let pool = pool(&request);
        let worked = || pool.install(|| caught(|| parallel::each(0..10, |item| item).len()));
        assert_eq!(worked(), Ok(10));
        request.make();
        assert_eq!(worked(), Err(Stopped));
        assert_eq!(caught(|| parallel::each(0..10, |item| item).len()), Ok(10), "this thread obeys nothing");
    }

    #[test]
    fn a_request_that_is_made_meanwhile_ends_the_items_that_are_left() {
        let request = Request::default();
        let done = std::sync::atomic::AtomicUsize::new(0);
        let one_by_one = || {
            parallel::each(0..1000, |item: usize| {
                done.fetch_add(1, Ordering::Relaxed);
                if item == 0 {
                    request.make();
                }
            });
        };
        assert_eq!(pool(&request).install(|| caught(one_by_one)), Err(Stopped));
        assert!(done.load(Ordering::Relaxed) < 1000);
    }
}
