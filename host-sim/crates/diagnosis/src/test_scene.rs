//! What is known of the drive that the unit tests use.

use machine_file::LoadSource;
use model_core::machine::Machine;
use recording::Signal;
use simulation::InputPoint;

use crate::catalogue::Scene;

/// What is known of a drive where these signals are measured: driven by its command over most of its stroke, for 5 s.
pub(crate) fn scene<'a>(machine: &'a Machine<f64>, judged: &'a [Signal]) -> Scene<'a> {
    Scene {
        machine,
        input_point: InputPoint::Command,
        load: LoadSource::Constant,
        judged,
        travel_m: (0.05, 0.25),
        duration_s: 5.0,
        is_sparse: false,
        lowest_pa: -1e6,
        held: &[],
        asks_since: false,
        changeable: &[],
    }
}
