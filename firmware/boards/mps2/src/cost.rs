//! What a step of a model costs on an emulated board: instructions and stack.

use core::hint::black_box;

use model_core::drive::{DriveInput, DriveState, Load};
use model_core::number::{Number, PerUnit};

use cortex_m_stack as stack;

use crate::trial::{DELAY, Moment};
use crate::{Counter, INSTRUCTIONS_PER_COUNT};

/// State of a drive of the trials.
pub type State = DriveState<PerUnit, DELAY>;

/// A model's step under an input.
pub type Step<D> = fn(&D, &mut State, &Moment);

/// Ticks counted at once for the mean.
const BATCH: u32 = 100;

/// What the loop around a step itself costs.
#[inline(never)]
fn nothing<D>(drive: &D, state: &mut State, moment: &Moment) {
    black_box((drive, state, moment));
}

fn count<D>(counter: &mut Counter, work: Step<D>, model: (&D, &mut State), moments: &[Moment]) -> u32 {
    let (drive, state) = model;
    let work = black_box(work);
    counter.counts(|| moments.iter().for_each(|moment| work(drive, state, moment)))
}

/// Mean and worst instructions of a step, the worst to within 40.
pub fn instructions<D>(
    counter: &mut Counter,
    step: Step<D>,
    (drive, mut state): (&D, State),
    moments: impl Iterator<Item = Moment>,
) -> (u32, u32) {
    let mut beside = state;
    let (mut sum, mut ticks, mut worst) = (0, 0, 0);
    let rest = Moment { drive_input: DriveInput::Command(PerUnit::ZERO), load: Load::NONE, oil_temperature: None };
    let mut batch = [rest; BATCH as usize];
    let mut filled = 0;
    for moment in moments {
        batch[filled] = moment;
        filled += 1;
        if filled == batch.len() {
            filled = 0;
            let mut again = state;
            sum += count(counter, step, (drive, &mut state), &batch);
            sum -= count(counter, nothing, (drive, &mut beside), &batch);
            ticks += BATCH;
            for moment in &batch {
                let one = core::slice::from_ref(moment);
                let counts = count(counter, step, (drive, &mut again), one);
                worst = worst.max(counts - count(counter, nothing, (drive, &mut beside), one));
            }
        }
    }
    (sum * INSTRUCTIONS_PER_COUNT / ticks, worst * INSTRUCTIONS_PER_COUNT)
}

/// Stack of the deepest of many steps under the same input, bytes.
pub fn deepest<D>(step: Step<D>, (drive, mut state): (&D, State), moment: &Moment) -> usize {
    (0..BATCH).map(|_| stack::used_by(|| step(drive, &mut state, moment)).1).max().unwrap_or(0)
}
