//! `host-sim testbed draw`: concealed cases at random, to try a diagnosis on.

use std::path::PathBuf;

use rayon::prelude::*;
use serde_json::json;

use virtual_plant::concealed::{self, Concealed, Lot};

use super::Outcome;
use super::console::Console;
use super::ending::DOCUMENT;
use super::error::CliError;
use super::target::{check_folder, check_targets, make_folder, tell, write_together};
use super::testbed::refuse_others;

/// Arguments of `testbed draw`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = "Example:
  host-sim testbed draw --seed 7 --count 20 --effects mixed --out cases

Every case is a folder with machine.toml (nominal values, off the truth by what [fit.sigma] says), train-1.csv … and \
holdout-1.csv …; truth.json says what each conceals. The same arguments make the same files, and a case is the same \
whatever the count.")]
pub struct Arguments {
    /// Seed of everything
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// How many cases
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=1000))]
    count: u64,
    /// What the cases conceal
    #[arg(long, value_enum, default_value = "mixed")]
    effects: EffectsArgument,
    /// Rough nominal values, fewer and noisier channels
    #[arg(long)]
    hard: bool,
    /// Only effects of this name; may be repeated
    #[arg(long, value_name = "name")]
    only: Vec<String>,
    /// Record the oil's temperature, which rises from recording to recording
    #[arg(long)]
    thermometer: bool,
    /// Folder to write to; made where it is not there
    #[arg(long, value_name = "folder")]
    out: PathBuf,
    /// Write the names of the cases for programs; `-` prints it in place of the text
    #[arg(long, value_name = "D.json")]
    json: Option<PathBuf>,
}

/// What `--effects` can be.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum EffectsArgument {
    /// Nothing
    None,
    /// One effect each
    Single,
    /// Two effects each
    Pair,
    /// Something outside the vocabulary
    Outside,
    /// Some of all, most of them single
    Mixed,
}

impl From<EffectsArgument> for Concealed {
    fn from(argument: EffectsArgument) -> Self {
        match argument {
            EffectsArgument::None => Self::None,
            EffectsArgument::Single => Self::Single,
            EffectsArgument::Pair => Self::Pair,
            EffectsArgument::Outside => Self::Outside,
            EffectsArgument::Mixed => Self::Mixed,
        }
    }
}

pub(crate) fn run(arguments: &Arguments, console: &mut Console<'_>) -> Result<Outcome, CliError> {
    let known = || concealed::VOCABULARY.iter().chain(&concealed::ON_REQUEST).chain(&concealed::OUTSIDE);
    if let Some(found) = arguments.only.iter().find(|name| known().all(|known| known != name)) {
        let known = known().copied().collect::<Vec<_>>().join(", ");
        return Err(CliError::EffectName { found: found.clone(), known });
    }
    check_folder(&arguments.out)?;
    check_targets(&[("--json", arguments.json.as_deref(), DOCUMENT)], &[])?;
    let lot = Lot {
        seed: arguments.seed,
        concealed: arguments.effects.into(),
        hard: arguments.hard,
        only: arguments.only.clone(),
        thermometer: arguments.thermometer,
    };
    let bar = console.progress(usize::try_from(arguments.count).unwrap_or(usize::MAX), "drawing cases");
    let cases = (0..arguments.count)
        .into_par_iter()
        .map(|index| {
            let drawn = concealed::draw(&lot, index)
                .map_err(|cause| CliError::Plant { excitation: format!("case {index}"), cause })?;
            bar.inc(1);
            let Some(drawn) = drawn else { return Ok(None) };
            let folder = arguments.out.join(&drawn.id);
            let machine = folder.join("machine.toml");
            let mut files: Vec<(PathBuf, String)> =
                drawn.recordings.iter().map(|(name, recording)| (folder.join(name), recording.to_csv())).collect();
            let toml = drawn.file.to_text(&machine.display().to_string())?;
            files.push((machine, toml));
            Ok(Some((drawn.id, drawn.truth, files)))
        })
        .collect::<Result<Vec<_>, CliError>>()?;
    bar.finish_and_clear();

    let (mut folders, mut truths, mut all) = (Vec::new(), Vec::new(), Vec::new());
    for (id, truth, files) in cases.into_iter().flatten() {
        let folder = arguments.out.join(&id);
        refuse_others(&folder, |name| files.iter().any(|(own, _)| own.ends_with(name)))?;
        folders.push(folder);
        truths.push((id, truth));
        all.extend(files);
    }
    // The truth file belongs to these cases: all files are on disk before the first takes its name.
    all.push((arguments.out.join("truth.json"), concealed::to_json(&truths)));
    make_folder(&arguments.out)?;
    folders.iter().try_for_each(|folder| make_folder(folder))?;
    write_together(&all)?;
    let document = || {
        let case =
            |(id, _): &(String, _)| json!({ "case": id, "folder": arguments.out.join(id).display().to_string() });
        json!({
            "schema": "host-sim/draw/1",
            "seed": arguments.seed,
            "truth": arguments.out.join("truth.json").display().to_string(),
            "cases": truths.iter().map(case).collect::<Vec<_>>(),
        })
    };
    tell(arguments.json.as_deref(), document, console)?;
    folders.iter().try_for_each(|folder| console.print(folder.display()))?;
    Ok(Outcome::Done)
}
