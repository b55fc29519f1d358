//! What acts on the hydraulics from outside, divided into intervals on which it is smooth.
//!
//! The integrator is stopped at the end of each interval, so that no corner of the spool's path, of
//! the load or of the dead zone lies within one of its steps.

use model_core::machine::{Parameter, Source};

use crate::effect::PlantEffect;
use crate::excitation::input::{Command, LoadLine, PumpCommand};
use crate::physics::{Inputs, Physics};
use crate::plant::{Plant, PlantError, PlantState};
use crate::spool::linear::{Spool, SpoolParameters, SpoolPiece};
use crate::spool::with_effects::{Curve, ShapedSpool};

/// The spool on an interval of time.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::large_enum_variant, reason = "one at a time, copied from a cell; a box could not be copied")]
enum Path {
    Piece(SpoolPiece),
    Curve(Curve),
}

impl Path {
    fn position(&self, time_s: f64) -> f64 {
        match self {
            Self::Piece(piece) => piece.position(time_s),
            Self::Curve(curve) => curve.position(time_s),
        }
    }
}

/// The spool with its history: in closed form, or in small steps where effects act on it.
enum AnySpool {
    Plain(Spool),
    Shaped(Box<ShapedSpool>),
}

impl AnySpool {
    fn command(&mut self, time_s: f64, volts: f64) {
        match self {
            Self::Plain(spool) => spool.command(time_s, volts),
            Self::Shaped(spool) => spool.command(time_s, volts),
        }
    }

    fn position(&mut self, time_s: f64) -> f64 {
        match self {
            Self::Plain(spool) => spool.piece_from(time_s).0.position(time_s),
            Self::Shaped(spool) => spool.position(),
        }
    }
}

/// An interval of time on which everything that acts from outside is smooth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    spool: Path,
    pump: Option<PumpCommand>,
    load: LoadLine,
    /// Which side of the dead zone the spool is on: decided once, so that no rounding at the end
    /// of the interval puts a kink inside it.
    side: i8,
    /// Overlap on the extending and on the retracting side.
    dead_zone: [f64; 2],
}

impl Segment {
    pub(crate) fn inputs(&self, physics: &Physics, time_s: f64) -> Inputs {
        let spool = self.spool.position(time_s);
        let [extending, retracting] = self.dead_zone;
        let spool = match self.side {
            1.. => spool.max(extending),
            0 => spool.clamp(-retracting, extending),
            ..=-1 => spool.min(-retracting),
        };
        physics.inputs(time_s, spool, self.pump, self.load.at(time_s))
    }
}

/// Everything that acts on the hydraulics from outside, in the order of time.
pub(crate) struct Boundary<'a> {
    plant: &'a Plant,
    spool: Option<AnySpool>,
    pump: Option<PumpCommand>,
}

impl<'a> Boundary<'a> {
    /// Nothing has been commanded yet.
    pub(crate) fn new(plant: &'a Plant) -> Self {
        Self { plant, spool: None, pump: None }
    }

    /// Holds a command from `time_s` on. The first command counts as having been held since always.
    pub(crate) fn command(&mut self, tick: usize, time_s: f64, command: Command) -> Result<(), PlantError> {
        let value = match command {
            Command::Valve(volts) => volts,
            Command::Pump(pump) => pump.speed_rev_per_s,
        };
        if !value.is_finite() {
            return Err(PlantError::NotFinite { what: "command", tick, value });
        }
        match (self.plant.physics.source(), command) {
            (Source::Valve, Command::Valve(volts)) => {
                let spool = self.spool.get_or_insert_with(|| spool_at_rest(self.plant, time_s, volts));
                spool.command(time_s, volts);
            }
            (Source::Pump, Command::Pump(pump)) => self.pump = Some(pump),
            (source_of_drive, _) => return Err(PlantError::CommandKind { source_of_drive }),
        }
        Ok(())
    }

    /// What acts from `from_s` on, and until when it is smooth, at most until `to_s`; `scaled` is the state at `from_s`.
    pub(crate) fn segment_from(&mut self, from_s: f64, to_s: f64, scaled: &[f64]) -> (Segment, f64) {
        let (load, load_end_s) = self.plant.load.line_from(from_s);
        let physics = &self.plant.physics;
        let dead_zone = physics.edges().dead_zone;
        let (spool, corner_s) = match &mut self.spool {
            None => (Path::Piece(SpoolPiece::resting_at(0.0)), f64::INFINITY),
            Some(AnySpool::Plain(spool)) => {
                let (piece, corner_s) = spool.piece_from(from_s);
                (Path::Piece(piece), corner_s)
            }
            Some(AnySpool::Shaped(spool)) => {
                let state = physics.state(&physics.inputs(from_s, spool.position(), self.pump, 0.0), scaled);
                let (curve, end_s) = spool.curve_from(from_s, to_s.min(load_end_s), physics.edges(), &state);
                (Path::Curve(curve), end_s)
            }
        };
        let end_s = to_s.min(load_end_s).min(corner_s);
        let (side, end_s) = dead_zone_side(&spool, dead_zone, from_s, end_s);
        (Segment { spool, pump: self.pump, load, side, dead_zone }, end_s)
    }

    pub(crate) fn observe(&mut self, scaled: &[f64], time_s: f64) -> PlantState {
        let physics = &self.plant.physics;
        let offset = self.plant.machine.get(Parameter::ValveOffset);
        let spool = self.spool.as_mut().map_or(offset, |spool| spool.position(time_s));
        let inputs = physics.inputs(time_s, spool, self.pump, 0.0);
        let state = physics.state(&inputs, scaled);
        let (flow_a_m3_per_s, flow_b_m3_per_s) = physics.flows(&inputs, &state);
        PlantState {
            spool,
            flow_a_m3_per_s,
            flow_b_m3_per_s,
            pressure_a_pa: state.pressure_a,
            pressure_b_pa: state.pressure_b,
            position_m: state.position,
            velocity_m_per_s: state.velocity,
            supply_pressure_pa: state.supply,
        }
    }
}

fn spool_at_rest(plant: &Plant, time_s: f64, volts: f64) -> AnySpool {
    let parameters = SpoolParameters::of(&plant.machine);
    let valve = |effect: &PlantEffect| if let PlantEffect::Valve(effect) = effect { Some(*effect) } else { None };
    let shapes: Vec<_> = plant.physics.effects().iter().filter_map(valve).collect();
    if shapes.is_empty() && parameters.is_linear() {
        AnySpool::Plain(Spool::at_rest(parameters, time_s, volts))
    } else {
        AnySpool::Shaped(Box::new(ShapedSpool::at_rest(parameters, &shapes, time_s, volts)))
    }
}

/// The side of the dead zone (+1 beyond it, 0 inside, −1) right after `from_s`, and when the spool
/// leaves that side, at most `to_s`.
///
/// A spool that crosses an edge and turns back between two ticks is not detected here: the error
/// control of the integrator has to handle it.
fn dead_zone_side(spool: &Path, [extending, retracting]: [f64; 2], from_s: f64, to_s: f64) -> (i8, f64) {
    let side = |time_s: f64| {
        let x = spool.position(time_s);
        if x > extending {
            1_i8
        } else if x < -retracting {
            -1
        } else {
            0
        }
    };
    // A point slightly inside the interval, since at its start the spool may be exactly on an edge.
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
    fn the_instant_at_which_the_spool_leaves_its_dead_zone_is_found() {
        let parameters = SpoolParameters {
            gain_per_v: 0.1,
            offset: 0.0,
            rate_per_s: 10.0,
            time_constants_s: [0.0, 0.0],
            delay_s: 0.0,
            swings: None,
            speed_per_s: f64::INFINITY,
        };
        let mut spool = Spool::at_rest(parameters, 0.0, 0.0);
        spool.command(0.0, 5.0);
        let (piece, corner_s) = spool.piece_from(0.0);
        assert!((corner_s - 0.05).abs() < 1e-15);
        let piece = Path::Piece(piece);
        let (side, end_s) = dead_zone_side(&piece, [0.2, 0.2], 0.0, corner_s);
        assert_eq!(side, 0);
        assert!((end_s - 0.02).abs() < 1e-15);
        assert_eq!(dead_zone_side(&piece, [0.2, 0.2], end_s, corner_s), (1, corner_s));
    }
}
