//! Why recordings and a machine file hardly belong together.

use diagnosis::agreement::{Change, Doubt, Trial};
use recording::Signal;
use recording::display_unit::significant;

use super::far_value::moved;

/// Why recordings and a machine file hardly belong together, and with which change they would.
#[must_use]
pub fn doubt(doubt: &Doubt) -> String {
    let of = if doubt.in_all { String::new() } else { format!("{}: ", doubt.recordings.join(", ")) };
    let [seems, changed] =
        [claim, remedy].map(|words| joined(doubt.changed.changes.iter().map(|change| words(*change))));
    let signals = joined(doubt.signals.iter().map(|signal| signal.name().to_owned()));
    // Worse than the mean is no fit, however much worse.
    let percent = |trial: &Trial| significant(trial.fit_percent.max(0.0), 3);
    let only_with = match doubt.as_recorded.far.first() {
        Some(far) if far.is_impossible => format!(", and only with {}", moved(far)),
        _ => String::new(),
    };
    let others = doubt.others.iter().map(|other| {
        format!("; or {}: {} %", joined(other.changes.iter().map(|change| claim(*change))), percent(other))
    });
    format!(
        "{of}{seems}: {changed}, the fit of {signals} is {} % (as recorded {} %{only_with}){}",
        percent(&doubt.changed),
        percent(&doubt.as_recorded),
        others.collect::<String>()
    )
}

/// What a change says of the recordings.
fn claim(change: Change) -> String {
    match change {
        Change::Reversed(signal) => format!("{signal} seems to run the other way"),
        Change::PortsExchanged => "ports A and B of the valve seem to be exchanged".to_owned(),
        Change::PressuresExchanged => "the pressures of A and B seem to be exchanged".to_owned(),
        Change::Moved(signal, _) => format!("{signal} seems to count from another place: it lies beyond the stroke"),
        Change::Earlier(signal, by_s) => {
            format!(
                "{signal} seems to be stamped {} ms too late: what it moves, moves before it",
                significant(1e3 * by_s, 2)
            )
        }
        Change::Cylinder { bore_mm, rod_mm } => {
            format!("the areas seem to be those of another cylinder, {bore_mm}/{rod_mm} mm")
        }
        Change::Scaled(signal, factor) => {
            let signals = match signal {
                Signal::PressureA | Signal::PressureB => "both pressures seem".to_owned(),
                _ => format!("{signal} seems"),
            };
            let were = if signals.starts_with("both") { "they were" } else { "it was" };
            match share(1.0 / factor) {
                Some(share) => format!("{signals} to be {share} of what {were}"),
                None => format!("{signals} to be {} times what {were}", significant(1.0 / factor, 2)),
            }
        }
    }
}

/// What was done to try it.
fn remedy(change: Change) -> String {
    match change {
        Change::Reversed(_) => "turned round".to_owned(),
        Change::Moved(signal, by) => {
            format!("moved by {} to the middle of where it can be", recording::display_unit::difference(signal, by))
        }
        Change::Earlier(..) => "taken so much earlier".to_owned(),
        Change::PortsExchanged | Change::PressuresExchanged => "exchanged back".to_owned(),
        Change::Cylinder { .. } => "with these areas".to_owned(),
        Change::Scaled(_, factor) => match share(factor) {
            Some(share) => format!("taken as {share} of that"),
            None => format!("taken {} times as large", significant(factor, 2)),
        },
    }
}

/// The word for a decimal fraction.
fn share(factor: f64) -> Option<&'static str> {
    let words = [(0.1, "a tenth"), (0.01, "a hundredth"), (0.001, "a thousandth")];
    words.into_iter().find(|(share, _)| (factor / share - 1.0).abs() < 1e-9).map(|(_, word)| word)
}

/// `a, b and c`.
fn joined(parts: impl Iterator<Item = String>) -> String {
    let parts: Vec<String> = parts.collect();
    match parts.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} and {last}", others.join(", ")),
        None => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_doubt_about_recordings_says_what_would_remove_it_and_how_much_better_they_fit() {
        let said = |change| (claim(change), remedy(change));
        let position = said(Change::Scaled(Signal::Position, 10.0));
        assert_eq!(position.0, "position seems to be a tenth of what it was");
        assert_eq!(position.1, "taken 10 times as large");
        let pressures = said(Change::Scaled(Signal::PressureA, 1e-3));
        assert_eq!(pressures.0, "both pressures seem to be 1000 times what they were");
        assert_eq!(pressures.1, "taken as a thousandth of that");
        assert_eq!(said(Change::PressuresExchanged).1, "exchanged back");
    }
}
