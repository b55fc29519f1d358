//! From the devices' counts to measured values, with every check that a sensor can fail.

use model_core::number::{Number, PerUnit};

use super::fault::{Device, Fault};
use super::limits::Limits;
use super::log::{Findings, Log};
use super::stuck_sensor::Stillness;
use crate::control::Predicted;
use crate::io::Cause;
use crate::measured::{AnalogSignal, Measured};
use crate::scaling::{Calibration, Reading, Travel, TravelState};

/// What the devices answered in a period, before anything judges it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// The counter.
    pub(crate) position: Result<i32, Cause>,
    /// The analogue inputs in the order of [`AnalogSignal::ALL`]; `None` where there is no sensor, and after an input that did not answer.
    pub(crate) voltages: [Option<Result<i32, Cause>>; AnalogSignal::COUNT],
}

/// What the sensors' checks remember from period to period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Senses {
    pub(crate) travel: TravelState,
    still_position: Stillness,
    still: [Stillness; AnalogSignal::COUNT],
}

/// What the sensors should show, according to the model and the output.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expected {
    /// The model, while it runs.
    pub(crate) predicted: Option<Predicted>,
    /// Command that the output holds, where that is certain.
    pub(crate) put_out: Option<PerUnit>,
}

impl Expected {
    fn of(&self, signal: AnalogSignal) -> Option<PerUnit> {
        let predicted = self.predicted.as_ref()?;
        match signal {
            AnalogSignal::Command => self.put_out,
            AnalogSignal::Spool => Some(predicted.spool),
            AnalogSignal::PressureA => Some(predicted.pressure_a),
            AnalogSignal::PressureB => Some(predicted.pressure_b),
            AnalogSignal::OilTemperature => None,
        }
    }
}

impl Senses {
    /// State with the rod at the reference, at this count.
    pub(crate) fn new(count: i32) -> Self {
        Self {
            travel: Travel::start(count),
            still_position: Stillness::NEW,
            still: [Stillness::NEW; AnalogSignal::COUNT],
        }
    }

    /// Forgets how long the sensors have stood still.
    pub(crate) fn rouse(&mut self) {
        *self =
            Self { travel: self.travel, still_position: Stillness::NEW, still: [Stillness::NEW; AnalogSignal::COUNT] };
    }

    /// Whether the encoder has not moved by one count while the model, which is here now, moved so far.
    pub(crate) fn position_stands(&self, model: PerUnit, travel: PerUnit) -> bool {
        self.still_position.moved(model) > travel
    }

    /// Position in this period, as a share of the stroke.
    pub(crate) fn position<L: Log>(
        &mut self,
        counted: Result<i32, Cause>,
        travel: &Travel,
        limits: &Limits,
        expected: &Expected,
        found: &mut Findings<'_, L>,
    ) -> PerUnit {
        match counted {
            Ok(count) => {
                if let Err(jump) = travel.follow(&mut self.travel, count) {
                    found.note(&Fault::EncoderJump { counts: jump.counts });
                }
                if let (Some(patience), Some(model)) = (&limits.still_position, &expected.predicted)
                    && self.still_position.step(patience, count.into(), model.position)
                {
                    found.note(&Fault::PositionStuck { position: travel.position(&self.travel) });
                }
            }
            Err(cause) => {
                Travel::miss(&mut self.travel);
                found.note(&Fault::Silent { device: Device::Position, cause });
            }
        }
        travel.position(&self.travel)
    }

    /// All voltages in this period, per unit, in the order of [`AnalogSignal::ALL`]; `None` where there is no sensor or it fails.
    pub(crate) fn voltages<L: Log>(
        &mut self,
        converted: &[Option<Result<i32, Cause>>; AnalogSignal::COUNT],
        calibration: &Calibration,
        limits: &Limits,
        expected: &Expected,
        found: &mut Findings<'_, L>,
    ) -> [Option<PerUnit>; AnalogSignal::COUNT] {
        let mut values = [None; AnalogSignal::COUNT];
        let remembered = self.still.iter_mut().zip(&limits.still);
        let answers = converted.iter().zip(calibration.signals());
        for ((value, (answer, (signal, row))), (still, patience)) in values.iter_mut().zip(answers).zip(remembered) {
            let (Some(answer), Some(row)) = (*answer, row) else { continue };
            let count = match answer {
                Ok(count) => count,
                Err(cause) => {
                    found.note(&Fault::Silent { device: Device::Inputs, cause });
                    continue;
                }
            };
            match row.read(count) {
                Reading::Working(working) => {
                    *value = Some(working);
                    if let (Some(patience), Some(model)) = (patience, expected.of(signal))
                        && still.step(patience, count.into(), model)
                    {
                        found.note(&Fault::Stuck { signal, count });
                    }
                }
                Reading::OutOfRange => found.note(&Fault::OutOfRange { signal, count }),
                Reading::Open => found.note(&Fault::OpenWire { signal, count }),
            }
        }
        values
    }
}

/// Sorts the voltages into measured values and the command that was read back.
pub(crate) fn sorted(
    position: PerUnit,
    voltages: [Option<PerUnit>; AnalogSignal::COUNT],
) -> (Measured, Option<PerUnit>) {
    let [command, spool, pressure_a, pressure_b, oil_temperature] = voltages;
    (Measured { position, spool, pressure_a, pressure_b, oil_temperature }, command)
}

/// Whether two values are farther apart than this distance.
pub(crate) fn apart(one: PerUnit, other: PerUnit, by: PerUnit) -> bool {
    (one - other).magnitude() > by
}
