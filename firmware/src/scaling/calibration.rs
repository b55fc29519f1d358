//! Calibration: one table from counts to the model's per unit and back.
//!
//! An engineer states each sensor as its data sheet does ([`Sensor`]: volts, SI units, the working range and the reading of an open
//! wire). At start-up each becomes a [`Row`] of whole numbers; in the period a row takes one multiplication, and saturates. Its result
//! differs from the exact one by at most half a step (1.9e-9) plus 2e-9 of the voltage's part (asserted below against f64).
//!
//! The scales are computed once, in f64, and need nothing but rounding from libm; model-core links libm already. (`micromath`
//! has only f32, whose 24 bits are fewer than a row keeps.)
//!
//! **Open wires.** A converter cannot distinguish an open wire from a voltage. A row can, if the sensor never gives the voltage that an
//! open wire reads: a live zero (0.5…4.5 V, 1…5 V) with a resistor to ground, an LVDT conditioner's fault level, or a resistor to a
//! rail beyond the working range ([`ads8688`](crate::io::ads8688) describes which). Where a sensor has no such voltage, [`Sensor::open`]
//! is `None`, and the only check left is that the sensor moves.

use model_core::machine::Bases;
use model_core::number::PerUnit;

use super::line::StraightLine;
use super::output::{Actuator, Output};
use super::scale::{Band, CalibrationError, Counts, ONE, counts_per_volt};
use crate::measured::AnalogSignal;

/// A point of a sensor's straight line; two points define the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Voltage at the input, V.
    pub volts: f64,
    /// Value at this voltage, in the signal's SI unit: V of command, 1 of spool travel, Pa, °C.
    pub value: f64,
}

/// A sensor with a voltage output, as its data sheet and its wiring describe it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Channel of the analogue inputs that it is wired to.
    pub channel: u8,
    /// One point of its line.
    pub low: Point,
    /// Another.
    pub high: Point,
    /// Voltages that a working sensor gives, tolerances included.
    pub working: Band,
    /// What its open wire reads, where that is outside of `working`.
    pub open: Option<Band>,
}

/// What 1 per unit of a signal is, in its SI unit.
fn base(signal: AnalogSignal, bases: &Bases) -> f64 {
    match signal {
        AnalogSignal::Command => bases.command_v,
        AnalogSignal::Spool => 1.0,
        AnalogSignal::PressureA | AnalogSignal::PressureB => bases.pressure_pa,
        AnalogSignal::OilTemperature => bases.temperature_c,
    }
}

/// What a count means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// A working sensor's value, per unit.
    Working(PerUnit),
    /// No working sensor gives this count.
    OutOfRange,
    /// The wire is open.
    Open,
}

/// A row of the table: one sensor in whole numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    channel: u8,
    line: StraightLine,
    working: Counts,
    open: Option<Counts>,
}

impl Row {
    /// From a sensor on an input whose 2¹⁶ counts are `span_uv` µV.
    ///
    /// # Errors
    /// The sensor's points do not define a line, or its bands are not valid.
    pub fn new(signal: AnalogSignal, sensor: &Sensor, span_uv: u32, bases: &Bases) -> Result<Self, CalibrationError> {
        let Sensor { low, high, .. } = *sensor;
        let per_volt = (high.value - low.value) / (high.volts - low.volts) / base(signal, bases);
        let at_zero_v = low.value / base(signal, bases) - per_volt * low.volts;
        let per_count = per_volt / counts_per_volt(span_uv);
        let line =
            StraightLine::new(per_count * ONE, at_zero_v * ONE).ok_or(CalibrationError::Slope { signal, per_count })?;
        let working = Counts::of(sensor.working, signal, span_uv)?;
        let open = sensor.open.map(|band| Counts::of(band, signal, span_uv)).transpose()?;
        if let (Some(band), Some(open)) = (sensor.open, open)
            && open.lowest <= working.highest
            && working.lowest <= open.highest
        {
            let Band { from_v, to_v } = band;
            return Err(CalibrationError::OpenWithinWorking { signal, from_v, to_v });
        }
        Ok(Self { channel: sensor.channel, line, working, open })
    }

    /// Channel of the analogue inputs.
    #[must_use]
    pub fn channel(&self) -> u8 {
        self.channel
    }

    /// Lowest and highest count of a working sensor.
    #[must_use]
    pub fn working(&self) -> [i32; 2] {
        [self.working.lowest, self.working.highest]
    }

    /// What a count means.
    #[must_use]
    pub fn read(&self, count: i32) -> Reading {
        if self.working.hold(count) {
            Reading::Working(PerUnit::from_bits(self.line.at(count.into())))
        } else if self.open.is_some_and(|open| open.hold(count)) {
            Reading::Open
        } else {
            Reading::OutOfRange
        }
    }
}

/// The table: a row for each signal that has a sensor, and the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Calibration {
    rows: [Option<Row>; AnalogSignal::COUNT],
    /// The output to the valve.
    pub output: Output,
}

impl Calibration {
    /// From the sensors, each with its signal, on inputs whose 2¹⁶ counts are `inputs_uv` µV, and from the actuator on an output where
    /// they are `output_uv` µV. Of two sensors for one signal the later one is used.
    ///
    /// # Errors
    /// The first sensor that is not valid.
    pub fn new(
        sensors: &[(AnalogSignal, Sensor)],
        inputs_uv: u32,
        actuator: &Actuator,
        output_uv: u32,
        bases: &Bases,
    ) -> Result<Self, CalibrationError> {
        let none = Self { rows: [None; AnalogSignal::COUNT], output: Output::new(actuator, output_uv)? };
        sensors.iter().try_fold(none, |table, (signal, sensor)| table.with(*signal, sensor, inputs_uv, bases))
    }

    /// The same with another sensor, on inputs whose 2¹⁶ counts are `inputs_uv` µV.
    ///
    /// # Errors
    /// The sensor is not valid.
    pub fn with(
        mut self,
        signal: AnalogSignal,
        sensor: &Sensor,
        inputs_uv: u32,
        bases: &Bases,
    ) -> Result<Self, CalibrationError> {
        if let Some(row) = self.rows.get_mut(signal as usize) {
            *row = Some(Row::new(signal, sensor, inputs_uv, bases)?);
        }
        Ok(self)
    }

    /// The row of a signal, if it has a sensor.
    #[must_use]
    pub fn row(&self, signal: AnalogSignal) -> Option<&Row> {
        self.rows.get(signal as usize)?.as_ref()
    }

    /// Every signal with its row, if it has one, in the order of [`AnalogSignal::ALL`].
    pub fn signals(&self) -> impl Iterator<Item = (AnalogSignal, Option<&Row>)> {
        AnalogSignal::ALL.into_iter().zip(&self.rows).map(|(signal, row)| (signal, row.as_ref()))
    }
}

#[cfg(test)]
mod tests {
    use model_core::drive::Drive;
    use model_core::machine::Tick;

    use proptest::prelude::*;

    use super::*;
    use crate::mock::press;

    const SPAN_UV: u32 = 5_120_000;

    fn bases() -> Bases {
        *Drive::<PerUnit>::new::<64>(&press(), Tick::OneMillisecond).unwrap().bases()
    }

    /// 0.5 to 4.5 V for 0 to 10 MPa, with 100 kΩ to ground.
    fn pressure() -> Sensor {
        Sensor {
            channel: 2,
            low: Point { volts: 0.5, value: 0.0 },
            high: Point { volts: 4.5, value: 1e7 },
            working: Band { from_v: 0.4, to_v: 4.6 },
            open: Some(Band { from_v: -0.1, to_v: 0.3 }),
        }
    }

    fn row(sensor: &Sensor) -> Result<Row, CalibrationError> {
        Row::new(AnalogSignal::PressureA, sensor, SPAN_UV, &bases())
    }

    #[test]
    fn half_of_a_live_zeros_range_is_half_of_its_pressure() {
        // 2.5 V are 32 000 counts of 78.125 µV and 5 MPa, relative to a supply of 7 MPa.
        let Reading::Working(pressure) = row(&pressure()).unwrap().read(32_000) else { panic!("works") };
        assert!((pressure.to_f64() - 5.0 / 7.0).abs() < 4e-9);
    }

    #[test]
    fn an_open_wire_and_a_sensor_out_of_its_range_are_told_apart() {
        let row = row(&pressure()).unwrap();
        assert_eq!(row.read(0), Reading::Open);
        assert_eq!(row.read(2560), Reading::Open); // 0.2 V
        assert_eq!(row.read(4480), Reading::OutOfRange); // 0.35 V
        assert!(matches!(row.read(5120), Reading::Working(_))); // 0.4 V
        assert_eq!(row.read(60_000), Reading::OutOfRange); // 4.69 V
        // An open input of the ADS8688 without a resistor reads some +2 V, which cannot be recognised.
        assert!(matches!(row.read(28_160), Reading::Working(_)));
    }

    #[test]
    fn what_is_no_sensor_is_refused_with_its_values() {
        let mut flat = pressure();
        flat.high.volts = 0.5;
        assert!(matches!(row(&flat), Err(CalibrationError::Slope { signal: AnalogSignal::PressureA, .. })));
        let mut reversed = pressure();
        reversed.working = Band { from_v: 4.6, to_v: 0.4 };
        let refused = CalibrationError::Band { signal: AnalogSignal::PressureA, from_v: 4.6, to_v: 0.4 };
        assert_eq!(row(&reversed), Err(refused));
        let mut open = pressure();
        open.open = Some(Band { from_v: 0.0, to_v: 0.45 });
        let refused = CalibrationError::OpenWithinWorking { signal: AnalogSignal::PressureA, from_v: 0.0, to_v: 0.45 };
        assert_eq!(row(&open), Err(refused));
    }

    #[test]
    fn the_table_has_a_row_for_each_sensor() {
        let actuator = Actuator { zero_v: 0.0, full_v: 10.0, lowest_v: -10.0, highest_v: 10.0 };
        let spool = Sensor { channel: 1, high: Point { volts: 4.5, value: 1.0 }, ..pressure() };
        let sensors = [(AnalogSignal::PressureB, pressure()), (AnalogSignal::Spool, spool)];
        let table = Calibration::new(&sensors, SPAN_UV, &actuator, 20_000_000, &bases()).unwrap();
        let channels = table.signals().map(|(signal, row)| (signal, row.map(Row::channel)));
        let expected = AnalogSignal::ALL.into_iter().zip([None, Some(1), None, Some(2), None]);
        assert!(channels.eq(expected));
    }

    proptest! {
        #[test]
        fn a_row_is_the_sensors_line_in_real_numbers(
            low_v in -10.0..10.0, more_v in 0.5..10.0, low in -1e7..1e7, more in 1e5..3e7, falls in any::<bool>(), count in -2_000_000_000..=2_000_000_000_i32,
            less in 0_u32..31,
        ) {
            let count = count >> less;
            let (low, high) = if falls { (low, low - more) } else { (low, low + more) };
            let sensor = Sensor {
                low: Point { volts: low_v, value: low },
                high: Point { volts: low_v + more_v, value: high },
                working: Band { from_v: -1.6e5, to_v: 1.6e5 },
                open: None,
                ..pressure()
            };
            let bases = bases();
            let volts = f64::from(count) * 5.12 / 65_536.0;
            let exact: f64 = (low + (high - low) * (volts - low_v) / more_v) / bases.pressure_pa;
            let Reading::Working(read) = Row::new(AnalogSignal::PressureA, &sensor, SPAN_UV, &bases).unwrap().read(count) else {
                panic!("works")
            };
            let slope_part: f64 = (high - low) * volts / more_v / bases.pressure_pa;
            let held = exact.clamp(-8.0, 8.0);
            prop_assert!((read.to_f64() - held).abs() <= 4e-9 + slope_part.abs() * 2e-9, "{} {held}", read.to_f64());
        }
    }
}
