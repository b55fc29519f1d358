//! The results of a run on the test bed: the recording that the sensors made, and the truth that belongs to it.

use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use thiserror::Error;

use recording::{Column, Recording, RecordingError, Signal};

use crate::excitation::input::PumpCommand;
use crate::plant::PlantState;
use crate::sensor::sensors::Reading;

/// A recording made by the test bed. Row k holds every signal at time k; the command is held from
/// there to the next row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SyntheticRecording {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Command of a valve drive, V, dither included; empty for a pump drive.
    pub command_v: Vec<f64>,
    /// Speed and direction of a pump drive; empty for a valve drive.
    pub pump: Vec<PumpCommand>,
    /// Spool position of a valve drive as measured, 1; empty for a pump drive.
    pub spool: Vec<f64>,
    /// Rod position as measured, m.
    pub position_m: Vec<f64>,
    /// Pressure in chamber A as measured, Pa.
    pub pressure_a_pa: Vec<f64>,
    /// Pressure in chamber B as measured, Pa.
    pub pressure_b_pa: Vec<f64>,
    /// Supply pressure as measured, Pa; empty where it is not recorded.
    pub supply_pressure_pa: Vec<f64>,
    /// Flow that another consumer takes from the same supply, m³/s; empty where there is none.
    pub other_flow_m3_per_s: Vec<f64>,
    /// Temperature of the oil as measured, °C; empty where it is not recorded.
    pub oil_temperature_c: Vec<f64>,
    /// Set position of a closed-loop run, m; empty otherwise.
    pub reference_m: Vec<f64>,
    /// The true signals, which no real recording contains.
    pub truth: Vec<PlantState>,
    /// What sensors without noise and rounding would have shown.
    pub seen: Vec<Reading>,
}

/// A recording could not be written.
#[derive(Debug, Error)]
#[error("cannot write {}: {cause}", path.display())]
pub struct WriteError {
    /// The path of the file.
    pub path: PathBuf,
    /// The error of the system.
    #[source]
    pub cause: io::Error,
}

impl SyntheticRecording {
    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there are no rows.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// The recording as text in the format of the readers; only what sensors see, no empty columns.
    ///
    /// Every number is the shortest text that reads back as the same `f64`, except the time, which is
    /// rounded to 1 ns. A pump's speed carries the sign of its valve's direction, as in measured
    /// recordings of such drives.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let pump_rpm: Vec<f64> = self.pump.iter().map(signed_rpm).collect();
        let direction: Vec<f64> = self.pump.iter().map(|pump| f64::from(pump.direction)).collect();
        let time_s: Vec<f64> = self.time_s.iter().map(|time_s| (time_s * 1e9).round() / 1e9).collect();
        let mut columns = vec![
            ("time [s]", &time_s),
            ("command [V]", &self.command_v),
            ("pump_speed [rpm]", &pump_rpm),
            ("valve_direction [1]", &direction),
            ("spool [1]", &self.spool),
            ("position [m]", &self.position_m),
            ("pressure_a [Pa]", &self.pressure_a_pa),
            ("pressure_b [Pa]", &self.pressure_b_pa),
            ("supply_pressure [Pa]", &self.supply_pressure_pa),
            ("other_flow [m³/s]", &self.other_flow_m3_per_s),
            ("oil_temperature [°C]", &self.oil_temperature_c),
            ("reference [m]", &self.reference_m),
        ];
        columns.retain(|column| !column.1.is_empty());
        let mut text = columns.iter().map(|column| column.0).collect::<Vec<_>>().join(",");
        text.push('\n');
        for row in 0..self.len() {
            for (index, (_, values)) in columns.iter().enumerate() {
                let separator = if index > 0 { "," } else { "" };
                write!(text, "{separator}{}", values[row]).expect("writing to a String does not fail");
            }
            text.push('\n');
        }
        text
    }

    /// Leaves out the first rows; the times keep their original start.
    pub fn cut_before(&mut self, rows: usize) {
        let rows = rows.min(self.len());
        let channels = [
            &mut self.command_v,
            &mut self.spool,
            &mut self.position_m,
            &mut self.pressure_a_pa,
            &mut self.pressure_b_pa,
            &mut self.supply_pressure_pa,
            &mut self.other_flow_m3_per_s,
            &mut self.oil_temperature_c,
            &mut self.reference_m,
        ];
        for channel in channels {
            channel.drain(..rows.min(channel.len()));
        }
        self.pump.drain(..rows.min(self.pump.len()));
        self.truth.drain(..rows.min(self.truth.len()));
        self.seen.drain(..rows.min(self.seen.len()));
        self.time_s.truncate(self.time_s.len() - rows);
    }

    /// The recording with each channel rounded to what its sensor can resolve, so that its text is short: command 0.1 mV,
    /// spool 1e-6, position 0.1 µm, pressure 1 Pa, flow 1e-9 m³/s, temperature 0.01 K.
    #[must_use]
    pub fn rounded(mut self) -> Self {
        let round = |values: &mut Vec<f64>, per_unit: f64| {
            for value in values {
                // + 0.0 turns -0.0 into 0.0
                *value = (*value * per_unit).round() / per_unit + 0.0;
            }
        };
        round(&mut self.command_v, 1e4);
        round(&mut self.spool, 1e6);
        round(&mut self.position_m, 1e7);
        round(&mut self.reference_m, 1e7);
        round(&mut self.pressure_a_pa, 1.0);
        round(&mut self.pressure_b_pa, 1.0);
        round(&mut self.supply_pressure_pa, 1.0);
        round(&mut self.other_flow_m3_per_s, 1e9);
        round(&mut self.oil_temperature_c, 1e2);
        self
    }

    /// The recording of a valve drive in the form that the other crates use; only what sensors see.
    pub fn to_recording(&self, name: &str) -> Result<Recording, RecordingError> {
        let mut columns = vec![
            Column::si(Signal::Time, self.time_s.clone()),
            Column::si(Signal::Command, self.command_v.clone()),
            Column::si(Signal::Spool, self.spool.clone()),
            Column::si(Signal::Position, self.position_m.clone()),
            Column::si(Signal::PressureA, self.pressure_a_pa.clone()),
            Column::si(Signal::PressureB, self.pressure_b_pa.clone()),
            Column::si(Signal::SupplyPressure, self.supply_pressure_pa.clone()),
            Column::si(Signal::OtherFlow, self.other_flow_m3_per_s.clone()),
            Column::si(Signal::OilTemperature, self.oil_temperature_c.clone()),
        ];
        columns.retain(|column| column.signal == Signal::Time || !column.values.is_empty());
        Recording::new(name, columns)
    }

    /// Writes [`Self::to_csv`] to a temporary file beside `path` and renames it: never half a file.
    pub fn write_csv(&self, path: &Path) -> Result<(), WriteError> {
        let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let write = || -> io::Result<()> {
            let mut file = file_in(folder)?;
            file.write_all(self.to_csv().as_bytes())?;
            file.persist(path)?;
            Ok(())
        };
        write().map_err(|cause| WriteError { path: path.to_owned(), cause })
    }
}

/// A temporary file with the permissions of any new file, so that not only its owner can read it.
fn file_in(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

fn signed_rpm(pump: &PumpCommand) -> f64 {
    let rpm = 60.0 * pump.speed_rev_per_s;
    if pump.direction < 0 { -rpm } else { rpm }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one_row() -> SyntheticRecording {
        SyntheticRecording {
            time_s: vec![0.001 * 3.0],
            command_v: vec![4.0],
            spool: vec![0.25],
            position_m: vec![0.15],
            pressure_a_pa: vec![1.0e6],
            pressure_b_pa: vec![-12.5],
            ..SyntheticRecording::default()
        }
    }

    #[test]
    fn a_file_has_names_with_units_and_full_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.csv");
        one_row().write_csv(&path).unwrap();
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            "time [s],command [V],spool [1],position [m],pressure_a [Pa],pressure_b [Pa]\n0.003,4,0.25,0.15,1000000,-12.5\n"
        );
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_pump_drive_has_speed_and_direction_instead_of_command_and_spool() {
        let pump = PumpCommand { speed_rev_per_s: 20.0, direction: -1 };
        let recording = SyntheticRecording { pump: vec![pump], command_v: vec![], spool: vec![], ..one_row() };
        assert_eq!(
            recording.to_csv(),
            "time [s],pump_speed [rpm],valve_direction [1],position [m],pressure_a [Pa],pressure_b [Pa]\n0.003,-1200,-1,0.15,1000000,-12.5\n"
        );
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let error = one_row().write_csv(Path::new("no-such-folder/r.csv")).unwrap_err();
        assert!(error.to_string().starts_with("cannot write no-such-folder/r.csv: "));
    }
}
