//! Where a command prints.

use std::fmt::{self, Display};
use std::io::{self, IsTerminal, Read, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use anstyle::{AnsiColor, Style};
use dialoguer::console::Term;
use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};

use recording::files::source_error::printable;

use super::error::CliError;

/// How much a command says beside its result, on standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Volume {
    /// Nothing but the reason of a failure: no notes, no progress.
    Quiet,
    /// Notes, and progress on a terminal.
    #[default]
    Usual,
    /// Also what each stage found and how long it took.
    Verbose,
}

/// Fewest characters of a terminal's line: with fewer a table cannot be read, or the terminal does not know its width.
const NARROWEST: u16 = 60;

/// What a line says about the drive, which a terminal shows as a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// All is well.
    Good,
    /// Something is to be looked at.
    Open,
    /// Something is wrong.
    Bad,
}

impl Tone {
    const fn style(self) -> Style {
        let colour = match self {
            Tone::Good => AnsiColor::Green,
            Tone::Open => AnsiColor::Yellow,
            Tone::Bad => AnsiColor::Red,
        };
        colour.on_default().bold()
    }
}

/// Standard output, and whether a person looks at it.
pub struct Console<'a> {
    out: &'a mut dyn Write,
    /// Whether the output is a terminal that wants colours: only then is anything coloured.
    pub terminal: bool,
    /// Characters of a terminal's line; `None` elsewhere, and where the width is unknown or too small for a table.
    pub width: Option<u16>,
    /// How much is said beside the result; `None` where nobody reads it.
    beside: Option<Volume>,
    /// Whether a document was printed that is to be alone: what is printed after it is dropped.
    alone: bool,
}

impl fmt::Debug for Console<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Console").field("terminal", &self.terminal).finish_non_exhaustive()
    }
}

impl<'a> Console<'a> {
    /// The console of this process, which prints to `out`, its standard output.
    ///
    /// Coloured as the terminal allows, and as `NO_COLOR` and `CLICOLOR_FORCE` ask.
    pub fn of_process(out: &'a mut dyn Write, volume: Volume) -> Self {
        let terminal = anstream::AutoStream::choice(&io::stdout()) != anstream::ColorChoice::Never;
        let size = Term::stdout().size_checked();
        let width = size.map(|(_, columns)| columns).filter(|columns| *columns >= NARROWEST);
        Self { out, terminal, width, beside: Some(volume), alone: false }
    }

    /// A console that prints into a buffer and shows no progress.
    pub fn into_buffer(out: &'a mut dyn Write) -> Self {
        Self { out, terminal: false, width: None, beside: None, alone: false }
    }

    /// Prints a line, or several. If the reader has closed the output, as `head` does, the text is dropped and the command continues.
    pub fn print(&mut self, text: impl Display) -> Result<(), CliError> {
        self.write(&printable(&text))
    }

    /// Prints a document for programs; nothing is printed after it.
    pub fn print_alone(&mut self, document: &str) -> Result<(), CliError> {
        self.write(document)?;
        self.alone = true;
        Ok(())
    }

    /// Prints text that contains its own styles; names from files in it have to be printable already.
    pub fn print_styled(&mut self, text: impl Display) -> Result<(), CliError> {
        self.write(&text.to_string())
    }

    /// Prints a part of a result that may be long, and returns an error when nobody reads it any more.
    pub fn stream(&mut self, text: impl Display) -> Result<(), CliError> {
        self.put(&printable(&text)).map_err(CliError::Output)
    }

    fn write(&mut self, text: &str) -> Result<(), CliError> {
        match self.put(text) {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(CliError::Output(error)),
            _ => Ok(()),
        }
    }

    fn put(&mut self, text: &str) -> io::Result<()> {
        if self.alone {
            return Ok(());
        }
        writeln!(self.out, "{text}").and_then(|()| self.out.flush())
    }

    /// Prints a line about the state of the drive, coloured on a terminal.
    pub fn verdict(&mut self, text: impl Display, tone: Tone) -> Result<(), CliError> {
        let style = if self.terminal { tone.style() } else { Style::new() };
        self.write(&format!("{style}{}{style:#}", printable(&text)))
    }

    /// Whether nothing but the result is wanted.
    #[must_use]
    pub fn is_quiet(&self) -> bool {
        self.beside == Some(Volume::Quiet)
    }

    /// Whether anything is said beside the result.
    fn talks(&self) -> bool {
        matches!(self.beside, Some(Volume::Usual | Volume::Verbose))
    }

    /// Says something beside the result, on standard error.
    pub fn note(&self, text: impl Display) {
        if self.talks() {
            // A closed standard error does not harm the result.
            let _ = writeln!(io::stderr(), "note: {}", printable(&text));
        }
    }

    /// Says what a stage found, on standard error, where `--verbose` asks for it.
    pub fn detail(&self, text: impl Display) {
        if self.beside == Some(Volume::Verbose) {
            let _ = writeln!(io::stderr(), "{}", printable(&text));
        }
    }

    /// A bar on standard error for this number of steps, with the time left; none where standard error is no terminal.
    #[must_use]
    pub fn progress(&self, steps: usize, doing: &'static str) -> Progress {
        self.shown(ProgressBar::new(steps as u64), "{msg} {wide_bar} {pos}/{len}{left}", doing)
    }

    /// The same in percent, for work that is counted in steps too small to show: bytes, rows.
    #[must_use]
    pub fn share(&self, whole: u64, doing: &'static str) -> Progress {
        self.shown(ProgressBar::new(whole), "{msg} {wide_bar} {percent} %{left}", doing)
    }

    /// The same for work that may end before all of its steps are done: the time left is the longest it can take.
    #[must_use]
    pub fn at_most(&self, most: u64, doing: &'static str) -> Progress {
        self.shown(ProgressBar::new(most), "{msg} {wide_bar} {percent} %{at_most}", doing)
    }

    /// A turning sign on standard error with the elapsed time, for work whose number of steps is unknown.
    #[must_use]
    pub fn working(&self, doing: &'static str) -> Progress {
        self.shown(ProgressBar::new_spinner(), "{spinner} {msg}, {elapsed}", doing)
    }

    fn shown(&self, bar: ProgressBar, template: &str, doing: &'static str) -> Progress {
        let verbose = self.beside == Some(Volume::Verbose);
        let began = Instant::now();
        if !self.talks() {
            return Progress { bar: ProgressBar::hidden(), doing, began, verbose, minutes: None };
        }
        // Where a bar cannot be drawn, as in a log, a line a minute tells that the work goes on.
        let minutes = (!io::stderr().is_terminal()).then(AtomicU64::default);
        let bar = match ProgressStyle::with_template(template) {
            Ok(style) => bar.with_style(style.with_key("left", left("")).with_key("at_most", left("at most "))),
            Err(_) => bar,
        };
        bar.set_message(doing);
        // The sign moves even while a step takes long.
        bar.enable_steady_tick(Duration::from_millis(200));
        Progress { bar, doing, began, verbose, minutes }
    }
}

/// Writes the time left; before the first step is done it is unknown.
fn left(bound: &'static str) -> impl Fn(&ProgressState, &mut dyn fmt::Write) + Clone + Send + Sync {
    move |state, out| {
        if state.pos() > 0 {
            // If the terminal does not accept the text, nothing is shown.
            let _ = write!(out, ", {bound}{:#} left", HumanDuration(state.eta()));
        }
    }
}

/// The progress of one stage.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    doing: &'static str,
    began: Instant,
    verbose: bool,
    /// Minutes that were told, where there is no terminal.
    minutes: Option<AtomicU64>,
}

impl Progress {
    /// This number of further steps is done.
    pub fn inc(&self, steps: u64) {
        self.bar.inc(steps);
        // The number of steps is sometimes an estimate.
        if let Some(all) = self.bar.length().filter(|all| self.bar.position() > *all) {
            self.bar.set_position(all);
        }
        self.tell();
    }

    /// Tells each minute once how far the work is, where there is no terminal.
    fn tell(&self) {
        let Some(minutes) = &self.minutes else { return };
        let now = self.began.elapsed().as_secs() / 60;
        if now > minutes.fetch_max(now, Ordering::Relaxed) {
            let _ = writeln!(io::stderr(), "{}", so_far(self.doing, now, self.bar.position(), self.bar.length()));
        }
    }

    /// Reads from `input`; each byte is a step.
    pub fn counting<R: Read>(&self, input: R) -> impl Read {
        self.bar.wrap_read(input)
    }

    /// This number of steps is done in all.
    pub fn reach(&self, steps: u64) {
        self.bar.set_position(steps);
        self.tell();
    }

    /// Prints something while the bar is hidden.
    pub fn aside<T>(&self, say: impl FnOnce() -> T) -> T {
        self.bar.suspend(say)
    }

    /// The stage is over: the bar is removed, and `--verbose` says how long the stage took.
    pub fn finish_and_clear(&self) {
        self.bar.finish_and_clear();
        if self.verbose {
            let seconds = self.began.elapsed().as_secs_f64();
            let _ = writeln!(io::stderr(), "{}: {seconds:.2} s", self.doing);
        }
    }
}

/// How far a stage is after so many minutes; estimates of its length may be short, and what still goes on is not told to be done.
fn so_far(doing: &str, minutes: u64, done: u64, of: Option<u64>) -> String {
    let share = of.filter(|of| *of > 0).map(|of| format!(", {} %", (100 * done.min(of) / of).min(99)));
    format!("{doing}: {minutes} min{}", share.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_in_a_log_tells_the_minutes_and_never_all_of_the_work() {
        assert_eq!(so_far("diagnosing", 1, 30, Some(120)), "diagnosing: 1 min, 25 %");
        assert_eq!(so_far("diagnosing", 12, 130, Some(120)), "diagnosing: 12 min, 99 %");
        assert_eq!(so_far("diagnosing", 2, 5, None), "diagnosing: 2 min");
    }

    #[test]
    fn nothing_is_printed_after_a_document_that_is_to_be_alone() {
        let mut out = Vec::new();
        let mut console = Console::into_buffer(&mut out);
        console.print_alone("{}").unwrap();
        console.print("text").unwrap();
        console.verdict("nothing missing", Tone::Good).unwrap();
        assert_eq!(out, b"{}\n");
    }

    #[test]
    fn a_verdict_is_coloured_on_a_terminal_only() {
        let mut out = Vec::new();
        Console::into_buffer(&mut out).verdict("nothing missing", Tone::Good).unwrap();
        assert_eq!(out, b"nothing missing\n");
        let mut out = Vec::new();
        Console::into_buffer(&mut out).print("a\u{1b}[2J\u{7}b\n\tc").unwrap();
        assert_eq!(out, b"a\\u{1b}[2J\\u{7}b\n\tc\n", "a name that a terminal would obey");
        let mut out = Vec::new();
        Console { out: &mut out, terminal: true, width: None, beside: None, alone: false }
            .verdict("unexplained", Tone::Open)
            .unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(text.starts_with("\u{1b}[") && text.ends_with("\u{1b}[0m\n"), "{text:?}");
    }
}
