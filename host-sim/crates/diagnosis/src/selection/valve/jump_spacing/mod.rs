//! The jumps of a spool that no sensor measures, found by what they leave in the position.
//!
//! The difference between a sticking spool and the free one, x, is a saw-tooth over the spool's travel: it runs from −½·L to ½·L and back at a jump,
//! with L = band·(1 − kept), wherever a stroke began. The rod's speed changes by k = |v|/(|x| − dead zone) per opening, so a model without jumps
//! leaves the residual ∫ k·saw(x/L + θ) dt in the position. It is periodic in x, and L is both its period and its height: of a stroke only the phase
//! θ is unknown.
//!
//! A fit by simulation with jumps does not find this. The instant of a jump depends on the valve's gain to a three-hundredth, which the position
//! cannot separate from the flow gain, and every neighbouring value of the gain has other jumps. Here the phase is free instead: the evidence for
//! jumps of a length is the likelihood of the residual under that saw-tooth, averaged over all courses of the phase, relative to that of noise alone.
//!
//! The residual is made white first, by an autoregression of its own: its smooth parts, whichever form error they come from, then have little weight.

mod track;
mod whiten;

use identification::parallel;
use track::{Block, BlockLikelihood, Track, tracks};
use whiten::{usual, whitened};

use identification::experiment::Prepared;
use model_core::machine::{Machine, MachineError};

use crate::selection::decision_rule::{
    HELD_OUT_SPACING, INDEPENDENT_SPACINGS, OTHER_SPACING_FROM, SAME_SPACING_WITHIN, SPACING_STANDS_OUT, SPACING_TOLD,
};

/// Shortest and longest jump that is looked for, of full travel. Shorter ones are hardly visible in a position.
const LENGTHS: (f64, f64) = (0.003, 0.03);
/// Lengths between them, each 2 % longer than the last.
const COUNT: usize = 116;
/// Phases of a stroke.
const PHASES: usize = 24;
/// Heights that are tried, as multiples of the one that belongs to a length: gain and dead zone are not exact.
const HEIGHTS: [f64; 5] = [0.5, 0.7, 0.85, 1.0, 1.2];
/// Speeds of the spool, 1/s, beyond which it no longer jumps: since a jump takes some time, a fast spool glides.
const GLIDES: [f64; 4] = [f64::INFINITY, 1.0, 0.3, 0.1];
/// Length of a block, s: over this time the phase may be taken as constant.
const BLOCK_S: f64 = 0.1;

/// Jumps of a spool that are found in the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JumpSpacing {
    /// How long a jump is, of full travel.
    pub length: f64,
    /// Log-likelihood that the recordings gain by jumps, averaged over all lengths, over none.
    pub evidence: f64,
}

impl JumpSpacing {
    /// The jump spacing in training recordings, from the residuals of a machine that follows them without jumps. `None` where they show no jumps, or
    /// where a recording has no position or is not driven by the command alone.
    pub fn of(machine: &Machine<f64>, training: &[&Prepared]) -> Result<Option<Self>, MachineError> {
        let Some(by_length) = evidence(machine, training)? else { return Ok(None) };
        let lengths = lengths();
        let Some((best, most)) = by_length.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) else {
            return Ok(None);
        };
        let is_far = |length: &f64| libm::log(length / lengths[best]).abs() > OTHER_SPACING_FROM;
        let elsewhere = lengths.iter().zip(&by_length).filter(|(length, _)| is_far(length)).map(|(_, value)| *value);
        let evidence = mean_of_logarithms(&by_length);
        // Form errors give nearly the same evidence at every length; jumps stand out at their own length.
        let stands_out = most - elsewhere.fold(f64::NEG_INFINITY, f64::max) > SPACING_STANDS_OUT;
        Ok((evidence > SPACING_TOLD && stands_out).then_some(Self { length: lengths[best], evidence }))
    }

    /// Whether held-out recordings prefer jumps of this length to none, by more than chance.
    pub fn is_in(&self, machine: &Machine<f64>, held_out: &[&Prepared]) -> Result<bool, MachineError> {
        let Some(by_length) = evidence(machine, held_out)? else { return Ok(false) };
        let is_near = |length: &f64| libm::log(length / self.length).abs() < SAME_SPACING_WITHIN;
        let near: Vec<f64> =
            lengths().iter().zip(by_length).filter(|(length, _)| is_near(length)).map(|(_, value)| value).collect();
        let most = near.into_iter().fold(f64::NEG_INFINITY, f64::max);
        Ok(most - libm::log(INDEPENDENT_SPACINGS) > HELD_OUT_SPACING)
    }
}

/// The lengths that are looked for.
fn lengths() -> Vec<f64> {
    let (shortest, longest) = LENGTHS;
    let share = |index: usize| index as f64 / (COUNT - 1) as f64;
    (0..COUNT).map(|index| shortest * libm::pow(longest / shortest, share(index))).collect()
}

/// The logarithm of the mean of numbers of which the logarithms are given.
fn mean_of_logarithms(values: &[f64]) -> f64 {
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most + libm::log(values.iter().map(|value| libm::exp(value - most)).sum::<f64>() / values.len() as f64)
}

/// Log-likelihood that recordings gain by jumps of each length. `None` where they cannot show it.
fn evidence(machine: &Machine<f64>, cases: &[&Prepared]) -> Result<Option<Vec<f64>>, MachineError> {
    let Some(mut tracks) = tracks(machine, cases)? else { return Ok(None) };
    let Some(memory) = whitened(&mut tracks) else { return Ok(None) };
    let squares: Vec<f64> = tracks.iter().flat_map(Track::squares_while_moving).collect();
    let variance = usual(squares);
    if variance <= 0.0 {
        return Ok(None);
    }
    let of_length = |length: &f64| {
        let chains: Vec<Vec<BlockLikelihood>> =
            tracks.iter().map(|track| track.likelihoods(*length, &memory, variance)).collect();
        let under = |(height, glides)| chains.iter().map(|chain| along(chain, *length, height, glides)).sum();
        let models = (0..HEIGHTS.len()).flat_map(|height| GLIDES.iter().map(move |glides| (height, *glides)));
        mean_of_logarithms(&models.map(under).collect::<Vec<f64>>())
    };
    Ok(Some(parallel::each(&lengths(), of_length)))
}

/// Log-likelihood that a recording gains by jumps of a length and a height, averaged over all courses of their phase.
///
/// At a turn and after a rest the phase is unknown. Along a stroke it drifts at random: a jump ends where the free spool is at the end of a row, so
/// that it is longer the faster the free spool moves.
fn along(chain: &[BlockLikelihood<'_>], length: f64, height: usize, glides: f64) -> f64 {
    /// Variance that the phase gains, in turns², per jump length of spool travel.
    const STRAYS: f64 = 0.002;
    /// What a change of speed adds to a jump, s.
    const LATE_S: f64 = 1e-3;
    let open = [1.0 / PHASES as f64; PHASES];
    let mut phases = open;
    let mut last: Option<&Block> = None;
    let mut sum = 0.0;
    for BlockLikelihood { block, gains } in chain.iter().filter(|likelihoods| likelihoods.block.speed < glides) {
        phases = match last {
            Some(last) if last.end == block.first && last.rises == block.rises => {
                let travel = 0.5 * (last.travel + block.travel) / length;
                let late = LATE_S * (block.speed - last.speed) / length;
                strayed(&phases, STRAYS * travel + late * late)
            }
            _ => open,
        };
        let gains = &gains[height];
        let most = gains.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for (phase, gain) in phases.iter_mut().zip(gains) {
            *phase *= libm::exp(gain - most);
        }
        let total: f64 = phases.iter().sum();
        for phase in &mut phases {
            *phase /= total;
        }
        sum += most + libm::log(total);
        last = Some(block);
    }
    sum
}

/// Distribution of the phase after a random drift with this variance, in turns²: convolved with a normal distribution that is wrapped around the
/// circle.
fn strayed(phases: &[f64; PHASES], variance: f64) -> [f64; PHASES] {
    /// Least probability of a phase, so that none becomes so small that it cannot recover.
    const LEAST: f64 = 1e-12;
    let mut kernel: [f64; PHASES] = std::array::from_fn(|step| {
        let turns = step as f64 / PHASES as f64;
        (-2..=2).map(|whole| libm::exp(-0.5 * (turns + f64::from(whole)).powi(2) / variance.max(1e-6))).sum()
    });
    let total: f64 = kernel.iter().sum();
    for share in &mut kernel {
        *share /= total;
    }
    std::array::from_fn(|to| {
        let from = |from: usize| phases[from] * kernel[(to + PHASES - from) % PHASES];
        (0..PHASES).map(from).sum::<f64>().max(LEAST)
    })
}

#[cfg(test)]
mod tests;
