//! What the steps expect of this machine, and its values in whole units: µm, kPa, mV, thousandths.

use model_core::machine::{Bases, Machine, Parameter};
use model_core::number::{Number, PerUnit};

use crate::period::Report;
use crate::supervision::Limits;

/// Pressures below this share of the supply's mean that there is no oil, and below the next that its pressure is low.
const NO_OIL: f64 = 0.05;
const LOW: f64 = 0.4;
/// Least difference of pressures by the direction of the move, of the supply.
const DIFFERENCE: f64 = 0.005;
/// Slope of the open command, V/s, and how far beyond the overlap it goes, V.
const SLOPE_V_PER_S: f64 = 2.0;
const BEYOND_V: f64 = 2.0;
/// The overlap may be larger than the model's by this factor.
const OVERLAP_OFF: f64 = 1.5;
/// How far a voltage read back may be off, mV.
pub(super) const READ_BACK_MV: i32 = 50;
/// How long valve and rod come to rest, and how long a step watches, s.
const REST_S: f64 = 0.3;

/// Configuration of the steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rules {
    pub(super) bases: Bases,
    stroke_um: i64,
    supply_kpa: i64,
    full_mv: i64,
    pub(super) no_oil_kpa: i32,
    pub(super) low_kpa: i32,
    pub(super) difference_kpa: i32,
    /// Travel of the spool per volt that extends, thousandths.
    pub(super) spool_per_v: i32,
    /// The command that passes nothing, and 1 V that extends.
    pub(super) neutral: PerUnit,
    volt: PerUnit,
    /// Change of the open command in a period, and its end, µV.
    pub(super) slope_uv: i32,
    pub(super) most_uv: i32,
    /// Largest following error by the limits, µm.
    pub(super) error_um: Option<i32>,
    /// Whether every deviation is limited.
    pub(super) watched: bool,
    /// Periods until valve and rod rest.
    pub(super) rest: u32,
    /// Periods until following may begin.
    pub(super) settling: u32,
}

/// What a period shows, in whole units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Seen {
    pub(super) position_um: i32,
    pub(super) spool: Option<i32>,
    pub(super) pressures_kpa: Option<[i32; 2]>,
    pub(super) read_back_mv: Option<i32>,
}

/// A value in units of which its base has so many.
fn whole(value: PerUnit, base: i64) -> i32 {
    let units = i64::from(value.to_bits()) * base;
    i32::try_from((units + (1 << 27)) >> 28).unwrap_or(i32::MAX)
}

#[expect(clippy::cast_possible_truncation, reason = "saturates; sizes of machines are far below")]
fn rounded(value: f64) -> i32 {
    libm::round(value) as i32
}

impl Rules {
    pub(super) fn new(machine: &Machine<f64>, bases: &Bases, limits: &Limits) -> Self {
        let gain = machine.get(Parameter::ValveGain);
        let overlap_v = machine.get(Parameter::DeadZone) / gain.abs();
        let base = |value: f64| i64::from(rounded(value));
        let (stroke_um, supply_kpa) = (base(bases.stroke_m * 1e6), base(bases.pressure_pa * 1e-3));
        let full_mv = base(bases.command_v * 1e3);
        let kpa = |share: f64| rounded(share * bases.pressure_pa * 1e-3);
        let mut rules = Self {
            bases: *bases,
            stroke_um,
            supply_kpa,
            full_mv,
            no_oil_kpa: kpa(NO_OIL),
            low_kpa: kpa(LOW),
            difference_kpa: kpa(DIFFERENCE).max(1),
            spool_per_v: rounded(gain.abs() * 1e3),
            neutral: limits.neutral,
            volt: PerUnit::saturated(1.0_f64.copysign(gain) / bases.command_v),
            slope_uv: rounded(SLOPE_V_PER_S * 1e6 * bases.tick_s).max(1),
            most_uv: rounded((OVERLAP_OFF * overlap_v + BEYOND_V) * 1e6),
            error_um: None,
            watched: false,
            rest: rounded(REST_S / bases.tick_s).unsigned_abs(),
            settling: u32::from(limits.settling) + 1,
        };
        rules.limit(limits);
        rules
    }

    /// What depends on the limits of deviation.
    pub(super) fn limit(&mut self, limits: &Limits) {
        let deviation = &limits.deviation;
        self.error_um = deviation.position.map(|limit| self.micrometres(limit.travel));
        self.watched = deviation.position.is_some()
            && deviation.velocity.is_some()
            && deviation.spool.is_some()
            && deviation.range.is_some()
            && deviation.rest.is_some();
    }

    /// The command that is so many µV beyond neutral; positive extends.
    pub(super) fn command(&self, uv: i32) -> PerUnit {
        let bits = i64::from(self.volt.to_bits()) * i64::from(uv) / 1_000_000;
        self.neutral + PerUnit::from_bits(i32::try_from(bits).unwrap_or(0))
    }

    /// A command in mV.
    pub(super) fn millivolts(&self, command: PerUnit) -> i32 {
        whole(command, self.full_mv)
    }

    /// A part of the stroke in µm.
    pub(super) fn micrometres(&self, travel: PerUnit) -> i32 {
        whole(travel, self.stroke_um)
    }

    pub(super) fn seen(&self, report: &Report) -> Seen {
        let measured = &report.measured;
        let pressures = measured.pressure_a.zip(measured.pressure_b);
        Seen {
            position_um: self.micrometres(measured.position),
            spool: measured.spool.map(|spool| whole(spool, 1000)),
            pressures_kpa: pressures.map(|(a, b)| [whole(a, self.supply_kpa), whole(b, self.supply_kpa)]),
            read_back_mv: report.read_back.map(|back| whole(back, self.full_mv)),
        }
    }
}
