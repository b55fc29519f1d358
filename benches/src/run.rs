//! A drive stepped over commands at 1 kHz, as the peers' `host_run` does it: every tick's row is written out, in SI. One run at a time,
//! or several drives in SIMD lanes.

use std::array::from_fn;

use model_core::drive::{Drive, DriveInput, Load, PaperDrive};
use model_core::machine::{Machine, Tick};
use model_core::number::{Field, Scalar};
use recording::excitation::signals::Excitation;
use simulation::number::simd::{LANES, Lanes};
use system_tests::simulate::{State, at_rest, command, drive};
use virtual_plant::InitialState;

/// At the end of a tick: spool, position (m), velocity (m/s), pressures in A and B (Pa).
pub type Row = [f64; 5];

/// The tick of every run here.
pub const TICK: Tick = Tick::OneMillisecond;

/// Initial position of the rod, m: mid-stroke of the press.
pub const START_M: f64 = 0.15;

/// Random steps over this number of ticks, V.
#[must_use]
pub fn random_commands(ticks: usize) -> Vec<f32> {
    #[expect(clippy::cast_possible_truncation, reason = "commands in V, as the peers take them")]
    let random: Vec<f32> =
        Excitation::random_steps(1).sample(TICK.seconds()).into_iter().map(|volts| volts as f32).collect();
    random.into_iter().cycle().take(ticks).collect()
}

/// Commands for drives in SIMD lanes, cut from twice as many: each begins a quarter of its own length after the one before.
#[must_use]
pub fn staggered(twice: &[f32]) -> [&[f32]; LANES] {
    let ticks = twice.len() / 2;
    from_fn(|lane| &twice[lane * ticks / LANES..][..ticks])
}

/// A drive and where it starts.
#[derive(Clone, Copy, Debug)]
pub struct Run<N: Scalar> {
    drive: Drive<N>,
    /// `None` where the machine is not the paper's.
    paper: Option<PaperDrive<N>>,
    start: State<N>,
}

impl<N: Scalar<Real = f64>> Run<N> {
    /// A machine at rest under 0 V.
    ///
    /// # Panics
    /// The machine is invalid, or does not fit the format.
    #[must_use]
    pub fn new(machine: &Machine<f64>, initial: &InitialState) -> Self {
        let drive = drive::<N>(machine, TICK);
        Self { start: at_rest(&drive, 0.0, initial), paper: drive.without_effects(), drive }
    }

    /// The paper's model by itself, under commands in V.
    ///
    /// # Panics
    /// The machine has effects, or friction that the paper's model by itself does not take.
    pub fn paper(&self, volts: &[f32], rows: &mut Vec<Row>) {
        let paper = self.paper.as_ref().expect("the drives that are measured are the paper's");
        self.each(volts, rows, |state, command| {
            paper.step(state, command, Load::NONE);
        });
    }

    /// The step of a drive that may have any effect, as in the tool's simulations.
    pub fn any(&self, volts: &[f32], rows: &mut Vec<Row>) {
        self.each(volts, rows, |state, command| {
            self.drive.step(state, DriveInput::Command(command), Load::NONE);
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
                state.valve.spool().to_f64(),
                N::strokes(state.motion.position) * bases.stroke_m,
                state.motion.velocity.to_f64() * bases.velocity_m_per_s,
                state.chambers.a.to_f64() * bases.pressure_pa,
                state.chambers.b.to_f64() * bases.pressure_pa,
            ]
        }));
    }
}

/// The same drive several times, in SIMD lanes.
#[derive(Clone, Copy, Debug)]
pub struct InLanes {
    drive: Drive<Lanes>,
    paper: PaperDrive<Lanes>,
    start: State<Lanes>,
}

impl InLanes {
    /// As [`Run::new`].
    ///
    /// # Panics
    /// As there.
    #[must_use]
    pub fn new(machine: &Machine<f64>, initial: &InitialState) -> Self {
        let drive = drive::<Lanes>(machine, TICK);
        let paper = drive.without_effects().expect("the drives that are measured are the paper's");
        Self { start: at_rest(&drive, 0.0, initial), paper, drive }
    }

    /// The paper's model by itself, each drive under its own commands in V, all of the same length.
    pub fn paper(&self, volts: [&[f32]; LANES], rows: &mut [Vec<Row>; LANES]) {
        self.each(volts, rows, |state, command| {
            self.paper.step(state, command, Load::NONE);
        });
    }

    /// The step of drives that may have any effect.
    pub fn any(&self, volts: [&[f32]; LANES], rows: &mut [Vec<Row>; LANES]) {
        self.each(volts, rows, |state, command| {
            self.drive.step(state, DriveInput::Command(command), Load::NONE);
        });
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "the step is then compiled into its own loop, as in C")]
    fn each(&self, volts: [&[f32]; LANES], rows: &mut [Vec<Row>; LANES], step: impl Fn(&mut State<Lanes>, Lanes)) {
        let bases = *self.drive.bases();
        let mut state = self.start;
        rows.iter_mut().for_each(Vec::clear);
        let mut left = volts.map(<[f32]>::iter);
        while let [Some(a), Some(b), Some(c), Some(d)] = from_fn(|lane| left[lane].next()) {
            let held = [a, b, c, d].map(|&volts| f64::from(volts));
            step(&mut state, Lanes::new(held) / Lanes::constant(bases.command_v));
            let told = [
                state.valve.spool(),
                state.motion.position * Lanes::constant(bases.stroke_m),
                state.motion.velocity * Lanes::constant(bases.velocity_m_per_s),
                state.chambers.a * Lanes::constant(bases.pressure_pa),
                state.chambers.b * Lanes::constant(bases.pressure_pa),
            ]
            .map(Lanes::values);
            for (lane, rows) in rows.iter_mut().enumerate() {
                rows.push(told.map(|signal| signal[lane]));
            }
        }
    }
}
