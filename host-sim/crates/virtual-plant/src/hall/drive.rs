//! How a drive in a hall is drawn: what it is, and what its data sheet and drawing say of it.
//!
//! Sizes are those of catalogues. The sheet is off by what sheets are off by, and is silent on what every installed drive has within its drawing.

use crate::{PlantEffect, Sensors};
use machine_file::data_sheet::{Answers, Edges, Item, derived, toml};
use machine_file::{MachineFile, read_text};
use model_core::machine::{Machine, Parameter as P};
use recording::Signal;
use recording::display_unit::significant;
use recording::seeded_noise::Noise;

use super::installed::{installed, offsets, sensors};

/// A drive and what is known of it.
#[derive(Clone, Debug)]
pub struct Hall {
    /// What its data sheet says.
    pub file: MachineFile,
    /// The machine file as text.
    pub toml: String,
    /// What it is.
    pub truth: Machine<f64>,
    /// What the drive has beyond the parameters of its machine.
    pub effects: Vec<PlantEffect>,
    /// What reads it.
    pub sensors: Sensors,
    /// Measured, beside the command.
    pub signals: Vec<Signal>,
    /// From row to row of a recording, s.
    pub tick_s: f64,
}

/// Bores with the rods that they are made with, mm.
const CYLINDERS: [(f64, [f64; 3]); 5] = [
    (40.0, [22.0, 25.0, 28.0]),
    (50.0, [28.0, 32.0, 36.0]),
    (63.0, [36.0, 40.0, 45.0]),
    (80.0, [45.0, 50.0, 56.0]),
    (100.0, [56.0, 63.0, 70.0]),
];
/// mm.
const STROKES: [f64; 7] = [150.0, 200.0, 250.0, 300.0, 400.0, 500.0, 600.0];
/// Largest force that the load's own swinging takes, as a share of full force: a drive is sized so that it does not tear its oil.
const SWING: f64 = 0.3;
/// m/s.
const SLOWEST: f64 = 0.08;

/// Cylinder, load and oil, true values.
struct Cylinder {
    bore_mm: f64,
    rod_mm: f64,
    stroke_m: f64,
    areas_m2: [f64; 2],
    mass_kg: f64,
    /// As the data sheet says.
    supply_pa: f64,
    modulus_pa: f64,
    hose_m: [f64; 2],
    /// Without load, extending, at a fully open valve.
    m_per_s: f64,
}

impl Cylinder {
    fn draw(dice: &mut Noise) -> Self {
        loop {
            let (bore_mm, rods) = CYLINDERS[dice.below(CYLINDERS.len())];
            let rod_mm = rods[dice.below(rods.len())];
            let stroke_m = 1e-3 * STROKES[dice.below(STROKES.len())];
            let circle = |mm: f64| std::f64::consts::PI / 4.0 * (1e-3 * mm).powi(2);
            let areas_m2 = [circle(bore_mm), circle(bore_mm) - circle(rod_mm)];
            let mass_kg = (dice.decades(20.0, 250.0) * (bore_mm / 40.0).powi(2)).clamp(30.0, 800.0);
            let supply_pa = 1e6 * dice.uniform(6.0, 21.0).round();
            let modulus_pa = dice.uniform(0.9e9, 1.5e9);
            let hose_m = [dice.decades(0.3, 3.0), 1e-3 * (bore_mm * dice.uniform(0.13, 0.2)).round()];
            let wanted = stroke_m * dice.uniform(0.6, 1.4);
            let made =
                Self { bore_mm, rod_mm, stroke_m, areas_m2, mass_kg, supply_pa, modulus_pa, hose_m, m_per_s: wanted };
            let stops_at = SWING * made.force_n() / (mass_kg * made.swings_per_s());
            let m_per_s = wanted.min(stops_at).min(0.7);
            if m_per_s > SLOWEST {
                return Self { m_per_s, ..made };
            }
        }
    }

    fn force_n(&self) -> f64 {
        self.areas_m2[0] * self.supply_pa
    }

    fn hose_m3(&self) -> f64 {
        std::f64::consts::PI / 4.0 * self.hose_m[1].powi(2) * self.hose_m[0]
    }

    /// Angular frequency of the mass on the oil at mid-stroke, 1/s.
    fn swings_per_s(&self) -> f64 {
        let spring = |area: f64| area * area / (0.5 * area * self.stroke_m + self.hose_m3());
        (self.modulus_pa * (spring(self.areas_m2[0]) + spring(self.areas_m2[1])) / self.mass_kg).sqrt()
    }
}

/// The valve as it is.
struct Valve {
    servo: bool,
    hertz: f64,
    damping: f64,
    /// From the centre to fully open at the largest speed, s; none without a limit.
    stroke_s: Option<f64>,
    overdrive: f64,
    overlap: f64,
    delay_s: f64,
}

impl Valve {
    /// Direct-operated, piloted, or a servo valve.
    fn draw(dice: &mut Noise) -> Self {
        let kind = dice.below(3);
        let hertz = match kind {
            0 => dice.decades(12.0, 45.0),
            1 => dice.decades(8.0, 20.0),
            _ => dice.decades(60.0, 120.0),
        };
        let damping = dice.uniform(0.5, 1.0);
        // A step that is so slow as to be just limited takes 2.2/ω.
        let freely_s = 2.2 / (std::f64::consts::TAU * hertz);
        let (stroke_s, overdrive, overlap) = match kind {
            0 => (Some(freely_s * dice.decades(1.0, 3.5)), 30.0, dice.uniform(0.0, 0.15)),
            1 => (Some(freely_s * dice.decades(2.0, 6.0)), dice.uniform(0.0, 0.3), dice.uniform(0.02, 0.15)),
            _ => (None, 0.0, dice.uniform(0.0, 0.02)),
        };
        let delay_s = dice.uniform(0.03, 0.08) * to_90_percent_s(hertz, damping);
        Self { servo: kind == 2, hertz, damping, stroke_s, overdrive, overlap, delay_s }
    }
}

/// Time at which a second-order system first reaches 90 % of a step.
fn to_90_percent_s(hertz: f64, damping: f64) -> f64 {
    const STEP: f64 = 1e-4;
    let (mut turned, mut x, mut v) = (0.0, 0.0, 0.0);
    while x < 0.9 {
        v += STEP * (1.0 - x - 2.0 * damping * v);
        x += STEP * v;
        turned += STEP;
    }
    turned / (std::f64::consts::TAU * hertz)
}

impl Hall {
    /// A drive at random; `None` where its sheet makes none.
    pub fn draw(name: &str, dice: &mut Noise) -> Option<Self> {
        let (cylinder, valve) = (Cylinder::draw(dice), Valve::draw(dice));
        let load_n = dice.happens(0.5).then(|| cylinder.force_n() * dice.uniform(-0.15, 0.1));
        let (answers, edges) = sheet(&cylinder, &valve, load_n, dice);
        let toml = derived(&answers, edges).map(|made| toml(name, &made)).ok()?;
        let file = read_text("machine.toml", &toml).ok()?;
        let truth = truth(&file.machine, &cylinder, &valve, load_n, dice);
        let effects = installed(&truth, valve.servo, cylinder.hose_m3(), dice);
        let sensors = sensors(&truth, dice);
        let offsets = offsets(&sensors, truth.get(P::Stroke), dice);
        let signals = match dice.below(4) {
            0 => vec![Signal::Spool, Signal::Position, Signal::PressureA, Signal::PressureB],
            1 => vec![Signal::Position, Signal::PressureA, Signal::PressureB],
            2 => vec![Signal::Spool, Signal::Position],
            _ => vec![Signal::Position],
        };
        let tick_s = if dice.happens(0.5) { 4e-3 } else { 2e-3 };
        Some(Self { file, toml, truth, effects: [effects, offsets].concat(), sensors, signals, tick_s })
    }

    /// Supply pressure on the piston, N.
    pub fn full_n(&self) -> f64 {
        self.truth.get(P::AreaA) * self.truth.get(P::SupplyPressure)
    }
}

/// A value as a sheet states it: off by at most a share, in three digits.
fn stated(value: f64, within: f64, unit: &str, dice: &mut Noise) -> String {
    format!("{}{unit}", significant(value * (1.0 + dice.uniform(-within, within)), 3))
}

fn sheet(cylinder: &Cylinder, valve: &Valve, load_n: Option<f64>, dice: &mut Noise) -> (Answers, Edges) {
    let (area, ring) = (cylinder.areas_m2[0], cylinder.areas_m2[1]);
    let open = cylinder.m_per_s / (cylinder.supply_pa * area / (area.powi(3) + ring.powi(3))).sqrt();
    // Servo valves are rated at 70 bar over both edges.
    let (drop, edge_pa, edges) = if valve.servo { ("70bar", 35e5, Edges::Both) } else { ("5bar", 5e5, Edges::Edge) };
    let per_minute = 6e4 * open * f64::sqrt(edge_pa);
    let mut answers = Answers::default();
    let mut say = |item: Item, text: String| {
        if let Ok(value) = item.parse(&text) {
            answers.insert(item, value);
        }
    };
    say(Item::Bore, format!("{}mm", cylinder.bore_mm));
    say(Item::Rod, format!("{}mm", cylinder.rod_mm));
    say(Item::Stroke, format!("{:.0}mm", 1e3 * cylinder.stroke_m));
    say(Item::Mass, stated(cylinder.mass_kg, 0.1, "kg", dice));
    say(Item::Supply, format!("{:.0}bar", 1e-5 * cylinder.supply_pa));
    say(Item::RatedFlow, stated(per_minute, 0.08, "l/min", dice));
    say(Item::RatedDrop, drop.to_owned());
    say(Item::RatedSignal, "10V".to_owned());
    if valve.servo {
        say(Item::ValveFrequency, stated(valve.hertz, 0.12, "Hz", dice));
    } else {
        let response_s = to_90_percent_s(valve.hertz, valve.damping) + valve.delay_s;
        say(Item::ValveResponse, stated(1e3 * response_s, 0.12, "ms", dice));
    }
    if let Some(stroke_s) = valve.stroke_s {
        say(Item::ValveStrokeTime, stated(1e3 * stroke_s, 0.12, "ms", dice));
    }
    say(Item::Overlap, stated(1e2 * valve.overlap, 0.12, "%", dice));
    say(Item::HoseLength, stated(cylinder.hose_m[0], 0.2, "m", dice));
    say(Item::HoseDiameter, format!("{:.0}mm", 1e3 * cylinder.hose_m[1]));
    if let Some(load_n) = load_n {
        say(Item::Load, stated(1e-3 * load_n, 0.04, "kN", dice));
    }
    (answers, edges)
}

fn truth(
    stated: &Machine<f64>,
    cylinder: &Cylinder,
    valve: &Valve,
    load_n: Option<f64>,
    dice: &mut Noise,
) -> Machine<f64> {
    let [area_a, area_b] = cylinder.areas_m2;
    let open = cylinder.m_per_s / (cylinder.supply_pa * area_a / (area_a.powi(3) + area_b.powi(3))).sqrt();
    let half = |area: f64| 0.5 * area * cylinder.stroke_m + cylinder.hose_m3();
    let few_n = cylinder.force_n() * dice.uniform(-0.003, 0.003);
    // Oil between guide and rod takes a few per cent of full force at full speed.
    let drag = dice.decades(0.01, 0.05) * cylinder.force_n() / cylinder.m_per_s;
    stated.with(&[
        (P::SupplyPressure, cylinder.supply_pa * (1.0 + dice.uniform(-0.02, 0.02))),
        (P::TankPressure, 1e5 * dice.uniform(1.0, 6.0)),
        (P::ValveGain, 0.1 * (1.0 + dice.uniform(-0.02, 0.02))),
        (P::ValveOffset, dice.uniform(-0.008, 0.008)),
        (P::DeadZone, valve.overlap),
        (P::NaturalFrequency, valve.hertz),
        (P::SpoolDamping, valve.damping),
        (P::SpoolSpeedLimit, valve.stroke_s.map_or(f64::INFINITY, |stroke_s| 1.0 / stroke_s)),
        (P::SpeedOverdrive, valve.overdrive),
        (P::TransportDelay, valve.delay_s),
        (P::FlowCoefficient, open / (1.0 - valve.overlap)),
        (P::VolumeA, half(area_a)),
        (P::VolumeB, half(area_b)),
        (P::BulkModulus, cylinder.modulus_pa),
        (P::MovingMass, cylinder.mass_kg),
        (P::ViscousFriction, drag),
        (P::LoadForce, load_n.unwrap_or(0.0) + few_n),
    ])
}
