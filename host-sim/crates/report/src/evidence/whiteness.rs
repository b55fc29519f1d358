//! Whether the residual of the model after is white: a good model leaves no residual that can be predicted from earlier values.
//!
//! Autocorrelation of the residual, and its correlation with what drives the model, over the lags of 100 rows. Within the 99 %
//! band a correlation is chance: ±2.58/√n for a white residual; with the input by Bartlett's formula, since neighbouring samples
//! of both are correlated.

use diagnosis::Shown;
use identification::compare::{Comparison, Section, SectionFit};
use identification::visible::shows_lag;
use recording::display_unit::significant;
use recording::{Recording, Signal};
use simulation::sensor_fault::Failures;
use simulation::signal::correlation::lagged_product;

/// Lags on each side, rows.
const LAGS: usize = 100;
/// Half width of the 99 % band, in standard deviations.
const BAND: f64 = 2.576;
/// Limit of the largest correlation over all lags, in bands of a single lag: chance stays below it in ninety-nine of a hundred cases (Bonferroni: 201
/// lags, 4.06 standard deviations).
const SURE: f64 = 4.06 / BAND;
/// Most rows of a recording that count: more rows do not change the result.
const MOST_ROWS: usize = 30_000;

/// Correlations of one signal's residual.
#[derive(Clone, Debug, PartialEq)]
pub struct Whiteness {
    /// The signal.
    pub signal: Signal,
    /// Length of a lag, s.
    pub lag_s: f64,
    /// Autocorrelation at lags 1, 2, …
    pub auto: Vec<f64>,
    /// Half width of its 99 % band.
    pub auto_band: f64,
    /// Correlation with the input at lags −n … n: positive where the input comes before the residual. Empty where no input is recorded.
    pub cross: Vec<f64>,
    /// Half width of its 99 % band.
    pub cross_band: f64,
    /// Lags of at most so many rows are told: a longer one is too large a part of the shortest recording.
    pub told: usize,
}

impl Whiteness {
    /// Share of the autocorrelation's lags outside the band; 0.01 for a white residual.
    #[must_use]
    pub fn outside(&self) -> f64 {
        outside(&self.auto, self.auto_band)
    }

    /// Share of the lags of the correlation with the input outside the band.
    #[must_use]
    pub fn cross_outside(&self) -> f64 {
        outside(&self.cross, self.cross_band)
    }

    /// Lag at which the residual autocorrelation is largest, s; `None` where the residual is white.
    #[must_use]
    pub fn lasts(&self) -> Option<f64> {
        let index = largest(self.auto.get(..self.told.min(self.auto.len()))?, self.auto_band)?;
        Some(self.lag_s * (index + 1) as f64)
    }

    /// Lag at which the correlation with the input is largest, s; `None` where it is only chance. Negative where the residual comes before the input.
    #[must_use]
    pub fn follows_input(&self) -> Option<f64> {
        let told = self.told.min(LAGS);
        let index = largest(self.cross.get(LAGS - told..=LAGS + told)?, self.cross_band)?;
        Some(self.lag_s * (index as f64 - told as f64))
    }
}

/// Where a correlation is largest, if it is larger than chance makes it among so many lags.
fn largest(values: &[f64], band: f64) -> Option<usize> {
    let sizes = values.iter().map(|value| value.abs()).enumerate();
    let (index, size) = sizes.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (size > SURE * band).then_some(index)
}

/// The signals whose residual is not white, in words; `None` where all residuals are white.
#[must_use]
pub(crate) fn in_words(signals: &[Whiteness]) -> Option<String> {
    let said: Vec<String> = signals.iter().filter_map(said).collect();
    (!said.is_empty()).then(|| said.join("; "))
}

/// The correlations of one signal's residual, in words.
fn said(of: &Whiteness) -> Option<String> {
    let in_ms = |lag: f64| Some(significant(1e3 * lag.abs(), 2)).filter(|ms| ms != "0");
    let input = of.follows_input().map(|lag| match in_ms(lag) {
        Some(ms) => format!("the input {ms} ms {}", if lag > 0.0 { "earlier" } else { "later" }),
        None => "the input at the same time".to_owned(),
    });
    let itself = of.lasts().and_then(in_ms).map(|ms| format!("itself at a lag of {ms} ms"));
    let with: Vec<String> = input.into_iter().chain(itself).collect();
    (!with.is_empty()).then(|| format!("the residual of {} is correlated with {}", of.signal, with.join(" and with ")))
}

fn outside(values: &[f64], band: f64) -> f64 {
    values.iter().filter(|value| value.abs() > band).count() as f64 / values.len().max(1) as f64
}

/// Every judged signal, of the model `after` or before, over the held-out recordings (the training ones where none is held out). `recordings`
/// are all that are shown, in the same order.
#[must_use]
pub(crate) fn whiteness(all: &[Shown], recordings: &[&Recording], after: bool) -> Vec<Whiteness> {
    let held_out = all.iter().any(|shown| shown.held_out);
    let of: Vec<(&Shown, &Recording)> =
        all.iter().zip(recordings.iter().copied()).filter(|(shown, _)| shown.held_out == held_out).collect();
    let Some((first, _)) = of.first() else { return Vec::new() };
    let lag_s = first.prepared.duration_s() / (first.prepared.time_s.len().max(2) - 1) as f64;
    first
        .prepared
        .channels
        .iter()
        .map(|channel| {
            let series: Vec<(Vec<f64>, Vec<f64>)> =
                of.iter().filter_map(|(shown, recording)| pair(shown, recording, channel.signal, after)).collect();
            correlations(channel.signal, lag_s, &series)
        })
        .collect()
}

/// Residual and input of one recording.
fn pair(shown: &Shown, recording: &Recording, signal: Signal, after: bool) -> Option<(Vec<f64>, Vec<f64>)> {
    let channel = shown.prepared.channels.iter().find(|channel| channel.signal == signal)?;
    let simulated = if after { &shown.after } else { &shown.before }.signal(signal)?;
    let rows = channel.recorded.iter().zip(simulated).zip(&channel.failed).take(MOST_ROWS);
    let missed = rows.map(|((recorded, simulated), failed)| if *failed { 0.0 } else { recorded - simulated }).collect();
    Some((missed, driving(recording).take(MOST_ROWS).collect()))
}

/// What drives the drive, as far upstream as it is recorded: the command where there is one.
fn driving(recording: &Recording) -> impl Iterator<Item = f64> {
    let drives = [Signal::Command, Signal::PumpSpeed, Signal::Spool, Signal::Flow, Signal::Force];
    drives.into_iter().find_map(|drive| recording.signal(drive)).unwrap_or_default().iter().copied()
}

/// Every judged signal of one section of a comparison, over all recordings that have the section; rows where the sensor failed count as zero.
#[must_use]
pub(crate) fn of_section(recordings: &[Recording], found: &[Comparison], section: Section) -> Vec<Whiteness> {
    let here: Vec<(&Recording, &SectionFit, &Comparison)> = recordings
        .iter()
        .zip(found)
        .filter_map(|(recording, found)| {
            Some((recording, found.sections.iter().find(|known| known.section == section)?, found))
        })
        .collect();
    let Some((first, whole, _)) = here.first() else { return Vec::new() };
    let lag_s = first.sample_interval_s();
    // A lag of so many rows is a time only where all rows are as far apart.
    let is_alike = |recording: &Recording| (recording.sample_interval_s() / lag_s - 1.0).abs() < 0.01;
    let of_signal = |signal: Signal| {
        let alike = here.iter().filter(|(recording, ..)| is_alike(recording));
        let series: Vec<(Vec<f64>, Vec<f64>)> = alike
            .filter_map(|(recording, fit, found)| {
                let (recorded, simulated) = (recording.signal(signal)?, fit.trajectory.signal(signal)?);
                let failed = Failures::of(signal, recording.time_s(), recorded).rows();
                let begins = recording.time_s()[0] + found.unsettled_s;
                let rows = recorded.iter().zip(simulated).zip(&failed).zip(recording.time_s()).take(MOST_ROWS);
                let missed = rows.map(
                    |(((recorded, simulated), failed), time)| {
                        if *failed || *time < begins { 0.0 } else { recorded - simulated }
                    },
                );
                Some((missed.collect(), driving(recording).take(MOST_ROWS).collect()))
            })
            .collect();
        correlations(signal, lag_s, &series)
    };
    whole.fits.iter().map(|fit| of_signal(fit.signal)).collect()
}

/// Autocorrelations of residuals and their correlations with the input, over pairs of series.
#[must_use]
#[expect(clippy::type_complexity, reason = "pairs of series")]
pub(crate) fn correlations(signal: Signal, lag_s: f64, series: &[(Vec<f64>, Vec<f64>)]) -> Whiteness {
    let centred = |values: &[f64]| -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        values.iter().map(|value| value - mean).collect()
    };
    let series: Vec<(Vec<f64>, Vec<f64>)> =
        series.iter().map(|(missed, input)| (centred(missed), centred(input))).collect();
    // Σ a(t)·b(t + lag) over all recordings.
    let product = |of: &dyn Fn(&(Vec<f64>, Vec<f64>)) -> f64| series.iter().map(of).fold(0.0, |sum, one| sum + one);
    let rows: usize = series.iter().map(|(missed, _)| missed.len()).sum();
    let missed_square = product(&|(missed, _)| lagged_product(missed, missed, 0));
    let input_square = product(&|(_, input)| lagged_product(input, input, 0));
    let over = |value: f64, by: f64| if by > 0.0 { value / by } else { 0.0 };
    let auto: Vec<f64> = (1..=LAGS)
        .map(|lag| over(product(&|(missed, _)| lagged_product(missed, missed, lag)), missed_square))
        .collect();
    let of_input: Vec<f64> =
        (1..=LAGS).map(|lag| over(product(&|(_, input)| lagged_product(input, input, lag)), input_square)).collect();
    let both = (missed_square * input_square).sqrt();
    let cross = if input_square > 0.0 {
        let before = (1..=LAGS).rev().map(|lag| product(&|(missed, input)| lagged_product(missed, input, lag)));
        let after = (0..=LAGS).map(|lag| product(&|(missed, input)| lagged_product(input, missed, lag)));
        before.chain(after).map(|value| over(value, both)).collect()
    } else {
        Vec::new()
    };
    let alike: f64 = 1.0 + 2.0 * auto.iter().zip(&of_input).map(|(missed, input)| missed * input).sum::<f64>();
    let auto_band = BAND / (rows.max(1) as f64).sqrt();
    let shortest = series.iter().map(|(missed, _)| missed.len()).min().unwrap_or_default();
    let told = (1..=LAGS).take_while(|lag| shows_lag(*lag as f64, 1.0, shortest.saturating_sub(1) as f64)).count();
    Whiteness { told, signal, lag_s, auto, auto_band, cross, cross_band: auto_band * alike.max(1.0).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn white(rows: usize) -> Vec<f64> {
        let mut seed = 7_u64;
        (0..rows)
            .map(|_| {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (seed >> 40) as f64 / f64::from(1_u32 << 24) - 0.5
            })
            .collect()
    }

    #[test]
    fn white_noise_stays_in_the_band_and_what_follows_the_input_does_not() {
        let input: Vec<f64> = (0..5000).map(|row| if row / 400 % 2 == 0 { 3.0 } else { -3.0 }).collect();
        let clean = correlations(Signal::Position, 1e-3, &[(white(5000), input.clone())]);
        assert!(clean.outside() < 0.05 && clean.cross_outside() < 0.1, "{} {}", clean.outside(), clean.cross_outside());
        assert_eq!(in_words(std::slice::from_ref(&clean)), None);
        let late: Vec<f64> =
            white(5000).iter().enumerate().map(|(row, noise)| noise + 0.2 * input[row.saturating_sub(30)]).collect();
        let dirty = correlations(Signal::Position, 1e-3, &[(late, input)]);
        assert!(dirty.outside() > 0.8 && dirty.cross_outside() > 0.5, "{} {}", dirty.outside(), dirty.cross_outside());
        let highest = (0..dirty.cross.len()).max_by(|a, b| dirty.cross[*a].total_cmp(&dirty.cross[*b])).unwrap();
        assert_eq!(highest, LAGS + 30, "the input came 30 rows before");
        assert_eq!(dirty.follows_input(), Some(30e-3));
        let told = in_words(&[clean, dirty]).unwrap();
        assert!(
            told.starts_with(
                "the residual of position is correlated with the input 30 ms earlier and with itself at a lag of "
            ),
            "{told}"
        );
    }

    #[test]
    fn no_input_and_no_residual_are_no_trouble() {
        let nothing = correlations(Signal::Position, 1e-3, &[(vec![0.0; 10], vec![])]);
        assert!(nothing.outside().abs() < 1e-12 && nothing.cross.is_empty());
    }
}
