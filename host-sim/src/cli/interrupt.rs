//! Ctrl-C, a termination request, a terminal that closes: the program stops, and leaves no file half-written.

use std::io::{self, Write};
use std::process;

use dialoguer::console::Term;

use recording::files::atomic;

/// Exit status of an interrupted program, as shells define it: 128 and the number of Ctrl-C's signal; it is used for the other two signals as well.
pub const INTERRUPTED: u8 = 130;

/// From here on Ctrl-C, SIGTERM and SIGHUP remove what is being written and exit with [`INTERRUPTED`].
///
/// Complete files stay; so does an older result, which a new one replaces only when it is complete. If the program was started
/// with one of these signals ignored, as a shell does in the background and `nohup` for a terminal that closes, all three are
/// ignored: a temporary file may stay then.
///
/// # Errors
/// If the system accepts no handler. The program can be interrupted then as well, but a temporary file may stay.
pub fn stop_cleanly() -> Result<(), ctrlc::Error> {
    let set = ctrlc::try_set_handler(|| {
        atomic::abandon();
        let errors = Term::stderr();
        if errors.is_term() {
            // A question or a bar may have hidden the cursor; an error here is ignored, because the terminal may be gone.
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
