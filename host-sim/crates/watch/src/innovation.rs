//! Recorded less simulated, of the signals that the controller monitors.

use firmware::monitor::{MonitoredSignal, SIGNALS};
use identification::compare::{CompareError, simulated_from};
use identification::experiment::Prepared;
use machine_file::{DELAY_LINE, MachineFile};
use model_core::drive::Drive;
use model_core::machine::{Bases, Tick};
use model_core::number::PerUnit;
use recording::{Recording, Signal};
use simulation::{Arithmetic, first_input_point};

use crate::error::WatchError;

/// The column of a monitored signal.
pub(crate) const fn column(of: MonitoredSignal) -> Signal {
    match of {
        MonitoredSignal::Spool => Signal::Spool,
        MonitoredSignal::PressureA => Signal::PressureA,
        MonitoredSignal::PressureB => Signal::PressureB,
        MonitoredSignal::Position => Signal::Position,
    }
}

/// The value of 1 of a monitored signal, SI.
pub(crate) const fn base(of: MonitoredSignal, bases: &Bases) -> f64 {
    match of {
        MonitoredSignal::Spool => 1.0,
        MonitoredSignal::PressureA | MonitoredSignal::PressureB => bases.pressure_pa,
        MonitoredSignal::Position => bases.stroke_m,
    }
}

/// What 1 means of each signal.
pub(crate) fn bases(file: &MachineFile, tick: Tick) -> Result<Bases, WatchError> {
    Ok(*Drive::<PerUnit>::new::<DELAY_LINE>(&file.machine, tick)?.bases())
}

/// The innovations of a recording, row by row.
pub(crate) struct Innovations {
    pub(crate) recording: String,
    pub(crate) time_s: Vec<f64>,
    /// Mean time from row to row, s.
    pub(crate) period_s: f64,
    /// Of each signal, in the order of [`MonitoredSignal::ALL`], SI: `None` where it is not measured or does not follow from the model, and in rows where
    /// its sensor failed or the drive's state is not known yet.
    pub(crate) values: [Option<Vec<Option<f64>>>; SIGNALS],
}

impl Innovations {
    /// Of a recording, simulated as the controller computes it.
    pub(crate) fn of(file: &MachineFile, recording: &Recording, tick: Tick) -> Result<Self, WatchError> {
        let machine = &file.machine;
        let entry = first_input_point(machine.source, recording).map_err(CompareError::from)?;
        let case = Prepared::entered_at(entry, recording, machine, file.load_source, Some(tick))?;
        let simulate = |offset| Arithmetic::Fixed.simulate(machine, &case.stimulus, offset);
        let (simulated, _) =
            simulated_from(&case.stimulus, recording, machine, simulate).map_err(CompareError::from)?;
        let values = MonitoredSignal::ALL.map(|of| {
            let channel = case.channels.iter().find(|channel| channel.signal == column(of))?;
            let simulated = simulated.signal(column(of))?;
            let rows = channel.recorded.iter().zip(simulated).zip(&channel.failed);
            Some(rows.map(|((recorded, simulated), failed)| (!failed).then(|| recorded - simulated)).collect())
        });
        let period_s = case.duration_s() / (case.rows().max(2) - 1) as f64;
        Ok(Self { recording: case.name, time_s: case.time_s, period_s, values })
    }
}
