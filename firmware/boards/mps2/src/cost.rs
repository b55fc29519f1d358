//! What a step of a model costs on an emulated board: instructions and stack.

use core::hint::black_box;

use model_core::drive::DriveState;

use cortex_m_stack as stack;

use crate::trial::{DELAY, Moment, Traced};
use crate::{Counter, INSTRUCTIONS_PER_COUNT};

/// State of a drive of the trials.
pub type State<N> = DriveState<N, DELAY>;

/// A model's step under an input.
pub type Step<D, N> = fn(&D, &mut State<N>, &Moment<N>);

/// Ticks counted at once for the mean.
const BATCH: u32 = 100;

/// What the loop around a step itself costs.
#[inline(never)]
fn nothing<D, N: Traced>(drive: &D, state: &mut State<N>, moment: &Moment<N>) {
    black_box((drive, state, moment));
}

fn count<D, N: Traced>(
    counter: &mut Counter,
    work: Step<D, N>,
    model: (&D, &mut State<N>),
    moments: &[Moment<N>],
) -> u32 {
    let (drive, state) = model;
    let work = black_box(work);
    counter.counts(|| moments.iter().for_each(|moment| work(drive, state, moment)))
}

/// Mean and worst instructions of a step, the worst to within 40.
pub fn instructions<D, N: Traced>(
    counter: &mut Counter,
    step: Step<D, N>,
    (drive, mut state): (&D, State<N>),
    moments: impl Iterator<Item = Moment>,
) -> (u32, u32) {
    let mut beside = state;
    let (mut sum, mut ticks, mut worst) = (0, 0, 0);
    let mut batch = [Moment::command(N::ZERO); BATCH as usize];
    let mut filled = 0;
    for moment in moments {
        batch[filled] = N::moment(moment);
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
pub fn deepest<D, N: Traced>(step: Step<D, N>, (drive, mut state): (&D, State<N>), moment: &Moment<N>) -> usize {
    (0..BATCH).map(|_| stack::used_by(|| step(drive, &mut state, moment)).1).max().unwrap_or(0)
}
