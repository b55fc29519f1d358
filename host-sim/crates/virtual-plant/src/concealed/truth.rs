//! The truth about drawn cases, as the scorer reads it.

use serde_json::{Map, Value, json};

use super::Channels;
use crate::effect::PlantEffect;
use crate::rig::recorded::SyntheticRecording;

/// What a case conceals, and how it was recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseTruth {
    /// Names; a leading ~ marks an effect outside the vocabulary.
    pub effects: Vec<&'static str>,
    /// The effects' forms and strengths, SI.
    pub forms: Vec<PlantEffect>,
    /// Recorded channels: u, x, p, y, or full.
    pub channels: &'static str,
    /// open, dither or closed.
    pub mode: &'static str,
    /// Noise relative to the usual noise.
    pub noise: f64,
    /// Hz.
    pub rate_hz: f64,
    /// Share of the rows that are spikes.
    pub spikes: f64,
    /// Whether nominal values are inaccurate.
    pub hard: bool,
    /// By recording: what noise, rounding and spikes contribute to each channel, NRMSE as a fraction.
    pub noise_floor: Vec<(String, Vec<(&'static str, f64)>)>,
    /// For each effect: the misfit that a refit without it leaves, relative to the noise.
    pub visible: Vec<f64>,
    /// For several effects: the misfit that a refit without any of them leaves, relative to the noise.
    pub visible_together: Option<f64>,
    /// For each effect that has a plainer form: that form, and the misfit that a refit with it leaves, relative to the noise.
    pub plainer: Vec<Option<(&'static str, f64)>>,
}

/// Below this misfit an answer without the effect, or with its plainer form, also counts as right.
const HIDDEN_BELOW: f64 = 1.25;

impl CaseTruth {
    /// The combinations of effects that are right answers; the whole truth comes first. Also right: without one effect, if the noise hides it; with
    /// its plainer form, if the noise hides the difference; no effect, if the noise hides all of them together.
    #[must_use]
    pub fn accept(&self) -> Vec<Vec<&'static str>> {
        let is_hidden = |left: f64| left < HIDDEN_BELOW;
        let with = |index: usize, instead: Option<&'static str>| {
            let before = self.effects.iter().take(index).copied();
            before.chain(instead).chain(self.effects.iter().skip(index + 1).copied()).collect::<Vec<_>>()
        };
        let mut accept = vec![self.effects.clone()];
        for index in 0..self.effects.len() {
            if let Some(&Some((name, left))) = self.plainer.get(index)
                && is_hidden(left)
            {
                accept.push(with(index, Some(name)));
            }
            if self.visible.get(index).copied().is_some_and(is_hidden) {
                accept.push(with(index, None));
            }
        }
        if self.visible_together.is_some_and(is_hidden) {
            accept.push(Vec::new());
        }
        accept
    }

    fn json(&self) -> Value {
        let floor: Map<String, Value> = self
            .noise_floor
            .iter()
            .map(|(name, channels)| {
                let channels: Map<String, Value> =
                    channels.iter().map(|&(channel, floor)| (channel.to_owned(), json!(floor))).collect();
                (name.clone(), Value::Object(channels))
            })
            .collect();
        let forms: Vec<String> = self.forms.iter().map(|form| format!("{form:?}")).collect();
        json!({
            "effects": self.effects,
            "forms": forms,
            "channels": self.channels,
            "mode": self.mode,
            "noise": self.noise,
            "rate": self.rate_hz,
            "spikes": self.spikes,
            "rough": self.hard,
            "noise_floor_nrmse": floor,
            "visible": self.visible,
            "visible_together": self.visible_together,
            "plainer": self.plainer.iter().map(|plainer| plainer.map(|(name, left)| json!({ name: left }))).collect::<Vec<_>>(),
            "accept": self.accept(),
        })
    }
}

/// The file `truth.json` of these cases.
#[must_use]
pub fn to_json(cases: &[(String, CaseTruth)]) -> String {
    let all: Map<String, Value> = cases.iter().map(|(id, truth)| (id.clone(), truth.json())).collect();
    let mut text = format!("{:#}", Value::Object(all));
    text.push('\n');
    text
}

/// NRMSE of the recording against what ideal sensors would show, by channel.
pub(crate) fn noise_floor(recording: &SyntheticRecording, channels: Channels) -> Vec<(&'static str, f64)> {
    let seen = |of: fn(&crate::sensor::sensors::Reading) -> f64| recording.seen.iter().map(of).collect::<Vec<f64>>();
    let all = [
        ("x", &recording.spool, seen(|reading| reading.spool)),
        ("y", &recording.position_m, seen(|reading| reading.position_m)),
        ("pa", &recording.pressure_a_pa, seen(|reading| reading.pressure_a_pa)),
        ("pb", &recording.pressure_b_pa, seen(|reading| reading.pressure_b_pa)),
    ];
    all.iter()
        .zip(channels.recorded())
        .filter(|&(_, recorded)| recorded)
        .map(|((name, recorded, clean), _)| (*name, nrmse(clean, recorded)))
        .collect()
}

fn nrmse(clean: &[f64], recorded: &[f64]) -> f64 {
    let mean = recorded.iter().sum::<f64>() / recorded.len().max(1) as f64;
    let off: f64 = clean.iter().zip(recorded).map(|(c, r)| (c - r).powi(2)).sum();
    let spread: f64 = recorded.iter().map(|r| (r - mean).powi(2)).sum();
    (off / spread.max(f64::MIN_POSITIVE)).sqrt()
}
