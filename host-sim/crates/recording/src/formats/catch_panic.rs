//! Contains the panics of a library.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// The result of the work; `None` where it panics. The panic prints no message.
///
/// For a library that reads files and may panic on damaged ones; nothing that a panic leaves behind may be used again.
pub(crate) fn contained<T>(work: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !QUIET.get() {
                before(info);
            }
        }));
    });
    let outer = QUIET.replace(true);
    let outcome = panic::catch_unwind(AssertUnwindSafe(work));
    QUIET.set(outer);
    outcome.ok()
}

#[cfg(test)]
mod tests {
    use super::contained;

    #[test]
    fn a_panic_becomes_nothing_and_work_goes_on() {
        assert_eq!(contained(|| 3), Some(3));
        assert_eq!(contained(|| Vec::<u8>::new()[std::hint::black_box(1)]), None);
        assert_eq!(contained(|| 4), Some(4));
    }
}
