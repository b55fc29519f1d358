//! What a recording cannot show because its rows are too far apart.

use model_core::machine::{Machine, Parameter, Source};
use recording::{Recording, Signal};
use simulation::is_sparse;

/// What goes unseen between rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unseen {
    /// Mean interval of the rows, s.
    pub row_s: f64,
    /// Half the rate: nothing faster shows, Hz.
    pub fastest_hz: f64,
    /// The valve's dead time and lags by the machine file, s, where they are shorter than two rows.
    pub valve_s: Option<f64>,
    /// Natural frequency of the mass on the oil column at mid-stroke by the machine file, Hz, where it is higher.
    pub oil_column_hz: Option<f64>,
}

impl Unseen {
    /// Of a recording whose rows are sparse; `None` of any other.
    pub(crate) fn of(recording: &Recording, machine: Option<&Machine<f64>>) -> Option<Self> {
        let time_s = recording.time_s();
        if !is_sparse(time_s) {
            return None;
        }
        let row_s = (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64;
        let fastest_hz = 0.5 / row_s;
        let of_valve = |machine: &Machine<f64>| {
            (machine.source == Source::Valve).then(|| machine.spool_lag_s() + machine.get(Parameter::TransportDelay))
        };
        // Below a measured force neither valve nor oil takes part.
        let upstream = [Signal::Command, Signal::Spool, Signal::PumpSpeed, Signal::Flow];
        let has_oil = |machine: &&Machine<f64>| machine.source != Source::Force;
        let machine = machine.filter(has_oil).filter(|_| upstream.into_iter().any(|signal| recording.has(signal)));
        let valve_s = machine.and_then(of_valve).filter(|lag_s| *lag_s < 2.0 * row_s);
        let oil_column_hz = machine.map(oil_column_hz).filter(|hz| hz.is_finite() && *hz > fastest_hz);
        Some(Self { row_s, fastest_hz, valve_s, oil_column_hz })
    }
}

/// √(E0·(Aa²/Va + Ab²/Vb)/m)/2π, both chambers closed.
fn oil_column_hz(machine: &Machine<f64>) -> f64 {
    let get = |parameter| machine.get(parameter);
    let of_chamber = |area, volume| get(area) * get(area) / get(volume);
    let springs = of_chamber(Parameter::AreaA, Parameter::VolumeA) + of_chamber(Parameter::AreaB, Parameter::VolumeB);
    (get(Parameter::BulkModulus) * springs / get(Parameter::MovingMass)).sqrt() / std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use recording::Column;

    use super::*;

    fn every(row_s: f64, driven_by: Signal) -> Recording {
        let time_s: Vec<f64> = (0..200).map(|row| f64::from(row) * row_s).collect();
        let position = time_s.iter().map(|time| 0.1 + 0.01 * time.sin()).collect();
        let drives = Column::si(driven_by, time_s.clone());
        Recording::new("made", vec![Column::si(Signal::Time, time_s), drives, Column::si(Signal::Position, position)])
            .unwrap()
    }

    #[test]
    fn rows_that_are_far_apart_hide_what_is_faster() {
        let press = test_press::press(&[]);
        assert_eq!(Unseen::of(&every(1e-3, Signal::Command), Some(&press)), None);
        let unseen = Unseen::of(&every(0.05, Signal::Command), Some(&press)).unwrap();
        assert!((unseen.fastest_hz - 10.0).abs() < 1e-6);
        assert!(unseen.valve_s.is_some_and(|lag_s| lag_s < 0.1), "{unseen:?}");
        assert!(unseen.oil_column_hz.is_some_and(|hz| (50.0..500.0).contains(&hz)), "{unseen:?}");
        let alone = Unseen::of(&every(4.0, Signal::Command), None).unwrap();
        assert_eq!((alone.valve_s, alone.oil_column_hz), (None, None));
        let of_axis = Unseen::of(&every(0.05, Signal::Force), Some(&press)).unwrap();
        assert_eq!((of_axis.valve_s, of_axis.oil_column_hz), (None, None));
    }
}
