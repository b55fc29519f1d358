//! What the control period needs from the reference model and the controllers.

mod following;
mod reference;

use model_core::number::PerUnit;

use crate::measured::Measured;
use crate::set_point::SetPoint;

pub use following::Following;
pub use reference::{Predicted, Reference};

/// The reference model with the loops around it, such as [`Following`].
///
/// The period limits size and slope of the command once more, as a backstop: a control whose own limits are wider winds up.
pub trait Control {
    /// Model and loops start again, at rest where the machine is: if set point, model and machine agree, the next command is the
    /// neutral one, so the start is bumpless.
    fn start(&mut self, measured: &Measured);

    /// What the model's sensors show now: what the machine's sensors should show, if the model is right.
    fn predicted(&self) -> Predicted;

    /// One period of both loops: returns the command for the machine, in units of 10 V; the model is stepped with its own command.
    fn follow(&mut self, set_point: SetPoint, measured: &Measured) -> PerUnit;

    /// The same with the model driven by `command`, in units of 10 V, in place of its loop: the machine is made to do what the model does.
    fn play(&mut self, command: PerUnit, measured: &Measured) -> PerUnit;

    /// Where the model's rod is now, and how fast: what the machine's is to do while the model is driven by [`Self::play`].
    fn motion(&self) -> SetPoint;

    /// One period in which the machine gets `command`, in units of 10 V, from elsewhere: the model is stepped with it.
    fn accompany(&mut self, command: PerUnit, measured: &Measured);

    /// The command that the valve really gets in this period, in units of 10 V, after every limit: the valve's model is stepped with it.
    fn applied(&mut self, command: PerUnit) {
        let _ = command;
    }

    /// Measured spool less that of the valve's model under the commands that were applied, as a share of full travel; `None` without a
    /// sensor or such a model.
    fn spool_off(&self, measured: &Measured) -> Option<PerUnit> {
        let _ = measured;
        None
    }
}
