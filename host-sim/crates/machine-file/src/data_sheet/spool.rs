//! The spool as a second-order system, from what a data sheet says of its speed.
//!
//! A data sheet gives one of: the time to 90 % of a small step, the frequency at which the spool is 90° late, or natural frequency and damping. A
//! second-order system is 90° late at its natural frequency, whatever its damping; a dead time of a twentieth of the response shifts this by less
//! than the data sheet is exact.

use recording::display_unit::significant;

use super::derive::Origin;
use super::item::Item;
use super::quantity::Quantity;

/// Damping ratio, where none is given.
pub(super) const DAMPING: f64 = 0.8;
/// Its standard deviation, as a share of it: by its logarithm, half to twice as much.
pub(super) const DAMPING_WITHIN: f64 = 0.6;
/// Dead time as a share of the time to 90 %.
pub(super) const DEAD_TIME: f64 = 0.05;

/// What is known of a spool's speed.
pub(super) struct Spool {
    /// Natural frequency, Hz.
    pub(super) hertz: f64,
    pub(super) origin: Origin,
    /// How it was found.
    pub(super) why: String,
    /// Standard deviation of the natural frequency, as a share of it.
    pub(super) within: f64,
    /// The reason for this size.
    pub(super) known: &'static str,
    /// Time to 90 % of a small step, s.
    pub(super) response_s: f64,
}

impl Spool {
    /// From the answers; `None` where none says how fast the spool is.
    pub(super) fn of<'a>(given: impl Fn(Item) -> Option<&'a Quantity>) -> Option<Self> {
        let damping = given(Item::ValveDamping).map_or(DAMPING, |damping| damping.si);
        let per_response = turn_to_90_percent(damping) / std::f64::consts::TAU;
        let of_frequency = |hertz: f64| per_response / hertz / (1.0 - DEAD_TIME);
        if let Some(natural) = given(Item::NaturalFrequency) {
            let (hertz, known) = (natural.si, "given: within 10 %");
            let (origin, why) = (Origin::Given, natural.to_string());
            return Some(Self { hertz, origin, why, within: 0.1, known, response_s: of_frequency(hertz) });
        }
        if let Some(late) = given(Item::ValveFrequency) {
            let (hertz, known) = (late.si, "given by another number: within 20 %");
            let (origin, why) = (Origin::Derived, format!("90° late at {late}"));
            return Some(Self { hertz, origin, why, within: 0.2, known, response_s: of_frequency(hertz) });
        }
        let response = given(Item::ValveResponse)?;
        let hertz = per_response / (response.si * (1.0 - DEAD_TIME));
        let turns = significant(per_response, 3);
        let why = format!("f0 = {turns}/(t_90 − T_t), from {response} to 90 % at a damping of {damping}");
        let known = "derived from one number: within 30 %";
        Some(Self { hertz, origin: Origin::Derived, why, within: 0.3, known, response_s: response.si })
    }
}

/// ω·t at which a second-order system of this damping ratio first reaches 90 % of a step.
fn turn_to_90_percent(damping: f64) -> f64 {
    let (mut low, mut high) = (0.0, 10.0 + 10.0 * damping);
    // Halved until it is exact; the response rises up to the first crossing.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if reaches_90_percent(damping, middle) { high = middle } else { low = middle }
    }
    high
}

/// Whether the step response is at 90 % or beyond its first maximum.
fn reaches_90_percent(damping: f64, turn: f64) -> bool {
    let apart = damping * damping - 1.0;
    if apart < 0.0 {
        let swing = (-apart).sqrt();
        let phase = swing * turn;
        if phase >= std::f64::consts::PI {
            return true;
        }
        return libm::exp(-damping * turn) * (libm::cos(phase) + damping / swing * libm::sin(phase)) < 0.1;
    }
    if apart < 1e-12 {
        return libm::exp(-turn) * (1.0 + turn) < 0.1;
    }
    let root = apart.sqrt();
    let (slow, fast) = (damping - root, damping + root);
    (fast * libm::exp(-slow * turn) - slow * libm::exp(-fast * turn)) / (2.0 * root) < 0.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_response_is_at_90_percent_where_the_textbook_says() {
        // Two equal lags: 1 − (1 + t)·e^−t = 0.9 at 3.890.
        assert!((turn_to_90_percent(1.0) - 3.890).abs() < 1e-3);
        assert!((turn_to_90_percent(1.0 + 1e-9) - turn_to_90_percent(1.0 - 1e-9)).abs() < 1e-6);
        // Of a damping of 0.5 the response is cos and sin of 0.866·t.
        let turn = turn_to_90_percent(0.5);
        let at = 1.0 - (-0.5 * turn).exp() * ((0.866_025 * turn).cos() + 0.577_350 * (0.866_025 * turn).sin());
        assert!((at - 0.9).abs() < 1e-5 && turn < 2.5, "{turn}");
    }

    #[test]
    fn each_way_to_say_how_fast_a_spool_is_gives_the_same_spool() {
        let of = |item: Item, text: &str| {
            let quantity = item.parse(text).unwrap();
            Spool::of(|asked| (asked == item).then_some(&quantity)).unwrap()
        };
        let natural = of(Item::NaturalFrequency, "40Hz");
        let late = of(Item::ValveFrequency, "40Hz");
        let response = of(Item::ValveResponse, &format!("{}s", natural.response_s));
        assert!((late.response_s / natural.response_s - 1.0).abs() < 1e-12 && late.within > natural.within);
        assert!((response.hertz / 40.0 - 1.0).abs() < 1e-9 && response.within > late.within);
    }
}
