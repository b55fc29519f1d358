//! The command line: one file for each command, each from parsed arguments through a checked plan to a run.
//!
//! Results are plain data from the other modules of the library; what is printed here is a view of them. Exit status: 0 done, 1 by
//! `--exit-code`, 2 it could not be done, with one message on standard error, 130 interrupted by Ctrl-C.

mod about;
mod ask;
mod command_line;
pub mod compare;
pub mod completions;
mod console;
pub mod diagnose;
#[cfg(feature = "virtual-plant")]
mod draw;
mod ending;
mod error;
pub mod export;
pub mod fit;
#[cfg(feature = "fleet")]
pub mod fleet;
#[cfg(feature = "virtual-plant")]
mod hall;
pub mod import;
pub mod init;
mod input;
pub mod inspect;
mod interrupt;
pub mod man;
#[cfg(feature = "virtual-plant")]
pub mod paper;
pub mod plan;
mod plant;
pub mod simulate;
mod simulated;
pub mod statics;
pub mod studio;
mod target;
#[cfg(feature = "virtual-plant")]
pub mod testbed;
#[cfg(feature = "fleet")]
pub mod trend;
pub mod watch;

use std::io::Write;
use std::process::ExitCode;

use recording::files::source_error::printable;

pub use command_line::CommandLine;
pub use console::{Console, Progress, Tone, Volume};
pub use error::CliError;
pub use input::{ArithmeticArgument, MachineArguments, ModelArguments, TickArgument};
pub use interrupt::{INTERRUPTED, stop_cleanly};

/// Simulates and compares valve-controlled hydraulic drives against recordings.
#[derive(Debug, clap::Parser)]
#[command(name = "host-sim", version, max_term_width = 100, arg_required_else_help = true, disable_help_flag = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Print the result alone: no notes, no progress
    #[arg(long, short, global = true, display_order = 900)]
    quiet: bool,
    /// Also say what each stage found and how long it took
    #[arg(long, short, global = true, conflicts_with = "quiet", display_order = 901)]
    verbose: bool,
    // One screen: what is longer stands in the manual page.
    /// Print this help; `host-sim man COMMAND` has more
    #[arg(long, short, global = true, action = clap::ArgAction::HelpShort, display_order = 902)]
    help: Option<bool>,
}

impl Cli {
    /// How much is to be said beside the result.
    #[must_use]
    pub fn volume(&self) -> Volume {
        match (self.quiet, self.verbose) {
            (true, _) => Volume::Quiet,
            (false, true) => Volume::Verbose,
            (false, false) => Volume::Usual,
        }
    }
}

/// One command and its arguments.
#[derive(Debug, clap::Subcommand)]
pub enum Command {
    /// Write a machine file from data sheet and drawing.
    Init(init::Arguments),
    /// Say what recordings hold, which parts of a drive they can test, and what is missing to test the others.
    Inspect(inspect::Arguments),
    /// Simulate a recording or an input signal and write the signals.
    Simulate(simulate::Arguments),
    /// Compare recordings with the model, end to end and link by link.
    Compare(compare::Arguments),
    /// Refit a drive's base parameters to recordings.
    Fit(fit::Arguments),
    /// Say in milliseconds whether a drive still follows its model as it did while it was healthy.
    Watch(watch::Arguments),
    /// Judge the recordings of many drives, night by night, into a table: which has changed, in what, how much.
    #[cfg(feature = "fleet")]
    Fleet(fleet::Arguments),
    /// Say from a table of nights what wears: since when, how fast, and when it reaches its limit.
    #[cfg(feature = "fleet")]
    Trend(trend::Arguments),
    /// Find what a model lacks: where, which physics, and how much better it fits with it.
    Diagnose(diagnose::Arguments),
    /// Read a valve's static characteristic off a sweep, a table of means or runs, without a clock.
    Statics(statics::Arguments),
    /// Say before recording which effects could be seen and told apart, and lay out the excitation that separates most.
    Plan(plan::Arguments),
    /// Repeat the paper's experiment on a virtual test bed and print its tables.
    Paper(plant::PaperArguments),
    /// Make synthetic recordings of a drive, with effects that its machine file knows nothing of.
    Testbed(plant::TestbedArguments),
    /// Write a drive, effects included, as constants for firmware (Rust, C99) or as an FMU for other tools.
    Export(export::Arguments),
    /// Turn what the firmware's recorder streamed out into a recording.
    Import(import::Arguments),
    /// Write a page that does all this in a browser, for a computer on which nothing may be installed.
    Studio(studio::Arguments),
    /// Print what a shell needs to complete commands and options.
    Completions(completions::Arguments),
    /// Print or write manual pages.
    Man(man::Arguments),
}

/// How a command ended that did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done: exit status 0.
    Done,
    /// Done, but `--exit-code` was given and something is out of tolerance: exit status 1.
    OutOfTolerance,
}

/// Runs a command.
pub fn run(command: &Command, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    match command {
        Command::Init(arguments) => init::run(arguments, console),
        Command::Inspect(arguments) => inspect::run(arguments, console),
        Command::Simulate(arguments) => simulate::run(arguments, console),
        Command::Compare(arguments) => compare::run(arguments, console),
        Command::Fit(arguments) => fit::run(arguments, console),
        Command::Watch(arguments) => watch::run(arguments, console),
        #[cfg(feature = "fleet")]
        Command::Fleet(arguments) => fleet::run(arguments, console),
        #[cfg(feature = "fleet")]
        Command::Trend(arguments) => trend::run(arguments, console),
        Command::Diagnose(arguments) => diagnose::run(arguments, console),
        Command::Statics(arguments) => statics::run(arguments, console),
        Command::Plan(arguments) => plan::run(arguments, console),
        Command::Paper(arguments) => plant::paper(arguments, console),
        Command::Testbed(arguments) => plant::testbed(arguments, console),
        Command::Export(arguments) => export::run(arguments, console),
        Command::Import(arguments) => import::run(arguments, console),
        Command::Studio(arguments) => studio::run(arguments, console),
        Command::Completions(arguments) => completions::run(arguments, console),
        Command::Man(arguments) => man::run(arguments, console),
    }
}

/// The exit status of a result; an error is written to `errors`, with the part of the command line that it refers to.
///
/// A reader that has closed the other end of standard output has seen what it wanted: that is no error.
pub fn finish(result: Result<Outcome, CliError>, line: &CommandLine, errors: &mut dyn Write) -> ExitCode {
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::OutOfTolerance) => ExitCode::from(1),
        Err(error) if error.is_closed_pipe() => ExitCode::SUCCESS,
        Err(CliError::Interrupted) => ExitCode::from(INTERRUPTED),
        Err(error) => {
            // If standard error is closed too, the message cannot be shown anywhere.
            let _ = writeln!(errors, "{}", printable(&error.render_on(line)));
            ExitCode::from(2)
        }
    }
}

/// The exit status of arguments that make no command; the reason is written to `errors`, in this form or as clap writes it.
pub fn refuse(error: &clap::Error, line: &CommandLine, errors: &mut dyn Write) -> ExitCode {
    match line.explained(error) {
        Some(message) => {
            // As above.
            let _ = writeln!(errors, "{message}");
            ExitCode::from(2)
        }
        None => error.exit(),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent_and_every_command_shows_an_example() {
        let mut cli = super::Cli::command();
        cli.build();
        cli.clone().debug_assert();
        shows_examples(&mut cli);
    }

    /// Commands of commands too.
    fn shows_examples(parent: &mut clap::Command) {
        for command in parent.get_subcommands_mut().filter(|command| command.get_name() != "help") {
            let help = command.render_long_help().to_string();
            assert!(help.contains("Example") && help.contains("\n  "), "{help}");
            shows_examples(command);
        }
    }
}
