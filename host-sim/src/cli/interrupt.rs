//! Ctrl-C, a request to end, a terminal that closes: the program stops, and leaves no file half-written.

use std::io::{self, Write};
use std::process;

use dialoguer::console::Term;

use recording::files::atomic;

/// Exit status of a program that was interrupted, as shells have it: 128 and the number of Ctrl-C's signal, for the other two as well.
pub const INTERRUPTED: u8 = 130;

/// From here on Ctrl-C, SIGTERM and SIGHUP remove what is being written and exit with [`INTERRUPTED`].
///
/// Files that are whole stay; so does a result that takes the place of an older one only when it is whole. Whoever started the
/// program with one of these signals ignored, as a shell does in the background and `nohup` for a terminal that closes, is taken at their word
/// for all three: a temporary file may stay then.
///
/// # Errors
/// Where the system takes no handler. The program can be interrupted then as well, but a temporary file may stay.
pub fn stop_cleanly() -> Result<(), ctrlc::Error> {
    let set = ctrlc::try_set_handler(|| {
        atomic::abandon();
        let errors = Term::stderr();
        if errors.is_term() {
            // A question or a bar may have left the cursor hidden; nobody may be there to see it.
            let _ = errors.show_cursor();
            let _ = writeln!(io::stderr());
        }
        process::exit(i32::from(INTERRUPTED));
    });
    match set {
        Err(ctrlc::Error::MultipleHandlers) => Ok(()),
        other => other,
    }
}
