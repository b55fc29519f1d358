//! Where a command prints.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};

use indicatif::{ProgressBar, ProgressStyle};

use super::CliError;

/// Standard output, and whether people look at it.
pub struct Console<'a> {
    out: &'a mut dyn Write,
    /// Whether the output is a terminal: only then is anything coloured.
    pub terminal: bool,
    progress: bool,
}

impl std::fmt::Debug for Console<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Console").field("terminal", &self.terminal).finish_non_exhaustive()
    }
}

impl<'a> Console<'a> {
    /// The console of this process, which prints to `out`, its standard output.
    pub fn of_process(out: &'a mut dyn Write) -> Self {
        Self { out, terminal: io::stdout().is_terminal(), progress: true }
    }

    /// A console that prints into a buffer and shows no progress.
    pub fn into_buffer(out: &'a mut dyn Write) -> Self {
        Self { out, terminal: false, progress: false }
    }

    /// Prints a line, or several.
    pub fn print(&mut self, text: impl Display) -> Result<(), CliError> {
        writeln!(self.out, "{text}").and_then(|()| self.out.flush()).map_err(CliError::Output)
    }

    /// Says something beside the result, on standard error.
    pub fn note(&self, text: impl Display) {
        if self.progress {
            // A closed standard error takes nothing from the result.
            let _ = writeln!(io::stderr(), "note: {text}");
        }
    }

    /// A bar on standard error for so many steps; none where that is no terminal.
    #[must_use]
    pub fn progress(&self, steps: usize, doing: &'static str) -> ProgressBar {
        if !self.progress {
            return ProgressBar::hidden();
        }
        let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}");
        let bar = ProgressBar::new(steps as u64).with_message(doing);
        style.map_or_else(|_| bar.clone(), |style| bar.clone().with_style(style))
    }
}
