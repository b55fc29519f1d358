//! The whole firmware for a short while, with its machine at the other end of the line.

use firmware::app::press;
use firmware::set_point::SetPoint;
use model_core::number::{Number, PerUnit};
use system_tests::emulator::Processor;
use system_tests::in_the_loop::{Board, Follows, SETTLING};
use system_tests::rig::{Rig, Wanted};

/// Periods for which it follows: enough for the model to start and for every function to be called.
const PERIODS: usize = 200;

/// Stack that the firmware uses from its start to its end, bytes.
pub(crate) fn stack(processor: Processor) -> u64 {
    let per_unit = SetPoint { position: PerUnit::saturated(0.5), velocity: PerUnit::ZERO };
    let machine = press::machine();
    let position_m = 0.5 * machine.get(model_core::machine::Parameter::Stroke);
    let rig = Rig::new(&machine, vec![Wanted { position_m, per_unit }; SETTLING + PERIODS]);
    let mut follows = Follows::on(Board::start(processor, &processor.built("loop", None), &rig.at_rest()));
    rig.run(&mut follows);
    follows.end().stack()
}
