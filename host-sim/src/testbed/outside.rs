//! What acts on the hydraulics from outside, cut into stretches on which it is smooth.
//!
//! The integrator is stopped at the end of each stretch, so that no corner of the slider's path, of
//! the load or of the dead zone lies within one of its steps.

use model_core::machine::Source;
use model_core::parameter::Parameter;

use super::input::{Command, LoadLine, PumpCommand};
use super::physics::{BASE_STATES, Inputs, Physics};
use super::plant::{Plant, PlantError, PlantState};
use super::slider::{Slider, SliderParameters, SliderPiece};

/// A stretch of time on which everything that acts from outside is smooth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    slider: SliderPiece,
    pump: Option<PumpCommand>,
    load: LoadLine,
    /// Which side of the dead zone the slider is on: decided once, so that no rounding at the edge
    /// of the stretch puts a kink inside it.
    side: i8,
    dead_zone: f64,
}

impl Segment {
    pub(super) fn inputs(&self, physics: &Physics, time_s: f64) -> Inputs {
        let spool = self.slider.position(time_s);
        let spool = match self.side {
            1.. => spool.max(self.dead_zone),
            0 => spool.clamp(-self.dead_zone, self.dead_zone),
            ..=-1 => spool.min(-self.dead_zone),
        };
        physics.inputs(spool, self.pump, self.load.at(time_s))
    }
}

/// Everything that acts on the hydraulics from outside, in the order of time.
pub(super) struct Outside<'a> {
    plant: &'a Plant,
    slider: Option<Slider>,
    pump: Option<PumpCommand>,
}

impl<'a> Outside<'a> {
    /// Nothing has been commanded yet.
    pub(super) fn new(plant: &'a Plant) -> Self {
        Self { plant, slider: None, pump: None }
    }

    /// Holds a command from `time_s` on. The first one has always been there.
    pub(super) fn command(&mut self, tick: usize, time_s: f64, command: Command) -> Result<(), PlantError> {
        let value = match command {
            Command::Valve(volts) => volts,
            Command::Pump(pump) => pump.speed_rev_per_s,
        };
        if !value.is_finite() {
            return Err(PlantError::NotFinite { what: "command", tick, value });
        }
        match (self.plant.physics.source(), command) {
            (Source::Valve, Command::Valve(volts)) => {
                let slider = self
                    .slider
                    .get_or_insert_with(|| Slider::at_rest(SliderParameters::of(&self.plant.machine), time_s, volts));
                slider.command(time_s, volts);
            }
            (Source::Pump, Command::Pump(pump)) => self.pump = Some(pump),
            (source_of_drive, _) => return Err(PlantError::CommandKind { source_of_drive }),
        }
        Ok(())
    }

    /// What is in force from `from_s` on, and until when it is smooth, at most until `to_s`.
    pub(super) fn segment_from(&mut self, from_s: f64, to_s: f64) -> (Segment, f64) {
        let (load, load_end_s) = self.plant.load.line_from(from_s);
        let dead_zone = self.plant.physics.dead_zone();
        let rest = (SliderPiece::resting_at(0.0), f64::INFINITY);
        let (slider, corner_s) = self.slider.as_mut().map_or(rest, |slider| slider.piece_from(from_s));
        let end_s = to_s.min(load_end_s).min(corner_s);
        let (side, end_s) = dead_zone_side(&slider, dead_zone, from_s, end_s);
        (Segment { slider, pump: self.pump, load, side, dead_zone }, end_s)
    }

    pub(super) fn observe(&mut self, scaled: &[f64], time_s: f64) -> PlantState {
        let mut si = [0.0; BASE_STATES];
        for ((si, state), scale) in si.iter_mut().zip(scaled).zip(self.plant.physics.scales()) {
            *si = state * scale;
        }
        let [pressure_a_pa, pressure_b_pa, velocity_m_per_s, position_m] = si;
        let offset = self.plant.machine.get(Parameter::ValveOffset);
        let spool = self.slider.as_mut().map_or(offset, |slider| slider.piece_from(time_s).0.position(time_s));
        let inputs = self.plant.physics.inputs(spool, self.pump, 0.0);
        let (flow_a_m3_per_s, flow_b_m3_per_s) = self.plant.physics.flows(&inputs, pressure_a_pa, pressure_b_pa);
        PlantState {
            spool,
            flow_a_m3_per_s,
            flow_b_m3_per_s,
            pressure_a_pa,
            pressure_b_pa,
            position_m,
            velocity_m_per_s,
        }
    }
}

/// The side of the dead zone (+1 beyond it, 0 inside, −1) right after `from_s`, and when the slider
/// leaves that side, at most `to_s`.
///
/// A slider that touches an edge and turns back between two ticks is not noticed here: the error
/// control of the integrator has to see that one.
fn dead_zone_side(slider: &SliderPiece, dead_zone: f64, from_s: f64, to_s: f64) -> (i8, f64) {
    let side = |time_s: f64| {
        let x = slider.position(time_s);
        if x > dead_zone {
            1_i8
        } else if x < -dead_zone {
            -1
        } else {
            0
        }
    };
    // A hair inside the stretch, since at its start the slider may stand exactly on an edge.
    let inside_s = from_s + (to_s - from_s) * 1e-6;
    let start = side(inside_s);
    if side(to_s) == start {
        return (start, to_s);
    }
    let (mut low_s, mut high_s) = (inside_s, to_s);
    for _ in 0..60 {
        let middle_s = 0.5 * (low_s + high_s);
        if side(middle_s) == start {
            low_s = middle_s;
        } else {
            high_s = middle_s;
        }
    }
    (start, high_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_instant_at_which_the_slider_leaves_its_dead_zone_is_found() {
        let parameters = SliderParameters {
            gain_per_v: 0.1,
            offset: 0.0,
            rate_per_s: 10.0,
            time_constants_s: [0.0, 0.0],
            delay_s: 0.0,
        };
        let mut slider = Slider::at_rest(parameters, 0.0, 0.0);
        slider.command(0.0, 5.0);
        let (piece, corner_s) = slider.piece_from(0.0);
        assert!((corner_s - 0.05).abs() < 1e-15);
        let (side, end_s) = dead_zone_side(&piece, 0.2, 0.0, corner_s);
        assert_eq!(side, 0);
        assert!((end_s - 0.02).abs() < 1e-15);
        assert_eq!(dead_zone_side(&piece, 0.2, end_s, corner_s), (1, corner_s));
    }
}
