//! One drive in a tool: its variables, its modes and its steps, as FMI 2.0 and 3.0 require them.

use std::path::Path;

use model_core::machine::MachineError;
use model_export::fmu::{Contents, Role, Variable, fingerprint, token};
use simulation::{Inputs, Live, Start};

use crate::{Refusal, Snapshot};

/// Largest deviation of a communication step from whole ticks, in ticks: allows for rounding where tools add up times.
const NEAR: f64 = 1e-6;

/// The state of an instance in the standard's sequence of calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Mode {
    /// It has been created.
    Instantiated,
    /// Its initial state is being determined.
    Initialization,
    /// It is simulated.
    Step,
    /// The simulation has ended.
    Terminated,
}

/// One drive.
#[derive(Debug)]
pub struct Instance {
    contents: Contents,
    mode: Mode,
    inputs: Inputs,
    position_start_m: f64,
    start_s: f64,
    ticks: u64,
    /// The drive. Until the simulation begins, it is at rest with the present inputs; it is created when it is first needed.
    running: Option<Live>,
}

impl Instance {
    /// The drive from an FMU's resources, for a tool that has read this token in the model description.
    ///
    /// # Errors
    /// There is no drive, or the model description belongs to something else.
    pub fn new(resources: &Path, found: &str) -> Result<Self, Refusal> {
        let contents = Contents::read(resources)?;
        let expected = token(&contents);
        if found != expected {
            return Err(Refusal::Token { found: found.to_owned(), expected });
        }
        Ok(Self::of(contents))
    }

    /// A drive before anything was set.
    fn of(contents: Contents) -> Self {
        let inputs = contents.inputs_at_start();
        let position_start_m = Variable::PositionAtStart.start(&contents.machine).unwrap_or(0.0);
        Self { contents, mode: Mode::Instantiated, inputs, position_start_m, start_s: 0.0, ticks: 0, running: None }
    }

    /// Restores the state in which [`Instance::new`] left it.
    pub fn reset(&mut self) {
        *self = Self::of(self.contents.clone());
    }

    /// Sets the time at which the simulation begins, s.
    pub(crate) fn start_at(&mut self, start_s: f64) -> Result<(), Refusal> {
        self.only_in(Mode::Instantiated)?;
        if !start_s.is_finite() {
            return Err(Refusal::StartTime { start_s });
        }
        self.start_s = start_s;
        Ok(())
    }

    /// Begins the initialisation.
    pub(crate) fn enter_initialization(&mut self) -> Result<(), Refusal> {
        self.only_in(Mode::Instantiated)?;
        self.mode = Mode::Initialization;
        Ok(())
    }

    /// Brings the drive to rest, ready for the first step.
    pub(crate) fn exit_initialization(&mut self) -> Result<(), Refusal> {
        self.only_in(Mode::Initialization)?;
        self.at_rest()?;
        self.mode = Mode::Step;
        Ok(())
    }

    /// Ends the simulation.
    pub(crate) fn terminate(&mut self) -> Result<(), Refusal> {
        self.only_in(Mode::Step)?;
        self.mode = Mode::Terminated;
        Ok(())
    }

    /// The simulated time, s.
    pub(crate) fn time_s(&self) -> f64 {
        // Rounded as in a recording with ticks of 1 ms: 0.003 and not 0.0030000000000000001.
        self.start_s + (self.ticks as f64 * self.tick_s() * 1e9).round() / 1e9
    }

    fn tick_s(&self) -> f64 {
        self.contents.settings.tick.seconds()
    }

    /// Values of variables.
    pub(crate) fn get(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Refusal> {
        same_length(references, values)?;
        for (&reference, value) in references.iter().zip(values) {
            *value = self.value(self.variable(reference)?)?;
        }
        Ok(())
    }

    fn value(&mut self, variable: Variable) -> Result<f64, Refusal> {
        match variable.role() {
            Role::Time => Ok(self.time_s()),
            Role::Parameter => Ok(self.position_start_m),
            Role::Input => variable.of_inputs(&self.inputs).ok_or(Refusal::Unknown { reference: variable.reference() }),
            Role::Output => {
                let inputs = self.inputs;
                let value = self.at_rest()?.signal(variable.signal(), &inputs);
                value.ok_or(Refusal::Unknown { reference: variable.reference() })
            }
        }
    }

    /// Sets variables: all of them, or none if one of them cannot be set.
    pub(crate) fn set(&mut self, references: &[u32], values: &[f64]) -> Result<(), Refusal> {
        same_length(references, values)?;
        let (mut inputs, mut position_start_m) = (self.inputs, self.position_start_m);
        for (&reference, &value) in references.iter().zip(values) {
            let variable = self.variable(reference)?;
            let place = match variable.role() {
                Role::Input => variable.in_inputs(&mut inputs),
                Role::Parameter if self.has_begun() => return Err(Refusal::TooLate { variable, mode: self.mode }),
                Role::Parameter => Some(&mut position_start_m),
                Role::Time | Role::Output => None,
            };
            let place = place.ok_or(Refusal::Computed { variable })?;
            if !value.is_finite() {
                return Err(Refusal::NotFinite { variable, value });
            }
            if let Some((min, max)) = variable.range(&self.contents.machine)
                && !(min..=max).contains(&value)
            {
                return Err(Refusal::OutOfRange { variable, value, min, max });
            }
            *place = value;
        }
        (self.inputs, self.position_start_m) = (inputs, position_start_m);
        if !self.has_begun() {
            self.running = None;
        }
        Ok(())
    }

    /// Simulates a step that begins now, with the inputs held. Returns the time at its end, s.
    pub(crate) fn step(&mut self, from_s: f64, step_s: f64) -> Result<f64, Refusal> {
        self.only_in(Mode::Step)?;
        let (tick_s, reached_s) = (self.tick_s(), self.time_s());
        // A time that is not a number fails this comparison.
        let there = (from_s - reached_s).abs() < 0.5 * tick_s;
        if !there {
            return Err(Refusal::NotThere { from_s, reached_s });
        }
        let ticks = (step_s / tick_s).round();
        let whole = (step_s / tick_s - ticks).abs() < NEAR && (1.0..=f64::from(u32::MAX)).contains(&ticks);
        if !whole {
            return Err(Refusal::Step { step_s, tick_s });
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a whole number from 1 to 2^32")]
        let ticks = ticks as u64;
        let inputs = self.inputs;
        let running = self.at_rest()?;
        for _ in 0..ticks {
            running.step(&inputs);
        }
        self.ticks += ticks;
        Ok(self.time_s())
    }

    /// Everything that it remembers.
    pub(crate) fn snapshot(&self) -> Snapshot {
        Snapshot {
            drive: fingerprint(&self.contents),
            mode: self.mode,
            inputs: self.inputs,
            position_start_m: self.position_start_m,
            start_s: self.start_s,
            ticks: self.ticks,
            kept: self.running.as_ref().map(Live::kept),
        }
    }

    /// Returns to a remembered state, earlier or later than the present one.
    pub(crate) fn restore(&mut self, snapshot: &Snapshot) -> Result<(), Refusal> {
        if snapshot.drive != fingerprint(&self.contents) {
            return Err(Refusal::OtherDrive);
        }
        let running = match &snapshot.kept {
            Some(kept) => {
                let mut running = started(&self.contents, &snapshot.inputs, snapshot.position_start_m)?;
                running.restore(kept)?;
                Some(running)
            }
            None => None,
        };
        let Snapshot { mode, inputs, position_start_m, start_s, ticks, .. } = *snapshot;
        *self = Self { contents: self.contents.clone(), mode, inputs, position_start_m, start_s, ticks, running };
        Ok(())
    }

    /// The token at the beginning of a stored state of this FMU.
    pub(crate) fn token(&self) -> String {
        token(&self.contents)
    }

    /// The drive; it is put at rest if it does not run yet.
    fn at_rest(&mut self) -> Result<&mut Live, Refusal> {
        let running = match self.running.take() {
            Some(running) => running,
            None => started(&self.contents, &self.inputs, self.position_start_m)?,
        };
        Ok(self.running.insert(running))
    }

    fn has_begun(&self) -> bool {
        matches!(self.mode, Mode::Step | Mode::Terminated)
    }

    fn variable(&self, reference: u32) -> Result<Variable, Refusal> {
        let mut variables = Variable::of(self.contents.machine.source);
        variables.find(|variable| variable.reference() == reference).ok_or(Refusal::Unknown { reference })
    }

    fn only_in(&self, expected: Mode) -> Result<(), Refusal> {
        if self.mode == expected { Ok(()) } else { Err(Refusal::Mode { mode: self.mode, expected }) }
    }
}

/// The drive at rest after the command was held for a long time.
fn started(contents: &Contents, inputs: &Inputs, position_m: f64) -> Result<Live, MachineError> {
    let start = Start::at_rest(inputs.command_v, None, position_m);
    Live::new(&contents.machine, contents.settings.tick, &start, contents.settings.arithmetic)
}

fn same_length(references: &[u32], values: &[f64]) -> Result<(), Refusal> {
    let (references, values) = (references.len(), values.len());
    if references == values { Ok(()) } else { Err(Refusal::Lengths { references, values }) }
}

#[cfg(test)]
pub(crate) mod tests;
