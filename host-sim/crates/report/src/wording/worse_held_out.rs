//! A fit that is worse than the machine file, in a sentence.

use diagnosis::{Refit, worse_held_out};
use recording::display_unit::percent;

/// That the fitted values are worse than the machine file's on the held-out recordings; `None` where they are not, or nothing was held out.
#[must_use]
pub fn fit_is_worse(refit: &Refit) -> Option<String> {
    let falls = worse_held_out(&refit.shown).filter(|falls| !falls.is_empty())?;
    // What fell by less than is told has not fallen.
    let told = falls.iter().map(|fall| (fall.signal, percent(fall.before), percent(fall.after)));
    let told = told.filter(|(_, before, after)| before != after);
    let each: Vec<String> = told.map(|(signal, before, after)| format!("{signal} {before} → {after} %")).collect();
    Some(format!(
        "The fit is worse than the machine file on recordings it has not seen: {} (NRMSE fit). Do not use it; fit to recordings of more kinds of \
         motion, or let fewer values move in [fit.sigma].",
        each.join(", ")
    ))
}
