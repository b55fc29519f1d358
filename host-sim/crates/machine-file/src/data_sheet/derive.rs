//! Derives the parameters of a machine file from the answers.

use std::f64::consts::PI;

use recording::Dimension;
use recording::display_unit::significant;

use super::item::{Answers, Item};
use super::quantity::Quantity;
use super::spool::{DAMPING, DAMPING_WITHIN, DEAD_TIME, Spool};
use super::tolerances::{Size, ZERO_LAP};

/// Over what the rated pressure drop of a valve stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Edges {
    /// One edge, supply to port or port to tank
    #[default]
    Edge,
    /// Both edges in series: half of it is over each
    Both,
}

/// Where a value comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Given by the user.
    Given,
    /// Computed by a formula from given values.
    Derived,
    /// Assumed, because nobody gave it.
    Assumed,
}

impl Origin {
    /// The word at the beginning of the value's comment.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Origin::Given => "given",
            Origin::Derived => "derived",
            Origin::Assumed => "assumed",
        }
    }
}

/// One line of the machine file.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The table it stands in.
    pub table: &'static str,
    /// Its key, with the unit.
    pub key: &'static str,
    /// Its value, SI; several values make an array.
    pub values: Vec<f64>,
    /// Where it comes from.
    pub origin: Origin,
    /// From which values, by which formula, or for what reason.
    pub why: String,
}

/// A standard deviation of `[fit.sigma]`, or a largest magnitude of `[fit.tolerance]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Sigma {
    /// The full key of the parameter.
    pub key: &'static str,
    /// In the parameter's unit.
    pub value: f64,
    /// The reason for this size.
    pub why: String,
}

/// Everything that is written to the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Derived {
    /// Values in the order of the file.
    pub entries: Vec<Entry>,
    /// Standard deviations.
    pub sigma: Vec<Sigma>,
    /// Largest magnitudes of what every installed drive has within its drawing.
    pub tolerance: Vec<Sigma>,
}

/// Why the answers do not describe a drive.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SheetError {
    /// Values that the drive needs are missing.
    #[error("missing {}; expected these flags, or a terminal to be asked on", flags(.0))]
    Missing(Vec<Item>),
    /// A value of a valve is given together with a pump.
    #[error(
        "--{flag} beside --pump-displacement; expected a valve or a pump that feeds the cylinder directly, not both"
    )]
    ValveBesidePump {
        /// The valve's flag.
        flag: &'static str,
    },
    /// The rod does not fit into the bore.
    #[error("--rod {rod} in --bore {bore}; expected a rod thinner than the piston")]
    RodTooThick {
        /// The rod's diameter.
        rod: String,
        /// The piston's.
        bore: String,
    },
    /// Only one of the two values of a hose is given.
    #[error("--{given} without --{absent}; expected both or neither")]
    HalfAHose {
        /// The flag that is given.
        given: &'static str,
        /// The flag that is missing.
        absent: &'static str,
    },
}

impl SheetError {
    /// The flag that the error is about, without dashes, if that flag was given.
    #[must_use]
    pub fn flag(&self) -> Option<&str> {
        match self {
            SheetError::Missing(_) => None,
            SheetError::ValveBesidePump { flag } => Some(flag),
            SheetError::RodTooThick { .. } => Some("rod"),
            SheetError::HalfAHose { given, .. } => Some(given),
        }
    }
}

fn flags(items: &[Item]) -> String {
    let each = items.iter().map(|item| {
        let question = item.question();
        format!("--{} {}", question.flag, question.example)
    });
    each.collect::<Vec<_>>().join(", ")
}

/// Dead volume as a share of the chamber at mid-stroke, where none is given.
const DEAD_VOLUME: f64 = 0.05;
/// Friction at full speed as a share of the force at supply pressure, where none is given.
const FRICTION: f64 = 0.1;
/// Standard deviation of the supply pressure, as a share of it.
const SUPPLY_WITHIN: f64 = 0.01;
/// Pressure in the tank line, Pa gauge, where none is given.
const TANK_PA: f64 = 2e5;
/// Standard deviation of the load, as a share of the full force: weights that nobody counts.
const LOAD_WITHIN: f64 = 0.01;
/// Standard deviation of a given dead volume, as a share of it.
const DEAD_VOLUME_WITHIN: f64 = 0.2;
/// Pump speed that is taken as full speed, rev/s.
const PUMP_REV_PER_S: f64 = 25.0;
/// Bulk modulus, Pa, where none is given: oil with the usual small amount of air, in a real cylinder and not in a laboratory.
const BULK_MODULUS_PA: f64 = 1.2e9;

/// Derives every value that a machine file needs.
///
/// # Errors
/// Where a value is missing, or values contradict each other.
pub fn derived(answers: &Answers, edges: Edges) -> Result<Derived, SheetError> {
    let sheet = Sheet { answers, missing: answers.missing() };
    if answers.is_pump()
        && let Some(item) = Item::ALL.iter().find(|item| !item.belongs(true) && answers.get(**item).is_some())
    {
        return Err(SheetError::ValveBesidePump { flag: item.question().flag });
    }
    if !sheet.missing.is_empty() {
        return Err(SheetError::Missing(sheet.missing));
    }
    let (bore, rod) = (sheet.needed(Item::Bore)?, sheet.needed(Item::Rod)?);
    if rod.si >= bore.si {
        return Err(SheetError::RodTooThick { rod: rod.to_string(), bore: bore.to_string() });
    }
    let mut made = Derived::default();
    let supply = sheet.needed(Item::Supply)?;
    made.given("supply", "pressure_pa", supply, supply.si);
    made.sigma("supply.pressure_pa", SUPPLY_WITHIN * supply.si, "given: a relief valve is set to within 1 %");
    made.push(
        "supply",
        "tank_pressure_pa",
        vec![TANK_PA],
        Origin::Assumed,
        "filter and pipe to the tank, gauge".to_owned(),
    );
    made.sigma("supply.tank_pressure_pa", TANK_PA, "assumed: half to twice as much, never below 0");
    if let Some(limit) = answers.get(Item::FlowLimit) {
        made.given("supply", "flow_limit_m3_per_s", limit, limit.si);
    }
    let area_a = PI / 4.0 * bore.si * bore.si;
    let area_b = area_a - PI / 4.0 * rod.si * rod.si;
    let full =
        if answers.is_pump() { made.pump(&sheet, area_a)? } else { made.valve(&sheet, edges, (area_a, area_b))? };
    let dead_m3 = made.cylinder(&sheet, (area_a, area_b), &full)?;
    let load = answers.get(Item::Load);
    let uncounted = LOAD_WITHIN * supply.si * area_a;
    if let Some(load) = load {
        made.given("load", "force_n", load, load.si);
        made.sigma(
            "load.force_n",
            libm::hypot(0.05 * load.si.abs(), uncounted),
            "given: within 5 %, and 1 % of full force",
        );
    } else {
        made.push("load", "force_n", vec![0.0], Origin::Assumed, "no load was named".to_owned());
        made.sigma("load.force_n", uncounted, "assumed: within 1 % of full force");
    }
    let overlap = answers.get(Item::Overlap).map_or(0.0, |overlap| overlap.si);
    let rated = answers.get(Item::SpoolAtRated).map_or(1.0, |reading| reading.si);
    let flow_m3_per_s = full.m_per_s * area_a;
    let size = Size {
        pump: answers.is_pump(),
        supply_pa: supply.si,
        force_n: supply.si * area_a,
        flow_m3_per_s,
        rated,
        overlap,
        dead_m3,
    };
    made.shapes(&size);
    made.tolerance = size.tolerances();
    Ok(made)
}

/// The answers, with none missing.
struct Sheet<'a> {
    answers: &'a Answers,
    missing: Vec<Item>,
}

impl<'a> Sheet<'a> {
    fn needed(&self, item: Item) -> Result<&'a Quantity, SheetError> {
        self.answers.get(item).ok_or_else(|| SheetError::Missing(vec![item]))
    }
}

/// The full speed, m/s, and the words that say how it was found.
struct FullSpeed {
    m_per_s: f64,
    how: &'static str,
}

impl Derived {
    fn push(&mut self, table: &'static str, key: &'static str, values: Vec<f64>, origin: Origin, why: String) {
        self.entries.push(Entry { table, key, values, origin, why });
    }

    fn given(&mut self, table: &'static str, key: &'static str, quantity: &Quantity, si: f64) {
        self.push(table, key, vec![si], Origin::Given, quantity.to_string());
    }

    /// A value that is known exactly gets no standard deviation.
    fn sigma(&mut self, key: &'static str, value: f64, why: &str) {
        if value > 0.0 {
            self.sigma.push(Sigma { key, value, why: why.to_owned() });
        }
    }

    fn valve(&mut self, sheet: &Sheet<'_>, edges: Edges, areas: (f64, f64)) -> Result<FullSpeed, SheetError> {
        let given = |item| sheet.answers.get(item);
        let signal = sheet.needed(Item::RatedSignal)?;
        let reading = given(Item::SpoolAtRated);
        let rated = reading.map_or(1.0, |reading| reading.si);
        let shown = reading.map_or_else(|| "100 % assumed".to_owned(), ToString::to_string);
        let gain = rated / signal.si;
        // A model whose command is in mA does not notice that a recording is in V.
        let counts =
            if signal.unit.dimension() == Dimension::Current { "; commands have to be recorded in mA" } else { "" };
        let origin = format!("x_N/U_N: {shown} at {signal}{counts}");
        self.push("valve", "gain_per_v", vec![gain], Origin::Derived, origin);
        match reading {
            Some(_) => self.sigma("valve.gain_per_v", 0.02 * gain, "given: within 2 %"),
            None => self.sigma("valve.gain_per_v", 0.1 * gain, "assumed: within 10 %"),
        }
        self.push("valve", "offset", vec![0.0], Origin::Assumed, "the neutral is adjusted".to_owned());
        self.sigma("valve.offset", 0.05 * rated, "assumed: a twentieth of the rated travel");

        let overlap = given(Item::Overlap);
        let dead_zone = overlap.map_or(0.0, |overlap| overlap.si) * rated;
        if let Some(overlap) = overlap {
            let why = format!("overlap {overlap} of the travel at the rated signal");
            self.push("valve", "dead_zone", vec![dead_zone], Origin::Derived, why);
            self.sigma("valve.dead_zone", (0.1 * dead_zone).max(0.01 * rated), "given: within 10 %, or 1 % of travel");
        } else {
            self.push(
                "valve",
                "dead_zone",
                vec![0.0],
                Origin::Assumed,
                "zero lap, for no overlap was named".to_owned(),
            );
            self.sigma("valve.dead_zone", 0.03 * rated, "assumed: 3 % of travel");
        }
        if let Some(time) = given(Item::ValveStrokeTime) {
            let why = format!("x_N over {time} of travel at the largest speed");
            self.push("valve", "speed_limit_per_s", vec![rated / time.si], Origin::Derived, why);
            self.sigma("valve.speed_limit_per_s", 0.15 * rated / time.si, "given: within 15 %");
            let why = "0 where a pilot stage opens no further, many where the speed itself is limited";
            self.push("valve", "speed_overdrive", vec![0.5], Origin::Assumed, why.to_owned());
            self.sigma("valve.speed_overdrive", 2.0, "assumed: a fit tries both");
        }
        self.spool(sheet);

        let (flow, drop) = (sheet.needed(Item::RatedFlow)?, sheet.needed(Item::RatedDrop)?);
        let (edge_pa, over) = match edges {
            Edges::Edge => (drop.si, "one edge"),
            Edges::Both => (0.5 * drop.si, "both edges, half over each"),
        };
        let coefficient = flow.si / (edge_pa.sqrt() * (rated - dead_zone));
        let why = format!("K_Q = Q_N/(√Δp_N·(x_N − dead zone)): {flow} at {drop} over {over}");
        self.push("valve", "flow_coefficient", vec![coefficient], Origin::Derived, why);
        let (within, why) = if dead_zone < ZERO_LAP * rated {
            (0.4, "given: data sheets allow 10 %; about the null of such an overlap the gain is half to twice as much")
        } else {
            (0.1, "given: data sheets allow 10 %")
        };
        self.sigma("valve.flow_coefficient", within * coefficient, why);

        let (a, b) = areas;
        let supply = sheet.needed(Item::Supply)?.si;
        let free = coefficient * (rated - dead_zone) * (supply * a / (a.powi(3) + b.powi(3))).sqrt();
        let limit = given(Item::FlowLimit).map_or(f64::INFINITY, |limit| limit.si / a);
        Ok(FullSpeed { m_per_s: free.min(limit), how: "extending without load" })
    }

    /// The spool as a second-order system, and its dead time.
    fn spool(&mut self, sheet: &Sheet<'_>) {
        let given = |item| sheet.answers.get(item);
        let Some(spool) = Spool::of(given) else { return };
        let table = "valve";
        self.push(table, "natural_frequency_hz", vec![spool.hertz], spool.origin, spool.why);
        self.sigma("valve.natural_frequency_hz", spool.within * spool.hertz, spool.known);
        if let Some(damping) = given(Item::ValveDamping) {
            self.given(table, "damping", damping, damping.si);
            self.sigma("valve.damping", 0.15 * damping.si, "given: within 15 %");
        } else {
            self.push(table, "damping", vec![DAMPING], Origin::Assumed, "hardly overshoots".to_owned());
            self.sigma("valve.damping", DAMPING_WITHIN * DAMPING, "assumed: half to twice as much");
        }
        let why = format!("a twentieth of {} ms to 90 %", significant(1e3 * spool.response_s, 3));
        self.push(table, "transport_delay_s", vec![DEAD_TIME * spool.response_s], Origin::Assumed, why);
        self.sigma("valve.transport_delay_s", 0.5 * DEAD_TIME * spool.response_s, "assumed: within a half");
    }

    /// How friction of seals and the gain about null act, whose amounts are tolerances.
    fn shapes(&mut self, size: &Size) {
        let mut roughly = |table, key, whole: &'static str, value: f64, why: &str| {
            self.push(table, key, vec![value], Origin::Assumed, why.to_owned());
            self.sigma(whole, value, "assumed: half to twice as much");
        };
        if size.overlap < ZERO_LAP && !size.pump {
            let (whole, why) = ("effects.flow-gain-nonlinearity.notch", "the region about null: 3 % of the travel");
            roughly("effects.flow-gain-nonlinearity", "notch", whole, 0.03 * size.rated, why);
        }
        let (whole, why) = ("effects.stribeck-friction.velocity_m_per_s", "seals break away below about 10 mm/s");
        roughly("effects.stribeck-friction", "velocity_m_per_s", whole, 0.01, why);
        let (whole, why) =
            ("effects.presliding.stiffness_n_per_m", "seals yield by 30 µm under a friction of 1.5 % of full force");
        roughly("effects.presliding", "stiffness_n_per_m", whole, 0.015 * size.force_n / 3e-5, why);
    }

    fn pump(&mut self, sheet: &Sheet<'_>, area_a: f64) -> Result<FullSpeed, SheetError> {
        let displacement = sheet.needed(Item::PumpDisplacement)?;
        self.given("pump", "displacement_m3_per_rev", displacement, displacement.si);
        self.sigma("pump.displacement_m3_per_rev", 0.05 * displacement.si, "given: within 5 %, slip counted in");
        Ok(FullSpeed { m_per_s: displacement.si * PUMP_REV_PER_S / area_a, how: "at 1500 rpm of the pump" })
    }

    fn cylinder(
        &mut self,
        sheet: &Sheet<'_>,
        (area_a, area_b): (f64, f64),
        speed: &FullSpeed,
    ) -> Result<f64, SheetError> {
        let (bore, rod) = (sheet.needed(Item::Bore)?, sheet.needed(Item::Rod)?);
        let (stroke, supply) = (sheet.needed(Item::Stroke)?, sheet.needed(Item::Supply)?);
        let given = |item| sheet.answers.get(item);
        let table = "cylinder";
        self.push(table, "area_a_m2", vec![area_a], Origin::Derived, format!("π/4·bore², {bore}"));
        self.push(table, "area_b_m2", vec![area_b], Origin::Derived, format!("less the rod, π/4·rod², {rod}"));
        self.given(table, "stroke_m", stroke, stroke.si);

        let (dead, how, known) = dead_volume(sheet.answers)?;
        let dead_m3 = dead.unwrap_or(0.5 * DEAD_VOLUME * area_a * stroke.si);
        for (key, whole, area) in
            [("volume_a_m3", "cylinder.volume_a_m3", area_a), ("volume_b_m3", "cylinder.volume_b_m3", area_b)]
        {
            let half = 0.5 * area * stroke.si;
            let volume = half + dead.unwrap_or(DEAD_VOLUME * half);
            self.push(table, key, vec![volume], Origin::Derived, format!("area · stroke/2, at mid-stroke, and {how}"));
            if known {
                self.sigma(whole, DEAD_VOLUME_WITHIN * dead_m3, "given: the dead volume within 20 %");
            } else {
                self.sigma(whole, DEAD_VOLUME * half, "as much as the dead volume that was assumed");
            }
        }
        self.push(table, "volume_follows_piston", vec![1.0], Origin::Assumed, "as in every cylinder".to_owned());
        if let Some(modulus) = given(Item::BulkModulus) {
            self.given(table, "bulk_modulus_pa", modulus, modulus.si);
            self.sigma("cylinder.bulk_modulus_pa", 0.1 * modulus.si, "given: within 10 %, for air and hoses soften it");
        } else {
            let why = "oil with the usual bit of air".to_owned();
            self.push(table, "bulk_modulus_pa", vec![BULK_MODULUS_PA], Origin::Assumed, why);
            self.sigma("cylinder.bulk_modulus_pa", 0.3 * BULK_MODULUS_PA, "assumed: within 30 %");
        }
        let mass = sheet.needed(Item::Mass)?;
        self.given(table, "moving_mass_kg", mass, mass.si);
        self.sigma("cylinder.moving_mass_kg", 0.05 * mass.si, "given: within 5 %");

        let at = format!("{} mm/s, {}", significant(1e3 * speed.m_per_s, 3), speed.how);
        let key = "viscous_friction_n_s_per_m";
        if let Some(force) = given(Item::Friction) {
            let damping = force.si / speed.m_per_s;
            self.push(table, key, vec![damping], Origin::Derived, format!("D = F/v: {force} at {at}"));
            self.sigma(
                "cylinder.viscous_friction_n_s_per_m",
                0.3 * damping,
                "given: within 30 %, for friction never keeps still",
            );
        } else {
            let damping = FRICTION * supply.si * area_a / speed.m_per_s;
            let why = format!("D = F/v: a tenth of the force at supply pressure, as seals and guides have, at {at}");
            self.push(table, key, vec![damping], Origin::Assumed, why);
            self.sigma("cylinder.viscous_friction_n_s_per_m", 2.0 * damping, "assumed: the order of size");
        }
        Ok(dead_m3)
    }
}

/// Oil on each side outside the chamber itself, m³; how it is described; and whether it was given.
fn dead_volume(answers: &Answers) -> Result<(Option<f64>, String, bool), SheetError> {
    let (length, diameter) = (answers.get(Item::HoseLength), answers.get(Item::HoseDiameter));
    let (length_flag, diameter_flag) = (Item::HoseLength.question().flag, Item::HoseDiameter.question().flag);
    let hose = match (length, diameter) {
        (Some(length), Some(diameter)) => {
            Some((PI / 4.0 * diameter.si * diameter.si * length.si, format!("hose of {length}, {diameter}")))
        }
        (None, None) => None,
        (Some(_), None) => return Err(SheetError::HalfAHose { given: length_flag, absent: diameter_flag }),
        (None, Some(_)) => return Err(SheetError::HalfAHose { given: diameter_flag, absent: length_flag }),
    };
    let further = answers.get(Item::DeadVolume).map(|volume| (volume.si, volume.to_string()));
    Ok(match (hose, further) {
        (None, None) => (None, "a twentieth of it assumed for hose and ports".to_owned(), false),
        (Some((volume, how)), None) | (None, Some((volume, how))) => (Some(volume), how, true),
        (Some(hose), Some(further)) => (Some(hose.0 + further.0), format!("{}, and {}", hose.1, further.1), true),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn press() -> Answers {
        let mut answers = Answers::default();
        for (item, text) in [
            (Item::Bore, "63mm"),
            (Item::Rod, "40mm"),
            (Item::Stroke, "300mm"),
            (Item::Mass, "18.3kg"),
            (Item::Supply, "70bar"),
            (Item::RatedFlow, "5l/min"),
            (Item::RatedDrop, "5bar"),
            (Item::RatedSignal, "10V"),
            (Item::SpoolAtRated, "59.35%"),
            (Item::Overlap, "17.68%"),
            (Item::ValveResponse, "96ms"),
            (Item::DeadVolume, "50cm3"),
        ] {
            answers.insert(item, item.parse(text).unwrap());
        }
        answers
    }

    fn value(made: &Derived, key: &str) -> f64 {
        made.entries.iter().find(|entry| entry.key == key).unwrap().values[0]
    }

    #[test]
    fn the_press_comes_out_of_its_data_sheet() {
        let made = derived(&press(), Edges::Edge).unwrap();
        for (key, expected, within) in [
            ("area_a_m2", 3.117e-3, 1e-3),
            ("area_b_m2", 1.861e-3, 1e-3),
            ("volume_a_m3", 5.2e-4, 0.01),
            ("volume_b_m3", 3.3e-4, 0.01),
            ("gain_per_v", 0.0559, 0.07),
            ("dead_zone", 0.1049, 1e-3),
            ("flow_coefficient", 2.4e-7, 0.01),
        ] {
            let found = value(&made, key);
            assert!((found / expected - 1.0).abs() < within, "{key}: {found}");
        }
    }

    #[test]
    fn a_drop_over_both_edges_is_half_over_each() {
        let both = value(&derived(&press(), Edges::Both).unwrap(), "flow_coefficient");
        let edge = value(&derived(&press(), Edges::Edge).unwrap(), "flow_coefficient");
        assert!((both / edge / 2.0_f64.sqrt() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_given_is_narrower_than_what_is_assumed() {
        let relative = |answers: &Answers, key: &str, of: &str| {
            let made = derived(answers, Edges::Edge).unwrap();
            made.sigma.iter().find(|sigma| sigma.key == key).unwrap().value / value(&made, of)
        };
        let mut known = press();
        known.insert(Item::BulkModulus, Item::BulkModulus.parse("1200MPa").unwrap());
        known.insert(Item::Friction, Item::Friction.parse("2kN").unwrap());
        for key in ["bulk_modulus_pa", "viscous_friction_n_s_per_m"] {
            let whole = format!("cylinder.{key}");
            assert!(relative(&known, &whole, key) < 0.5 * relative(&press(), &whole, key), "{key}");
        }
    }

    #[test]
    fn what_does_not_go_together_is_refused() {
        let with = |item: Item, text| {
            let mut answers = press();
            answers.insert(item, item.parse(text).unwrap());
            derived(&answers, Edges::Edge).unwrap_err()
        };
        assert!(matches!(with(Item::Rod, "63mm"), SheetError::RodTooThick { .. }));
        assert!(matches!(with(Item::HoseLength, "1m"), SheetError::HalfAHose { absent: "hose-diameter", .. }));
        assert!(matches!(
            with(Item::PumpDisplacement, "16cm3/rev"),
            SheetError::ValveBesidePump { flag: "rated-flow" }
        ));
        let missing = derived(&Answers::default(), Edges::Edge).unwrap_err().to_string();
        for flag in ["--bore 63mm", "--rated-flow 40l/min", "--valve-response 50ms"] {
            assert!(missing.contains(flag), "{missing}");
        }
    }
}
