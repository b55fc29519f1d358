//! A tick of a drive whose chambers may cavitate.
//!
//! A tick of the model starts with each chamber full or empty. An empty one has no stiffness: its pressure stays, whatever flows. Only the
//! tick's end shows whether a chamber emptied or filled within it. Such a tick is taken back and repeated with a share of the stiffness,
//! chosen so that the chamber pushes the rod as much as in reality: its pressure moves over a part τ of the tick only. If it falls to the
//! floor after τ, its mean fall is (1 − τ/2)·τ of the whole; twice that, the share, is 1 − (1 − τ)². If it rises in the last τ, the
//! mean is τ²/2, and the share τ². The chamber takes in the resulting flow by the law above, with its whole stiffness.

use super::baked::KnowsLinks;
use super::{Drive, DriveInput, DriveState, Interfaces, Load};
use crate::chambers::Chambers;
use crate::chambers::cavitation::Cavitation;
use crate::effects::AnyEffect;
use crate::mechanics::Mechanics;
use crate::number::{Mask, Number};
use crate::ports::Flows;

impl<N: Number> Drive<N> {
    /// A tick of a drive whose chambers may cavitate.
    #[cold]
    #[inline(never)]
    pub(crate) fn step_cavitating<const DELAY: usize>(
        &self,
        cavitation: &Cavitation<N>,
        state: &mut DriveState<N, DELAY>,
        drive_input: DriveInput<N>,
        load: Load<N>,
    ) -> Interfaces<N> {
        self.cavitating::<AnyEffect, DELAY>(cavitation, state, drive_input, |links, state, drive_input| {
            self.step_links(links, state, drive_input, load)
        })
    }

    /// The same with a step of the links.
    #[inline(always)]
    pub(super) fn cavitating<V: KnowsLinks<N>, const DELAY: usize>(
        &self,
        cavitation: &Cavitation<N>,
        state: &mut DriveState<N, DELAY>,
        drive_input: DriveInput<N>,
        step: impl Fn((&Chambers<N>, &Mechanics<N>), &mut DriveState<N, DELAY>, DriveInput<N>) -> Interfaces<N>,
    ) -> Interfaces<N> {
        let &mut DriveState { chambers, rest, voids, motion, supply, poppets, warmth, .. } = state;
        let sensed = self.sensors.follows().then_some(state.sensed);
        let mut full = Cavitation::<N>::full(&voids);
        let (mut drive_input, mut again) = (drive_input, true);
        loop {
            let left = full.as_ref().map(|full| {
                let share = cavitation.unsprung.share(full);
                (self.chambers.softened(*full), self.mechanics.heavier(share), share)
            });
            let links = left.as_ref().map(|(chambers, mechanics, _)| (chambers, mechanics));
            let mut seen = step(links.unwrap_or((&self.chambers, &self.mechanics)), state, drive_input);
            if let DriveInput::Force { .. } = drive_input {
                return seen;
            }
            seen.forces.around.sprung = left.as_ref().map_or(N::ONE, |&(_, _, share)| share);
            (state.chambers, state.rest) = (chambers, rest);
            let taken = (seen.flows, seen.velocity, seen.midway, seen.position);
            let crossing =
                self.chambers.take::<V>(cavitation, &mut state.chambers, &mut state.rest, &mut state.voids, taken);
            if !again || !(crossing.a.crosses | crossing.b.crosses).any() {
                return seen;
            }
            again = false;
            full = Some(Flows { a: crossing.a.share, b: crossing.b.share });
            // The valve has done its tick already; the repeated tick takes the spool that resulted.
            drive_input = seen.spool.map_or(drive_input, DriveInput::Spool);
            (state.chambers, state.rest, state.voids) = (chambers, rest, voids);
            (state.motion, state.supply, state.poppets, state.warmth) = (motion, supply, poppets, warmth);
            state.sensed = sensed.unwrap_or(state.sensed);
        }
    }
}
