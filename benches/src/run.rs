//! A drive stepped over commands at 1 kHz, as the peers' `host_run` does it: every tick's row is written out, in SI.

use host_sim::testbed::InitialState;
use model_core::drive::{Drive, Entry, Load};
use model_core::machine::{Machine, Tick};
use model_core::number::Number;
use model_core::paper::PaperDrive;
use system_tests::simulate::{State, at_rest, command, drive};

/// At the end of a tick: slider, position (m), velocity (m/s), pressures in A and B (Pa).
pub type Row = [f64; 5];

/// The tick of every run here.
pub const TICK: Tick = Tick::OneMillisecond;

/// A drive and where it starts.
#[derive(Clone, Copy, Debug)]
pub struct Run<N: Number> {
    drive: Drive<N>,
    paper: PaperDrive<N>,
    start: State<N>,
}

impl<N: Number<Real = f64>> Run<N> {
    /// A machine without effects, at rest under 0 V.
    ///
    /// # Panics
    /// The machine is none, does not fit the format, or has effects.
    #[must_use]
    pub fn new(machine: &Machine<f64>, initial: &InitialState) -> Self {
        let drive = drive::<N>(machine, TICK);
        let paper = drive.without_effects().expect("the drives that are measured are the paper's");
        Self { start: at_rest(&drive, 0.0, initial), paper, drive }
    }

    /// The paper's model by itself, under commands in V.
    pub fn paper(&self, volts: &[f32], rows: &mut Vec<Row>) {
        self.each(volts, rows, |state, command| {
            self.paper.step(state, command, Load::NONE);
        });
    }

    /// The step of a drive that may have any effect, as the simulations of the tool take it.
    pub fn any(&self, volts: &[f32], rows: &mut Vec<Row>) {
        self.each(volts, rows, |state, command| {
            self.drive.step(state, Entry::Command(command), Load::NONE);
        });
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "the step is then compiled into its own loop, as in C")]
    fn each(&self, volts: &[f32], rows: &mut Vec<Row>, step: impl Fn(&mut State<N>, N)) {
        let bases = *self.drive.bases();
        let mut state = self.start;
        rows.clear();
        rows.extend(volts.iter().map(|&volts| {
            step(&mut state, command(f64::from(volts)));
            [
                state.valve.slider().to_f64(),
                N::strokes(state.motion.position) * bases.stroke_m,
                state.motion.velocity.to_f64() * bases.velocity_m_per_s,
                state.chambers.a.to_f64() * bases.pressure_pa,
                state.chambers.b.to_f64() * bases.pressure_pa,
            ]
        }));
    }
}
