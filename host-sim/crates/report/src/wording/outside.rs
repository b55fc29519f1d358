//! A cause outside the drive, in words.

use diagnosis::outside::{Cause, Outside, Push};
use recording::display_unit::significant;

/// What acts from outside, without an article where it is several.
#[must_use]
pub fn outside_cause(cause: &Cause) -> String {
    match cause {
        Cause::Load(loads) => {
            let each = |(recording, force_n): &(String, f64)| format!("{} N in {recording}", signed(*force_n));
            format!("another load in each recording (besides the machine file's {})", joined(loads, each))
        }
        Cause::Push(pushes) => {
            let each = |push: &Push| {
                format!(
                    "{} N on average from {} to {} s of {}",
                    signed(push.mean_n),
                    significant(push.from_s, 3),
                    significant(push.to_s, 3),
                    push.recording
                )
            };
            let times =
                if pushes.len() == 1 { "a push that happened once" } else { "pushes, at most one in a recording" };
            format!("{times} ({})", joined(pushes, each))
        }
        Cause::Periodic { hz, amplitude_n } => {
            let each =
                |(recording, amplitude_n): &(String, f64)| format!("{} N in {recording}", significant(*amplitude_n, 2));
            format!("a periodic force at {} Hz ({})", significant(*hz, 3), joined(amplitude_n, each))
        }
        Cause::Structure { hz, damping, mass_kg } => format!(
            "a structure that rings on the rod at {} Hz ({} kg, damping {})",
            significant(*hz, 3),
            significant(*mass_kg, 2),
            significant(*damping, 2)
        ),
    }
}

/// Its kind, for a headline.
#[must_use]
pub fn outside_kind(cause: &Cause) -> String {
    match cause {
        Cause::Load(_) => "another load in each recording".to_owned(),
        Cause::Push(pushes) if pushes.len() == 1 => "a push that happened once".to_owned(),
        Cause::Push(_) => "pushes in some of the recordings".to_owned(),
        Cause::Periodic { hz, .. } => format!("a periodic force at {} Hz", significant(*hz, 3)),
        Cause::Structure { hz, .. } => format!("a structure that rings on the rod at {} Hz", significant(*hz, 3)),
    }
}

/// How much of the misfit it explains.
#[must_use]
pub fn outside_explains(outside: &Outside) -> String {
    let percent = |share: f64| significant(100.0 * share, 2);
    let in_training = format!("{} % of the misfit above the noise", percent(outside.explains));
    match outside.explains_held_out {
        Some(share) => format!("{in_training}, {} % in held-out recordings", percent(share)),
        None if matches!(outside.cause, Cause::Push(_)) => {
            format!("{in_training}; it acted in training recordings alone, so that no other recording can confirm it")
        }
        None => in_training,
    }
}

fn signed(force_n: f64) -> String {
    format!("{}{}", if force_n < 0.0 { "−" } else { "+" }, significant(force_n.abs(), 2))
}

fn joined<T>(all: &[T], each: impl Fn(&T) -> String) -> String {
    all.iter().map(each).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_push_is_told_with_its_time_and_its_sign_and_that_nothing_confirms_it() {
        let push =
            Push { recording: "train-2".to_owned(), from_s: 1.204, to_s: 1.55, mean_n: -3120.0, impulse_n_s: -700.0 };
        let outside = Outside { cause: Cause::Push(vec![push]), explains: 0.923, explains_held_out: None };
        assert_eq!(
            outside_cause(&outside.cause),
            "a push that happened once (−3120 N on average from 1.20 to 1.55 s of train-2)"
        );
        assert_eq!(outside_kind(&outside.cause), "a push that happened once");
        assert!(outside_explains(&outside).starts_with("92 % of the misfit above the noise; it acted in training"));
        let ringing = Outside {
            cause: Cause::Structure { hz: 14.96, damping: 0.031, mass_kg: 61.0 },
            explains: 0.8,
            explains_held_out: Some(0.75),
        };
        assert!(outside_cause(&ringing.cause).contains("at 15.0 Hz (61 kg, damping 0.031)"));
        assert!(outside_explains(&ringing).ends_with("75 % in held-out recordings"));
    }
}
