//! What a period asks its devices, and how often: every reading before anything is computed, the command afterwards.
//!
//! Compiled twice, for devices that block and for those that are awaited.

use super::{AnalogIn, AnalogOut, PositionIn, twice};
use crate::io::{Cause, IoError};
use crate::measured::AnalogSignal;
use crate::period::{Devices, Rig};
use crate::scaling::{Calibration, TravelState};
use crate::supervision::sense::Sample;

/// Puts a count out in up to `attempts` attempts, at least one, and returns the last error if none succeeds.
#[twice]
pub(in crate::period) async fn write<O: AnalogOut>(attempts: u8, device: &mut O, count: i32) -> Result<(), O::Error> {
    for _ in 1..attempts {
        if device.write(count).await.is_ok() {
            return Ok(());
        }
    }
    device.write(count).await
}

/// The same, and neutral once more where none succeeds, because the valve must then be neutral.
#[twice]
pub(in crate::period) async fn put_out<O: AnalogOut>(
    attempts: u8,
    device: &mut O,
    count: i32,
    neutral: i32,
) -> Result<(), Cause> {
    match write(attempts, device, count).await {
        Ok(()) => Ok(()),
        Err(error) => {
            // This may fail as well; the next period tries again anyway.
            let _ = device.write(neutral).await;
            Err(error.cause())
        }
    }
}

/// A conversion in up to `attempts` attempts, at least one.
#[twice]
pub(in crate::period) async fn convert<A: AnalogIn>(
    attempts: u8,
    device: &mut A,
    channel: u8,
) -> Result<i32, A::Error> {
    for _ in 1..attempts {
        if let Ok(count) = device.convert(channel).await {
            return Ok(count);
        }
    }
    device.convert(channel).await
}

/// A count; one that is not admitted, because the rod cannot have got there since the last period, is read again, because one frame may be corrupted.
#[twice]
pub(in crate::period) async fn count<P: PositionIn>(
    attempts: u8,
    device: &mut P,
    admits: impl Fn(i32) -> bool,
) -> Result<i32, P::Error> {
    for _ in 1..attempts {
        match device.count().await {
            Ok(count) if admits(count) => return Ok(count),
            Ok(_) | Err(_) => {}
        }
    }
    device.count().await
}

/// Every voltage. Once the inputs are silent the remaining signals are not read, so that the duration of a period stays bounded.
#[twice]
async fn voltages<A: AnalogIn>(
    attempts: u8,
    device: &mut A,
    calibration: &Calibration,
) -> [Option<Result<i32, Cause>>; AnalogSignal::COUNT] {
    let mut voltages = [None; AnalogSignal::COUNT];
    for (voltage, (_, row)) in voltages.iter_mut().zip(calibration.signals()) {
        let Some(row) = row else { continue };
        let converted = convert(attempts, device, row.channel()).await.map_err(|error| error.cause());
        *voltage = Some(converted);
        if converted.is_err() {
            break;
        }
    }
    voltages
}

/// The counter and every voltage.
#[twice]
pub(in crate::period) async fn sample<A: AnalogIn, P: PositionIn, O>(
    devices: &mut Devices<A, P, O>,
    rig: &Rig,
    travelled: &TravelState,
) -> Sample {
    let attempts = rig.limits.attempts;
    let position = count(attempts, &mut devices.position, |count| rig.travel.admits(travelled, count)).await;
    let position = position.map_err(|error| error.cause());
    Sample { position, voltages: voltages(attempts, &mut devices.inputs, &rig.calibration).await }
}

#[cfg(test)]
mod tests {
    use super::super::block_on;
    use super::*;
    use crate::io::FromFn;

    #[twice]
    #[test]
    fn asking_stops_at_the_first_answer_or_after_all_attempts() {
        let asked = |attempts, answers_at| {
            let mut calls = 0;
            let mut device = FromFn::<_, 1>(|_: u8| {
                calls += 1;
                if calls == answers_at { Ok(calls) } else { Err(calls) }
            });
            let answer = block_on(async { convert(attempts, &mut device, 0).await });
            (answer.map_err(|error| error.0), calls)
        };
        assert_eq!(asked(3, 2), (Ok(2), 2));
        assert_eq!(asked(3, 9), (Err(3), 3));
        assert_eq!(asked(0, 9), (Err(1), 1));
    }

    #[twice]
    #[test]
    fn a_command_that_is_not_taken_is_followed_by_neutral() {
        let mut written = std::vec::Vec::new();
        let mut device = FromFn::<_, 1>(|count: i32| {
            written.push(count);
            if count == 7 { Err(()) } else { Ok(()) }
        });
        let done = block_on(async { put_out(3, &mut device, 7, 1).await });
        assert_eq!((done, written), (Err(Cause::Bus), std::vec![7, 7, 7, 1]));
    }
}
