//! The truth about drawn cases, as the scorer reads it.

use serde_json::{Map, Value, json};

use super::super::effect::PlantEffect;
use super::super::synthetic::SyntheticRecording;
use super::Channels;

/// What a case conceals, and how it was recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseTruth {
    /// Names; a leading ~ marks what is outside the vocabulary.
    pub effects: Vec<&'static str>,
    /// The effects' forms and strengths, SI.
    pub forms: Vec<PlantEffect>,
    /// Recorded channels: u, x, p, y, or full.
    pub channels: &'static str,
    /// open, dither or closed.
    pub mode: &'static str,
    /// Noise in parts of the usual.
    pub noise: f64,
    /// Hz.
    pub rate_hz: f64,
    /// Share of the rows that are spikes.
    pub spikes: f64,
    /// Whether nominal values are rough.
    pub hard: bool,
    /// By recording: what noise, rounding and spikes make of each channel, NRMSE as a fraction.
    pub noise_floor: Vec<(String, Vec<(&'static str, f64)>)>,
    /// For each effect: what a refit without it leaves, in parts of the noise.
    pub visible: Vec<f64>,
    /// For each effect that has one: its plainer form, and what a refit with that in its place leaves, in parts of the noise.
    pub plainer: Vec<Option<(&'static str, f64)>>,
}

/// Below this an answer without the effect, or with its plainer form, is as good.
const HIDDEN_BELOW: f64 = 1.25;

impl CaseTruth {
    /// The sets of names that are right answers, the whole truth first: without each effect that the noise hides, too, and with a plainer one
    /// where the noise hides what it has more.
    #[must_use]
    pub fn accept(&self) -> Vec<Vec<&'static str>> {
        let mut accept = vec![Vec::new()];
        for (index, effect) in self.effects.iter().enumerate() {
            let is_hidden = |left: &&f64| **left < HIDDEN_BELOW;
            let none = self.visible.get(index).filter(is_hidden).map(|_| None);
            let plainer = self.plainer.get(index).and_then(Option::as_ref).filter(|(_, left)| is_hidden(&left));
            let said: Vec<Option<&str>> =
                [Some(Some(*effect)), plainer.map(|(name, _)| Some(*name)), none].into_iter().flatten().collect();
            accept = said
                .iter()
                .flat_map(|said| {
                    accept.iter().map(|names: &Vec<&'static str>| names.iter().copied().chain(*said).collect())
                })
                .collect();
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

/// NRMSE of what is recorded against what ideal sensors would show, by channel.
pub(super) fn noise_floor(recording: &SyntheticRecording, channels: Channels) -> Vec<(&'static str, f64)> {
    let seen = |of: fn(&super::super::sensors::Reading) -> f64| recording.seen.iter().map(of).collect::<Vec<f64>>();
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
