//! Why recordings and a machine file hardly belong together.

use diagnosis::agreement::{Change, Doubt, Trial};
use recording::Signal;
use recording::display_unit::significant;

use super::far_value::moved;

/// Why recordings and a machine file hardly belong together, and with which change they would.
#[must_use]
pub fn doubt(doubt: &Doubt) -> String {
    let of = if doubt.in_all { String::new() } else { format!("{}: ", doubt.recordings.join(", ")) };
    let claim = |change: &Change| claim(*change, &doubt.signals);
    let seems = joined(doubt.changed.changes.iter().map(claim));
    let changed = joined(doubt.changed.changes.iter().map(|change| remedy(*change)));
    let signals = joined(doubt.signals.iter().map(|signal| signal.name().to_owned()));
    // Worse than the mean is no fit, however much worse.
    let percent = |trial: &Trial| significant(trial.fit_percent.max(0.0), 3);
    let only_with = match doubt.as_recorded.far.first() {
        Some(far) if far.is_impossible => format!(", and only with {}", moved(far)),
        _ => String::new(),
    };
    let others = doubt
        .others
        .iter()
        .map(|other| format!("; or {}: {} %", joined(other.changes.iter().map(claim)), percent(other)));
    format!(
        "{of}{seems}: {changed}, the fit of {signals} is {} % (as recorded {} %{only_with}){}",
        percent(&doubt.changed),
        percent(&doubt.as_recorded),
        others.collect::<String>()
    )
}

/// The same of recordings that are worked on as they are all the same.
#[must_use]
pub fn mend_first(doubt: &Doubt) -> String {
    format!("{}; mend this first: what follows is of the recordings as they are", self::doubt(doubt))
}

/// What a change says of the recordings, where these signals raise the doubt.
fn claim(change: Change, signals: &[Signal]) -> String {
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
            let chambers = [Signal::PressureA, Signal::PressureB];
            let doubtful: Vec<Signal> = chambers.into_iter().filter(|chamber| signals.contains(chamber)).collect();
            let (who, they) = match doubtful[..] {
                _ if !chambers.contains(&signal) => (format!("{signal} seems"), "it"),
                [one] => (format!("{one} seems"), "it"),
                _ => ("both pressures seem".to_owned(), "they"),
            };
            let unit = misread(factor).filter(|_| signal.is_pressure()).unwrap_or_default();
            format!("{who} to be {} what {they} should be{unit}", times(1.0 / factor))
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

/// `10 times`, `a tenth of`.
fn times(factor: f64) -> String {
    share(factor).map_or_else(|| format!("{} times", significant(factor, 2)), |share| format!("{share} of"))
}

/// The word for a decimal fraction; a small fraction as `1/60000`.
fn share(factor: f64) -> Option<String> {
    let words = [(0.1, "a tenth"), (0.01, "a hundredth"), (0.001, "a thousandth")];
    let word =
        words.into_iter().find(|(share, _)| (factor / share - 1.0).abs() < 1e-9).map(|(_, word)| word.to_owned());
    word.or_else(|| (factor < 1e-3).then(|| format!("1/{}", significant(1.0 / factor, 2))))
}

/// The units that a pressure's factor is between: of what was written, and of what it was taken for.
fn misread(factor: f64) -> Option<&'static str> {
    let units = [(1e5, ": bar for Pa"), (1e-5, ": Pa for bar"), (1e6, ": MPa for Pa"), (1e-6, ": Pa for MPa")];
    units.into_iter().find(|(known, _)| (factor / known - 1.0).abs() < 1e-9).map(|(_, units)| units)
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
        let both = [Signal::PressureA, Signal::PressureB];
        let said = |change| (claim(change, &both), remedy(change));
        let position = said(Change::Scaled(Signal::Position, 10.0));
        assert_eq!(position.0, "position seems to be a tenth of what it should be");
        assert_eq!(position.1, "taken 10 times as large");
        let pressures = said(Change::Scaled(Signal::PressureA, 1e-3));
        assert_eq!(pressures.0, "both pressures seem to be 1000 times what they should be");
        assert_eq!(pressures.1, "taken as a thousandth of that");
        assert_eq!(said(Change::PressuresExchanged).1, "exchanged back");
        let bar = claim(Change::Scaled(Signal::PressureA, 1e5), &[Signal::Position, Signal::PressureB]);
        assert_eq!(bar, "pressure_b seems to be 1/100000 of what it should be: bar for Pa");
        assert_eq!(remedy(Change::Scaled(Signal::PressureA, 1e-5)), "taken as 1/100000 of that");
    }
}
