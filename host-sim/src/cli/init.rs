//! `host-sim init`: a machine file from data sheet and drawing.

use std::ffi::OsString;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};

use clap::{Arg, ArgMatches, Command};

use experiment::inspect::load_doubt;
use machine_file::data_sheet::{self, Answers, Derived, Edges, Item, Need, Origin, Sigma};
use report::wording;
use serde_json::{Value, json};

use super::Outcome;
use super::ask::ask;
use super::console::Console;
use super::ending::{DOCUMENT, MACHINE};
use super::error::CliError;
use super::target::{check_targets, tell, write};

/// Arguments of `init`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Examples:
  host-sim init
  host-sim init --out press.toml --bore 63mm --rod 40mm --stroke 300mm --mass 18kg --supply 70bar \\
      --rated-flow 5l/min --rated-drop 5bar --rated-signal 10V --valve-response 96ms --overlap 17.7%
  host-sim init --out press.toml --bore 63mm --rod 40mm --stroke 300mm --mass 40kg --supply 150bar \\
      --pump-displacement 16cm3/rev

What a data sheet may give besides, explained by `host-sim man init`: --valve-damping --overlap \
--spool-at-rated --valve-stroke-time --flow-limit --hose-length --hose-diameter --dead-volume \
--bulk-modulus --friction --load

On a terminal, what no flag gives is asked for; elsewhere a flag that is required and not given is an \
error, which names all of them. Every value of the file says whether it was given, derived by which \
formula, or assumed and why; [fit.sigma] is narrow for what was given and wide for what was assumed, so \
that `fit` may move it. A mass that a recorded force moves has no data sheet of valve or pump, and a \
machine file of a few lines: docs/faq.md has one.")]
pub struct Arguments {
    #[command(flatten)]
    answers: AnswerArguments,
    /// Over what the rated pressure drop stands
    #[arg(long, value_enum, default_value_t, value_name = "edge|both", hide_possible_values = true)]
    rated_drop_over: EdgesArgument,
    /// What the drive is called; without it, as the file
    #[arg(long, value_name = "name")]
    name: Option<String>,
    /// Machine file to write
    #[arg(long, value_name = "M.toml", default_value = "machine.toml")]
    out: PathBuf,
    /// Write over a file that is there
    #[arg(long)]
    force: bool,
    /// Write every value and its source for programs; `-` prints it
    #[arg(long, value_name = "I.json")]
    json: Option<PathBuf>,
}

/// Over what the rated pressure drop of a valve stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum EdgesArgument {
    /// One edge, supply to port or port to tank
    #[default]
    Edge,
    /// Both edges in series: half of it is over each
    Both,
}

impl From<EdgesArgument> for Edges {
    fn from(argument: EdgesArgument) -> Self {
        match argument {
            EdgesArgument::Edge => Edges::Edge,
            EdgesArgument::Both => Edges::Both,
        }
    }
}

/// Answers given as flags.
#[derive(Clone, Debug, Default)]
struct AnswerArguments(Answers);

/// The flags beside this one.
fn others(flags: &[&str], flag: &str) -> String {
    flags.iter().filter(|other| **other != flag).map(|other| format!("--{other}")).collect::<Vec<_>>().join(" or ")
}

/// The flags come from the table of items.
impl clap::Args for AnswerArguments {
    fn augment_args(command: Command) -> Command {
        Item::ALL.iter().fold(command, |command, &item| {
            let question = item.question();
            let (heading, need) = match question.need {
                Need::Always => ("Cylinder, load and supply (required)", "[required]".to_owned()),
                Need::OfValve => ("Valve (required)", "[required for a valve]".to_owned()),
                Need::OneOf(flags) => {
                    let others = others(flags, question.flag);
                    ("Speed of the valve (one is required)", format!("[this or {others} is required for a valve]"))
                }
                Need::MakesPump => ("Pump in place of a valve", "[required for a pump]".to_owned()),
                Need::May(otherwise) | Need::MayOfValve(otherwise) => {
                    ("If known", format!("[without it: {otherwise}]"))
                }
            };
            let parse = move |text: &str| item.parse(text);
            let flag = Arg::new(question.flag).long(question.flag).value_name(question.example).help_heading(heading);
            // One screen: what is longer, and what may be left away, stands in the manual page.
            let short = question.what.split(';').next().unwrap_or_default();
            let flag = flag.help(short).long_help(format!("{} {need}", question.what));
            let flag = flag.hide_short_help(matches!(question.need, Need::May(_) | Need::MayOfValve(_)));
            command.arg(flag.allow_hyphen_values(item == Item::Load).value_parser(parse))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl clap::FromArgMatches for AnswerArguments {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut answers = Self::default();
        answers.update_from_arg_matches(matches)?;
        Ok(answers)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        for &item in Item::ALL {
            if let Some(quantity) = matches.get_one::<data_sheet::Quantity>(item.question().flag) {
                self.0.insert(item, quantity.clone());
            }
        }
        Ok(())
    }
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let target = &arguments.out;
    if target.exists() && !arguments.force {
        return Err(CliError::IsThere { path: target.clone() });
    }
    let document = ("--json", arguments.json.as_deref(), DOCUMENT);
    check_targets(&[("--out", Some(target), MACHINE), document], &[])?;
    let mut answers = arguments.answers.0.clone();
    if !answers.missing().is_empty() && io::stdin().is_terminal() && io::stderr().is_terminal() {
        ask(&mut answers)?;
    }
    let made = data_sheet::derived(&answers, arguments.rated_drop_over.into())?;
    let name = arguments.name.clone().unwrap_or_else(|| stem(target));
    // A file that no command would take is not written.
    let shown = target.display().to_string();
    let text = data_sheet::checked_toml(&shown, &name, &made)?;
    if let Some(doubt) = load_doubt(&machine_file::read_text(&shown, &text)?.machine) {
        console.note(wording::unit_doubt(&doubt));
    }
    write(target, text)?;

    tell(arguments.json.as_deref(), || document_of(&name, target, &made), console)?;
    console.print(target.display())?;
    let assumed: Vec<&str> =
        made.entries.iter().filter(|entry| entry.origin == Origin::Assumed).map(|entry| entry.key).collect();
    if !assumed.is_empty() {
        console.print(format_args!("assumed    {}", assumed.join(", ")))?;
    }
    // In a form that can be pasted into a shell.
    let shown = if shown.contains(char::is_whitespace) { format!("\"{shown}\"") } else { shown };
    console.print(format_args!(
        "next       host-sim inspect run.csv --machine {shown}\n\
         \x20          host-sim compare run.csv --machine {shown}\n\
         \x20          host-sim fit run.csv --machine {shown} --save-machine fitted.toml"
    ))?;
    Ok(Outcome::Done)
}

/// Every value that was written, for programs.
fn document_of(name: &str, target: &Path, made: &Derived) -> Value {
    let values = made.entries.iter().map(|entry| {
        let key = if entry.table.is_empty() { entry.key.to_owned() } else { format!("{}.{}", entry.table, entry.key) };
        json!({ "key": key, "values": entry.values, "origin": entry.origin.name(), "why": entry.why })
    });
    let sizes = |all: &[Sigma]| -> Vec<Value> {
        all.iter().map(|one| json!({ "key": one.key, "value": one.value, "why": one.why })).collect()
    };
    json!({
        "schema": "host-sim/init/1",
        "machine": name,
        "out": target.display().to_string(),
        "values": values.collect::<Vec<_>>(),
        "standard_deviations": sizes(&made.sigma),
        "tolerances": sizes(&made.tolerance),
    })
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| OsString::from("drive"), ToOwned::to_owned).to_string_lossy().into_owned()
}
