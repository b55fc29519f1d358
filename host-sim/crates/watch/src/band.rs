//! The band of a healthy drive: how far its sensors are from its model, from recordings.

use distrs::StudentsT;
use firmware::monitor::MonitoredSignal;
use machine_file::{Band, MachineFile, Spread};
use model_core::machine::Tick;
use recording::{Recording, Signal};
use simulation::tick_for;

use crate::error::WatchError;
use crate::innovation::{Innovations, base, bases};
use crate::watched::{FALSE_ALARMS, Watched};

/// Shortest memory of the average, s. Chosen: several times what the innovation of a servo drive is correlated over, and a part of a working stroke.
const SHORTEST_S: f64 = 0.5;

/// Fewest recordings that show how much a healthy drive differs from one to the next.
pub(crate) const FEWEST: usize = 3;

/// The band that recordings of a healthy drive tell: of each signal the mean square of its innovation, and the time over which it is correlated. The memory
/// is no shorter than any correlation: a shorter one would average nothing.
///
/// A healthy drive is not the same every day, and a model misses more in some motions than in others. So the monitor is run over the recordings themselves:
/// how near the limit each of them comes, as a logarithm, has a mean and a spread, and where the next recording would be beyond the limit more often than
/// once in a hundred (prediction bound of the t distribution), the mean square is raised until it is not.
///
/// # Errors
/// There are less than three recordings, or one of them cannot be compared with the machine.
pub fn healthy(file: &MachineFile, recordings: &[Recording], tick: Option<Tick>) -> Result<Band, WatchError> {
    if recordings.len() < FEWEST {
        return Err(WatchError::FewHealthy { found: recordings.len(), least: FEWEST });
    }
    let of = |recording: &Recording| {
        Innovations::of(file, recording, tick.unwrap_or_else(|| tick_for(recording, &file.machine)))
    };
    let all: Vec<Innovations> = recordings.iter().map(of).collect::<Result<_, _>>()?;
    let bases = bases(file, tick.unwrap_or(Tick::OneMillisecond))?;
    let spread = |signals: &[MonitoredSignal]| {
        // The monitor resolves no less.
        let least = LEAST * base(signals[0], &bases);
        spread(&all, signals).map(|found| Spread { sigma: found.sigma.max(least), ..found })
    };
    let spool = spread(&[MonitoredSignal::Spool]);
    let pressure = spread(&[MonitoredSignal::PressureA, MonitoredSignal::PressureB]);
    let position = spread(&[MonitoredSignal::Position]);
    let memory_s = [spool, pressure, position].iter().flatten().fold(SHORTEST_S, |most, of| most.max(of.correlation_s));
    let mut band = Band { spool, pressure, position, memory_s };
    let mut shares: [Vec<f64>; 3] = Default::default();
    for innovations in &all {
        for seen in Watched::of(&band, innovations, &bases, FALSE_ALARMS)?.signals {
            shares[group(seen.signal)].push(seen.square / seen.limit);
        }
    }
    for (spread, shares) in [&mut band.spool, &mut band.pressure, &mut band.position].into_iter().zip(&shares) {
        if let Some(spread) = spread {
            spread.sigma *= next_below(shares).max(1.0).sqrt();
        }
    }
    Ok(band)
}

/// Which spread of a band a signal has.
const fn group(signal: Signal) -> usize {
    match signal {
        Signal::Spool => 0,
        Signal::PressureA | Signal::PressureB => 1,
        _ => 2,
    }
}

/// What the next of these values is below, ninety-nine times of a hundred: their logarithms are taken to be normal.
fn next_below(values: &[f64]) -> f64 {
    const BELOW: f64 = 0.99;
    let count = values.len() as f64;
    let logarithms = || values.iter().map(|value| libm::log(*value));
    let mean = logarithms().sum::<f64>() / count;
    let variance = logarithms().map(|one| (one - mean).powi(2)).sum::<f64>() / (count - 1.0);
    libm::exp(mean + StudentsT::ppf(BELOW, count - 1.0) * (variance * (1.0 + 1.0 / count)).sqrt())
}

/// Smallest standard deviation over the signal's base that the controller's monitor takes; a little more than its refused one.
const LEAST: f64 = 1.001 / 131_072.0;

/// The spread of one signal, or of two that share it.
fn spread(all: &[Innovations], signals: &[MonitoredSignal]) -> Option<Spread> {
    let is_one = |of: &MonitoredSignal| signals.contains(of);
    let series: Vec<(&[Option<f64>], f64)> = all
        .iter()
        .flat_map(|one| {
            let values = one.values.iter().zip(MonitoredSignal::ALL).filter(|(_, of)| is_one(of));
            values.filter_map(|(values, _)| Some((values.as_deref()?, one.period_s)))
        })
        .collect();
    let known = || series.iter().flat_map(|(values, _)| values.iter().flatten());
    let count = known().count();
    if count == 0 {
        return None;
    }
    let square = known().map(|value| value * value).sum::<f64>() / count as f64;
    Some(Spread { sigma: square.sqrt(), correlation_s: correlation_s(&series) })
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of rows of a recording")]
fn rows(lag_s: f64, period_s: f64) -> usize {
    (lag_s / period_s).round() as usize
}

/// Time in which the correlation of series falls to e⁻¹, s, over all of them; of those that never fall so far, half their longest.
fn correlation_s(series: &[(&[Option<f64>], f64)]) -> f64 {
    let correlated = |lag_s: f64| {
        let (mut product, mut square, mut pairs) = (0.0, 0.0, 0_usize);
        for (values, period_s) in series {
            for (one, other) in values.iter().zip(values.iter().skip(rows(lag_s, *period_s))) {
                let (Some(one), Some(other)) = (one, other) else { continue };
                product += one * other;
                square += 0.5 * (one * one + other * other);
                pairs += 1;
            }
        }
        (pairs > 0 && square > 0.0).then(|| product / square)
    };
    let period_s = series.iter().map(|(_, period_s)| *period_s).fold(f64::INFINITY, f64::min);
    let longest_s = series.iter().map(|(values, period_s)| values.len() as f64 * period_s).fold(0.0, f64::max);
    let mut before = (0.0, 1.0);
    // In steps of a row and then of a twentieth: what is correlated for long is not known to a row.
    let mut lag_s = period_s;
    while lag_s < 0.5 * longest_s {
        let Some(now) = correlated(lag_s) else { break };
        if now < FALLEN {
            // Noise that is new in each row has no correlation time.
            let is_white = before.0 == 0.0 && now < WHITE;
            return if is_white { 0.0 } else { before.0 + (lag_s - before.0) * (before.1 - FALLEN) / (before.1 - now) };
        }
        before = (lag_s, now);
        lag_s = (lag_s + period_s).max(1.05 * lag_s);
    }
    0.5 * longest_s
}

/// e⁻¹
const FALLEN: f64 = 0.367_879_441;
/// Below this from one row to the next, the square of the correlation, which is what counts, is a few per cent.
const WHITE: f64 = 0.2;

#[cfg(test)]
mod tests {
    use recording::seeded_noise::Noise;

    use super::*;

    /// Normal values of variance 1, each correlated with the one before by `rho`.
    fn series(rho: f64, rows: usize, seed: u64) -> Vec<Option<f64>> {
        let mut noise = Noise::new(seed, 0);
        let mut now = noise.gaussian(1.0);
        let step = || {
            now = rho * now + (1.0 - rho * rho).sqrt() * noise.gaussian(1.0);
            Some(now)
        };
        std::iter::repeat_with(step).take(rows).collect()
    }

    #[test]
    fn correlation_times_are_found_within_a_fifth() {
        for tau_rows in [5.0, 50.0, 200.0] {
            let rho = f64::exp(-1.0 / tau_rows);
            let all: Vec<_> = (100..132).map(|seed| series(rho, 20_000, seed)).collect();
            let with_period: Vec<_> = all.iter().map(|values| (values.as_slice(), 1e-3)).collect();
            let found = correlation_s(&with_period);
            assert!((found / (1e-3 * tau_rows) - 1.0).abs() < 0.2, "{tau_rows}: {found}");
        }
        let white = series(0.0, 20_000, 1);
        assert_eq!(correlation_s(&[(&white, 1e-3)]).to_bits(), 0.0_f64.to_bits());
    }

    #[test]
    fn the_next_value_is_below_the_bound_ninety_nine_times_of_a_hundred() {
        for count in [3, 6, 30] {
            let holds = |seed: &u64| {
                let mut noise = Noise::new(*seed, 7);
                let mut drawn = || f64::exp(0.4 * noise.gaussian(1.0) - 0.3);
                let values: Vec<f64> = std::iter::repeat_with(&mut drawn).take(count).collect();
                drawn() < next_below(&values)
            };
            let share = (0..20_000).filter(holds).count() as f64 / 20_000.0;
            assert!((share - 0.99).abs() < 0.003, "{count}: {share}");
        }
    }
}
