//! How a free parameter moves in a fit, and its prior.

use model_core::machine::{Parameter, Tick};
use simulation::DELAY_LINE;

/// How a free parameter moves; its own coordinate has a unit normal prior in each case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Freedom {
    /// Around a nominal value, with a Gaussian prior of this standard deviation, in the parameter's unit.
    Around {
        /// Nominal value.
        nominal: f64,
        /// Its standard deviation.
        sigma: f64,
    },
    /// Around a nominal value that is known only roughly and above a least one: what it is above that moves in its logarithm, with a Gaussian prior
    /// there.
    Roughly {
        /// What it always exceeds.
        least: f64,
        /// Nominal value.
        nominal: f64,
        /// Standard deviation of the logarithm.
        spread: f64,
    },
    /// Between the ends of a tolerance: moves ever more stiffly towards them.
    Within {
        /// Largest value.
        most: f64,
        /// Whether it may have either sign; else the least value is 0.
        is_signed: bool,
    },
    /// Within so much of a nominal value, either way: moves ever more stiffly towards the ends.
    Near {
        /// Nominal value.
        nominal: f64,
        /// Largest distance from it.
        most: f64,
        /// The largest magnitude of a tolerance of which this is a part; `None` of what is no tolerance.
        within: Option<f64>,
    },
    /// Of either sign and of roughly known size: moves ever more stiffly towards a limit of one and a half times [`REACH`].
    Signed {
        /// Standard deviation.
        sigma: f64,
    },
    /// Positive and of roughly known size: moves in its logarithm, ever more stiffly towards [`REACH`] standard deviations.
    Logarithm {
        /// Middle of the usual range.
        centre: f64,
        /// Standard deviation of the logarithm.
        spread: f64,
        /// Whether it may vanish: then only large values are held back.
        vanishes: bool,
    },
}

/// The largest distance of a positive value from the middle of its prior, in standard deviations. Without this limit the
/// search would run away where the recordings cannot distinguish a large value from a still larger one (a hard stop from
/// a harder one). A coordinate far beyond the limit shows that the recordings press against it.
pub const REACH: f64 = 2.2;

/// The same limit for values and places of either sign.
pub const REACH_SIGNED: f64 = 1.5 * REACH;

/// Standard deviations from the middle of the prior at a coordinate: the coordinate itself near 0, and never more than [`REACH`].
fn reached(coordinate: f64, vanishes: bool) -> f64 {
    if vanishes && coordinate < 0.0 { coordinate } else { REACH * libm::tanh(coordinate / REACH) }
}

/// Standard deviation, as a share of a positive value, up to which its prior is Gaussian.
const KNOWN_WITHIN: f64 = 0.25;

/// Longest dead time of a valve that a search can reach, s: two ticks less than the delay line holds at the shortest tick.
const LONGEST_DELAY_S: f64 = (DELAY_LINE - 2) as f64 * Tick::HalfMillisecond.seconds();

/// A parameter that a fit may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Free {
    /// Which.
    pub parameter: Parameter,
    /// How.
    pub freedom: Freedom,
}

impl Free {
    /// A base parameter with a nominal value and its standard deviation. A positive quantity that is known only roughly moves by its logarithm,
    /// as it is never negative and may as well be twice as half as large; one whose nominal value is 0 may be anything up to about its deviation.
    #[must_use]
    pub fn around(parameter: Parameter, nominal: f64, sigma: f64) -> Self {
        let is_positive = parameter.description().min >= 0.0;
        let freedom = if is_positive && nominal <= 0.0 {
            Freedom::Logarithm { centre: 0.5 * sigma, spread: 0.7, vanishes: true }
        } else if is_positive && sigma > KNOWN_WITHIN * nominal {
            Freedom::Roughly { least: 0.0, nominal, spread: libm::log(1.0 + sigma / nominal) }
        } else {
            Freedom::Around { nominal, sigma }
        };
        Self { parameter, freedom }
    }

    /// A base parameter that always exceeds `least`.
    #[must_use]
    pub fn above(least: f64, parameter: Parameter, nominal: f64, sigma: f64) -> Self {
        let spread = libm::log(1.0 + sigma / (nominal - least));
        Self { parameter, freedom: Freedom::Roughly { least, nominal, spread } }
    }

    /// A part of a tolerance: the same distance to either side of a nominal value, moved so far that nothing of it leaves the tolerance.
    #[must_use]
    pub fn part_of_tolerance(parameter: Parameter, within: f64, is_signed: bool, nominal: f64, most: f64) -> Self {
        let least = if is_signed { most - within } else { most };
        let nominal = nominal.max(least).min(within - most);
        Self { parameter, freedom: Freedom::Near { nominal, most, within: Some(within) } }
    }

    /// The largest magnitude within its tolerance, if it has one.
    #[must_use]
    pub fn tolerance(&self) -> Option<f64> {
        match self.freedom {
            Freedom::Within { most, .. } => Some(most),
            Freedom::Near { within, .. } => within,
            _ => None,
        }
    }

    /// How far it may be from its nominal value, where that is bounded on both sides and no tolerance.
    #[must_use]
    pub fn near(&self) -> Option<f64> {
        if let Freedom::Near { most, within: None, .. } = self.freedom { Some(most) } else { None }
    }

    /// How much of what is left to a tolerance a value takes up: 1 at its end. `None` of what is no tolerance.
    #[must_use]
    pub fn share_used(&self, value: f64) -> Option<f64> {
        match self.freedom {
            Freedom::Within { most, .. } => Some(value.abs() / most),
            Freedom::Near { nominal, most, within: Some(_) } => Some((value - nominal).abs() / most),
            _ => None,
        }
    }

    /// The machine file's value: of a tolerance, and of what may vanish or have either sign, none of it.
    #[must_use]
    pub fn nominal(&self) -> f64 {
        match self.freedom {
            Freedom::Around { nominal, .. } | Freedom::Roughly { nominal, .. } | Freedom::Near { nominal, .. } => {
                nominal
            }
            Freedom::Logarithm { centre, vanishes: false, .. } => centre,
            Freedom::Within { .. } | Freedom::Signed { .. } | Freedom::Logarithm { .. } => 0.0,
        }
    }

    /// How far a value is from the machine file's, in standard deviations of its prior, with the sign of the change. A value known only roughly is
    /// as far in its logarithm. Of what is positive and of which the file has none, less than the middle of the prior is not far from it.
    #[must_use]
    pub fn deviations(&self, value: f64) -> f64 {
        let coordinate = self.coordinate(value);
        match self.freedom {
            Freedom::Within { is_signed: false, .. } | Freedom::Logarithm { vanishes: true, .. } => coordinate.max(0.0),
            _ => coordinate,
        }
    }

    /// Standard deviation of the prior where a value is, in the parameter's unit: known roughly, a larger value is less well known.
    #[must_use]
    pub fn width(&self, value: f64) -> f64 {
        self.slope(self.coordinate(value)).abs()
    }

    /// Values as far from the machine file's as is usual, the one above and the one below: by a standard deviation of the prior. A tolerance may be
    /// used by half.
    #[must_use]
    pub fn usually_off(&self) -> [f64; 2] {
        match self.freedom {
            Freedom::Within { most, is_signed } => [0.5 * most, if is_signed { -0.5 * most } else { 0.0 }],
            Freedom::Near { nominal, most, .. } => [nominal + 0.5 * most, nominal - 0.5 * most],
            _ => [self.value(1.0), self.value(-1.0)],
        }
    }

    /// The ends of the value's range: those of the parameter itself. A dead time is also limited to what the delay line holds at the shortest tick,
    /// or to the machine file's value if that is longer. Otherwise a search at twice the tick could end at a dead time that is not possible at the
    /// recordings' own tick.
    fn ends(&self) -> (f64, f64) {
        let description = self.parameter.description();
        let most = match self.parameter {
            Parameter::TransportDelay => description.max.min(LONGEST_DELAY_S.max(self.nominal())),
            _ => description.max,
        };
        (description.min, most)
    }

    /// The value at a coordinate of the fit; coordinate 0 is the middle of the prior.
    #[must_use]
    pub fn value(&self, coordinate: f64) -> f64 {
        let value = match self.freedom {
            Freedom::Around { nominal, sigma } => nominal + sigma * coordinate,
            Freedom::Roughly { least, nominal, spread } => {
                least + (nominal - least) * libm::exp((spread * coordinate).clamp(-40.0, 40.0))
            }
            Freedom::Within { most, is_signed: true } => most * libm::tanh(0.5 * coordinate),
            Freedom::Within { most, is_signed: false } => most * 0.5 * (1.0 + libm::tanh(0.5 * coordinate)),
            Freedom::Near { nominal, most, .. } => nominal + most * libm::tanh(0.5 * coordinate),
            Freedom::Signed { sigma } => sigma * REACH_SIGNED * libm::tanh(coordinate / REACH_SIGNED),
            Freedom::Logarithm { centre, spread, vanishes } => {
                centre * libm::exp((spread * reached(coordinate, vanishes)).max(-40.0))
            }
        };
        let (least, most) = self.ends();
        value.clamp(least, most)
    }

    /// The coordinate of a value.
    #[must_use]
    pub fn coordinate(&self, value: f64) -> f64 {
        match self.freedom {
            Freedom::Around { nominal, sigma } => (value - nominal) / sigma,
            Freedom::Roughly { least, nominal, spread } => {
                libm::log(((value - least) / (nominal - least)).max(1e-17)) / spread
            }
            Freedom::Within { most, is_signed } => {
                let share = if is_signed { value / most } else { 2.0 * value / most - 1.0 };
                2.0 * share.clamp(-0.99, 0.99).atanh()
            }
            Freedom::Near { nominal, most, .. } => 2.0 * ((value - nominal) / most).clamp(-0.99, 0.99).atanh(),
            Freedom::Signed { sigma } => REACH_SIGNED * (value / sigma / REACH_SIGNED).clamp(-0.99, 0.99).atanh(),
            Freedom::Logarithm { centre, spread, vanishes } => {
                let deviations = libm::log((value / centre).max(1e-17)) / spread;
                if vanishes && deviations < 0.0 {
                    deviations
                } else {
                    // Values at or beyond the limit get the largest coordinate.
                    REACH * (deviations / REACH).clamp(-0.99, 0.99).atanh()
                }
            }
        }
    }

    /// Whether the value is held at an end of its range.
    pub fn at_bound(&self, coordinate: f64) -> bool {
        let ((least, most), value) = (self.ends(), self.value(coordinate));
        value <= least || value >= most
    }

    /// Derivative of the value with respect to the coordinate; 0 where the value is held at an end of its range.
    pub(super) fn slope(&self, coordinate: f64) -> f64 {
        match self.freedom {
            _ if self.at_bound(coordinate) => 0.0,
            Freedom::Around { sigma, .. } => sigma,
            Freedom::Roughly { least, spread, .. } => spread * (self.value(coordinate) - least),
            Freedom::Within { most, is_signed } => {
                let whole = if is_signed { most } else { 0.5 * most };
                0.5 * whole * (1.0 - libm::tanh(0.5 * coordinate).powi(2))
            }
            Freedom::Near { most, .. } => 0.5 * most * (1.0 - libm::tanh(0.5 * coordinate).powi(2)),
            Freedom::Signed { sigma } => sigma * (1.0 - libm::tanh(coordinate / REACH_SIGNED).powi(2)),
            Freedom::Logarithm { spread, vanishes, .. } => {
                let share = reached(coordinate, vanishes) / REACH;
                let held = if vanishes && coordinate < 0.0 { 1.0 } else { 1.0 - share * share };
                spread * self.value(coordinate) * held
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use model_core::drive::Drive;
    use test_press::press;

    use super::*;

    #[test]
    fn no_dead_time_is_searched_that_a_drive_cannot_have() {
        let delay = |nominal| Free {
            parameter: Parameter::TransportDelay,
            freedom: Freedom::Around { nominal, sigma: 0.1 * nominal },
        };
        for tick in [Tick::HalfMillisecond, Tick::OneMillisecond, Tick::TwoMilliseconds] {
            let mut machine = press(&[]);
            machine.set(Parameter::TransportDelay, delay(0.01).value(1e6));
            Drive::<f64>::new::<DELAY_LINE>(&machine, tick).unwrap();
        }
        assert!(delay(0.01).at_bound(1e6) && !delay(0.01).at_bound(3.0));
        // A dead time from the machine file is kept, as the drive has it.
        assert!((delay(0.4).value(0.0) - 0.4).abs() < 1e-12);
    }

    #[test]
    fn every_freedom_finds_its_coordinate_back_and_has_the_slope_of_its_value() {
        let signed = |is_signed| Freedom::Within { most: 0.08, is_signed };
        for freedom in [
            Freedom::Around { nominal: 0.02, sigma: 0.004 },
            Freedom::Roughly { least: 0.01, nominal: 0.02, spread: 0.7 },
            signed(true),
            signed(false),
            Freedom::Near { nominal: 0.02, most: 0.002, within: None },
            Freedom::Signed { sigma: 0.05 },
            Freedom::Logarithm { centre: 0.01, spread: 0.7, vanishes: false },
        ] {
            let free = Free { parameter: Parameter::MeteringRatio, freedom };
            for coordinate in [-1.5, -0.2, 0.0, 0.9, 1.8] {
                let value = free.value(coordinate);
                assert!((free.coordinate(value) - coordinate).abs() < 1e-9, "{freedom:?} {coordinate}");
                let difference = (free.value(coordinate + 1e-5) - free.value(coordinate - 1e-5)) / 2e-5;
                assert!((free.slope(coordinate) / difference - 1.0).abs() < 1e-6, "{freedom:?} {coordinate}");
            }
        }
    }

    #[test]
    fn a_tolerance_is_never_exceeded_and_a_positive_value_never_negative() {
        let value = |freedom, coordinate| Free { parameter: Parameter::MeteringRatio, freedom }.value(coordinate);
        let (both, one) =
            (Freedom::Within { most: 0.08, is_signed: true }, Freedom::Within { most: 0.08, is_signed: false });
        assert!((-0.08..=-0.079).contains(&value(both, -9.0)) && (0.079..=0.08).contains(&value(both, 9.0)));
        assert!((0.0..0.001).contains(&value(one, -9.0)) && (value(one, 0.0) - 0.04).abs() < 1e-12);
        let tank = Free::around(Parameter::TankPressure, 2e5, 2e5);
        assert!(matches!(tank.freedom, Freedom::Roughly { .. }) && tank.value(-5.0) > 0.0);
        assert!((tank.value(1.0) - 4e5).abs() < 1.0, "one deviation is a factor of two");
        let known = Free::around(Parameter::TankPressure, 2e5, 2e4);
        assert!(
            matches!(known.freedom, Freedom::Around { .. }) && known.value(-20.0) == 0.0,
            "no oil pulls in a tank line"
        );
        // What is known well has a Gaussian prior as before, and what is 0 by the file can move away from it.
        assert!(matches!(Free::around(Parameter::MovingMass, 100.0, 5.0).freedom, Freedom::Around { .. }));
        let lap = Free::around(Parameter::DeadZone, 0.0, 0.03);
        assert!(lap.slope(0.0) > 0.0 && (0.001..0.03).contains(&lap.value(0.0)));
    }

    #[test]
    fn a_part_of_a_tolerance_stays_within_it_and_is_used_up_at_its_own_ends() {
        let part =
            |is_signed, nominal| Free::part_of_tolerance(Parameter::MeteringRatio, 0.08, is_signed, nominal, 0.01);
        for (is_signed, nominal, [low, high]) in [
            (true, 0.02, [0.01, 0.03]),
            (true, -0.1, [-0.08, -0.06]),
            (false, 0.0, [0.0, 0.02]),
            (false, 0.079, [0.06, 0.08]),
        ] {
            let free = part(is_signed, nominal);
            assert!((free.value(-40.0) - low).abs() < 1e-9 && (free.value(40.0) - high).abs() < 1e-9, "{free:?}");
            assert!((free.share_used(high).unwrap() - 1.0).abs() < 1e-9 && free.near().is_none());
            assert_eq!(free.tolerance(), Some(0.08));
        }
        let whole =
            Free { parameter: Parameter::MeteringRatio, freedom: Freedom::Within { most: 0.08, is_signed: true } };
        assert_eq!(whole.share_used(-0.06), Some(0.75));
    }

    #[test]
    fn a_distance_from_the_machine_file_is_counted_in_deviations_of_its_prior() {
        let off = |parameter, freedom, value| Free { parameter, freedom }.deviations(value);
        let around = Freedom::Around { nominal: 100.0, sigma: 5.0 };
        assert!((off(Parameter::MovingMass, around, 85.0) + 3.0).abs() < 1e-12);
        // One deviation is a factor of two, three are a factor of eight, either way.
        let roughly =
            |value| off(Parameter::ViscousFriction, Free::around(Parameter::ViscousFriction, 1e3, 1e3).freedom, value);
        assert!((roughly(8e3) - 3.0).abs() < 1e-9 && (roughly(125.0) + 3.0).abs() < 1e-9);
        let within = |is_signed, value| off(Parameter::MeteringRatio, Freedom::Within { most: 0.08, is_signed }, value);
        assert!(within(true, 0.0).abs() < 1e-12 && (within(true, -0.077) + within(true, 0.077)).abs() < 1e-12);
        assert!(within(true, 0.077) > 3.0 && within(false, 0.078) > 3.0);
        assert!(within(false, 0.001) == 0.0, "a drive with none of it is not far from the file");
        let lap = Free::around(Parameter::DeadZone, 0.0, 0.03);
        assert!(lap.deviations(0.0) == 0.0 && lap.deviations(0.06) > 3.0 && lap.nominal() == 0.0);
    }

    #[test]
    fn the_width_of_a_prior_is_that_at_the_value() {
        let is_near = |found: [f64; 2], expected: [f64; 2]| {
            let near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-9);
            assert!(near, "{found:?} {expected:?}");
        };
        let mass = Free::around(Parameter::MovingMass, 100.0, 5.0);
        assert!((mass.width(90.0) - 5.0).abs() < 1e-12);
        let friction = Free::around(Parameter::ViscousFriction, 1e3, 1e3);
        assert!((friction.width(4e3) - 4e3 * 2.0_f64.ln()).abs() < 1e-6);
        is_near(friction.usually_off(), [2e3, 500.0]);
        let within = |is_signed| {
            let freedom = Freedom::Within { most: 0.08, is_signed };
            Free { parameter: Parameter::MeteringRatio, freedom }.usually_off()
        };
        is_near(within(true), [0.04, -0.04]);
        is_near(within(false), [0.04, 0.0]);
    }
}
