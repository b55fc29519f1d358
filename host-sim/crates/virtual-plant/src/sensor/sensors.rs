//! The sensors: what the control system sees of the true signals.

use model_core::machine::{Machine, Parameter};
use recording::seeded_noise::Noise;

use super::linkage::{Linkage, LinkageError};

/// A value rounded to the steps of an analogue-digital converter.
fn quantised(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}

/// The spool's LVDT.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpoolSensor {
    /// Counts per full spool travel; it reads −counts to counts − 1.
    pub counts_per_unit: f64,
    /// Standard deviation of its noise before rounding, relative to the travel.
    pub noise_std: f64,
}

/// The sensor of the rod's position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PositionSensor {
    /// An incremental encoder on the joint, converted back to rod position through the linkage.
    Encoder {
        /// Triangle between rod and joint.
        linkage: Linkage,
        /// Impulses per turn.
        counts_per_rev: f64,
    },
    /// A linear scale on the rod.
    Linear {
        /// Its resolution, m; 0 is exact.
        resolution_m: f64,
    },
}

impl PositionSensor {
    /// The joint encoder of a machine, with its linkage.
    pub fn encoder(machine: &Machine<f64>) -> Result<Self, LinkageError> {
        let counts_per_rev = machine.get(Parameter::EncoderCounts);
        Ok(Self::Encoder { linkage: Linkage::of(machine)?, counts_per_rev })
    }

    /// The rod position, m, as the sensor shows it. It has no noise, because an encoder counts.
    #[must_use]
    pub fn measure(&self, position_m: f64) -> f64 {
        match self {
            Self::Encoder { linkage, counts_per_rev } => {
                let step_rad = std::f64::consts::TAU / counts_per_rev;
                linkage.position_m(quantised(linkage.angle_rad(position_m), step_rad))
            }
            Self::Linear { resolution_m } => quantised(position_m, *resolution_m),
        }
    }
}

/// A pressure transmitter on a bipolar converter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureSensor {
    /// Standard deviation of its noise, Pa.
    pub noise_std_pa: f64,
    /// Full scale, Pa; it clips at ± this value.
    pub range_pa: f64,
    /// Bits of the converter over ± the full scale; 0 is exact.
    pub bits: u8,
}

impl PressureSensor {
    fn measure(&self, pressure_pa: f64, noise: &mut Noise) -> f64 {
        // The noise is always drawn, so that a sensor with less noise gets the same random numbers, scaled.
        let seen = pressure_pa + noise.gaussian(self.noise_std_pa);
        let step = if self.bits == 0 { 0.0 } else { self.range_pa * 2.0_f64.powi(1 - i32::from(self.bits)) };
        quantised(seen, step).clamp(-self.range_pa, self.range_pa)
    }
}

/// A thermometer in the tank's oil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermometer {
    /// Temperature of the oil, °C: constant over a recording.
    pub oil_c: f64,
    /// Standard deviation of its noise, K.
    pub noise_std_k: f64,
    /// Its resolution, K; 0 is exact.
    pub resolution_k: f64,
}

impl Thermometer {
    /// As many readings as there are ticks, °C.
    pub(crate) fn read(&self, seed: u64, ticks: usize) -> Vec<f64> {
        // The lower streams belong to the other sensors.
        let mut noise = Noise::new(seed, 6);
        (0..ticks).map(|_| quantised(self.oil_c + noise.gaussian(self.noise_std_k), self.resolution_k)).collect()
    }
}

/// All sensors of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensors {
    /// Spool position.
    pub spool: SpoolSensor,
    /// Rod position.
    pub position: PositionSensor,
    /// Standard deviation of the noise on the position before rounding, m; 0 for an encoder, which counts.
    pub position_noise_m: f64,
    /// Both chamber pressures, and the supply pressure where it is recorded.
    pub pressure: PressureSensor,
    /// Whether the supply pressure is recorded.
    pub sees_supply: bool,
}

impl Sensors {
    /// The paper's sensors: LVDT and joint encoder as the machine has them; pressure transmitters of
    /// 2.5·10⁷ Pa and 16 bit with 3·10⁴ Pa of noise.
    pub fn of(machine: &Machine<f64>) -> Result<Self, LinkageError> {
        Ok(Self::with_position(machine, PositionSensor::encoder(machine)?))
    }

    /// As [`Self::of`], with another position sensor: a drive without linkage has a scale at its rod.
    #[must_use]
    pub fn with_position(machine: &Machine<f64>, position: PositionSensor) -> Self {
        Self {
            spool: SpoolSensor { counts_per_unit: machine.get(Parameter::LvdtCounts), noise_std: 0.0 },
            position,
            position_noise_m: 0.0,
            pressure: PressureSensor { noise_std_pa: 3.0e4, range_pa: 2.5e7, bits: 16 },
            sees_supply: false,
        }
    }

    /// Sensors that show the true values.
    #[must_use]
    pub const fn exact() -> Self {
        Self {
            spool: SpoolSensor { counts_per_unit: f64::INFINITY, noise_std: 0.0 },
            position: PositionSensor::Linear { resolution_m: 0.0 },
            position_noise_m: 0.0,
            pressure: PressureSensor { noise_std_pa: 0.0, range_pa: f64::INFINITY, bits: 0 },
            sees_supply: false,
        }
    }
}

/// What the sensors show at one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Spool position, 1.
    pub spool: f64,
    /// Rod position, m.
    pub position_m: f64,
    /// Pressure in chamber A, Pa.
    pub pressure_a_pa: f64,
    /// Pressure in chamber B, Pa.
    pub pressure_b_pa: f64,
    /// Pressure of the supply, Pa.
    pub supply_pressure_pa: f64,
}

/// The sensors in operation, with a noise source for each.
#[derive(Clone, Debug)]
pub(crate) struct Measuring {
    sensors: Sensors,
    noise: [Noise; 5],
}

impl Measuring {
    pub(crate) fn new(sensors: Sensors, seed: u64) -> Self {
        Self { sensors, noise: [1, 2, 3, 4, 5].map(|stream| Noise::new(seed, stream)) }
    }

    /// The readings for signals as sensors without noise would see them.
    pub(crate) fn read(&mut self, seen: &Reading) -> Reading {
        let [spool_noise, noise_a, noise_b, position_noise, supply_noise] = &mut self.noise;
        let Sensors { spool, position, position_noise_m, pressure, .. } = &self.sensors;
        let counts = spool.counts_per_unit;
        let noisy = seen.spool + spool_noise.gaussian(spool.noise_std);
        Reading {
            spool: if counts.is_finite() {
                (noisy * counts).round().clamp(-counts, counts - 1.0) / counts
            } else {
                noisy
            },
            position_m: position.measure(seen.position_m + position_noise.gaussian(*position_noise_m)),
            pressure_a_pa: pressure.measure(seen.pressure_a_pa, noise_a),
            pressure_b_pa: pressure.measure(seen.pressure_b_pa, noise_b),
            supply_pressure_pa: pressure.measure(seen.supply_pressure_pa, supply_noise),
        }
    }
}

#[cfg(test)]
mod tests {
    use model_core::machine::Source;

    use super::*;

    #[test]
    fn the_encoder_resolves_the_rod_to_a_millimetre_and_no_finer() {
        let machine = Machine::with_defaults(Source::Valve);
        let sensor = PositionSensor::encoder(&machine).unwrap();
        let mut distinct = std::collections::BTreeSet::new();
        for k in 0..=30_000 {
            let position = f64::from(k) * 1e-5;
            let seen = sensor.measure(position);
            assert!((seen - position).abs() < 0.5e-3);
            distinct.insert(seen.to_bits());
        }
        assert!((300..800).contains(&distinct.len()), "{}", distinct.len());
    }

    #[test]
    fn the_lvdt_counts_in_parts_of_32768_and_stops_at_its_end() {
        let machine = Machine::with_defaults(Source::Valve);
        let mut measuring = Measuring::new(Sensors::of(&machine).unwrap(), 0);
        let mut read = |spool| measuring.read(&Reading { spool, ..Reading::default() }).spool;
        assert!((read(0.5 + 1e-5) - 0.5).abs() < 1e-16);
        assert!((read(1.2) - 32767.0 / 32768.0).abs() < 1e-16);
    }

    #[test]
    fn exact_sensors_show_the_truth() {
        let state = Reading { spool: 0.123_456_789, pressure_a_pa: 1.234_567e6, position_m: 0.1, ..Reading::default() };
        let reading = Measuring::new(Sensors::exact(), 3).read(&state);
        assert_eq!(reading.spool.to_bits(), state.spool.to_bits());
        assert_eq!(reading.pressure_a_pa.to_bits(), state.pressure_a_pa.to_bits());
    }
}
