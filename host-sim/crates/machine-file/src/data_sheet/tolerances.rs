//! What every machined and installed drive has within its drawing: values that a fit may use and that are no findings.
//!
//! Without them no fit of a real drive comes down to its noise, and another effect is bent to stand in. Each is a largest magnitude; beyond it the
//! same thing is a finding.
//!
//! Sources: edges and overlaps of a ground spool in its bushing, Merritt, *Hydraulic Control Systems*, 1967, ch. 5; seals, catalogues of cylinders
//! and seals (low friction 1 to 3 % of the force, standard up to 5 %), ISO 10100; sensors, usual accuracy class of 0.3 % of full scale, and full scale
//! up to 2.5 times the supply; flow gain about null, 50 to 200 % of nominal, ISO 10770-1 and catalogues of servo valves; hysteresis of valves without
//! a sensor at the spool, catalogues (3 to 5 %, with dither less); hoses, SAE J517 hoses of 0.2 to 0.6 GPa; air, 0.1 to 0.5 % of free air in a filled system and up to
//! 1 %.

use recording::display_unit::significant;

use super::derive::Sigma;

/// The size of a drive.
pub(super) struct Size {
    /// A pump feeds it.
    pub(super) pump: bool,
    /// Supply pressure.
    pub(super) supply_pa: f64,
    /// Supply pressure times area A.
    pub(super) force_n: f64,
    /// Flow into A at full speed.
    pub(super) flow_m3_per_s: f64,
    /// Spool travel at the rated signal.
    pub(super) rated: f64,
    /// Overlap, as a share of that.
    pub(super) overlap: f64,
    /// Oil on a side outside the cylinder.
    pub(super) dead_m3: f64,
}

/// Largest dry friction of good seals, as a share of full force.
const SEALS: f64 = 0.04;
/// Break-away beyond that.
const BREAK_AWAY: f64 = 0.025;
/// Reading of a pressure sensor at no pressure, as a share of the supply.
const PRESSURE_OFFSET: f64 = 0.0075;
/// Least modulus of a hose, Pa.
const SOFTEST_HOSE_PA: f64 = 0.2e9;
/// A valve of less overlap than this may be open at its centre.
pub(super) const ZERO_LAP: f64 = 0.03;
/// A valve of more overlap than this is made for mobile machines or without a sensor at its spool.
const MUCH_OVERLAP: f64 = 0.2;

impl Size {
    /// Every tolerance of this drive.
    pub(super) fn tolerances(&self) -> Vec<Sigma> {
        let Self { supply_pa, force_n, flow_m3_per_s, rated, dead_m3, .. } = *self;
        let (hysteresis, hysteresis_why) = if self.overlap > MUCH_OVERLAP {
            (0.025, "a valve of such overlap mostly has no sensor at its spool: some per cent")
        } else {
            (0.012, "a spool with a sensor of its own: about 1 %")
        };
        let full = format!("at {} l/min, full speed without load", significant(6e4 * flow_m3_per_s, 2));
        let (gives_way, returns) = (format!("a pump gives way by 3 % {full}"), format!("4 bar {full}"));
        let mut all = vec![
            ("effects.entrained-air.share", 0.01, "oil in service holds 0.1 to 1 % of free air"),
            (
                "effects.hose-compliance.compliance_m3_per_pa",
                dead_m3 / SOFTEST_HOSE_PA,
                "hoses yield: 0.2 GPa at the softest",
            ),
            ("effects.stribeck-friction.force_n", SEALS * force_n, "good seals: up to 4 % of full force"),
            ("effects.stribeck-friction.excess_n", BREAK_AWAY * force_n, "and up to 2.5 % more to break away"),
            ("effects.position-sensor-lag.time_constant_s", 4e-3, "a position sensor's filter: up to 4 ms"),
            (
                "effects.sensor-offset.pressure_a_pa",
                PRESSURE_OFFSET * supply_pa,
                "0.3 % of a sensor of 2.5 times the supply",
            ),
            ("effects.sensor-offset.pressure_b_pa", PRESSURE_OFFSET * supply_pa, "the same"),
        ];
        if self.pump {
            all.push(("effects.tank-back-pressure.resistance_pa_s2_per_m6", 4e5 / flow_m3_per_s.powi(2), &returns));
        } else {
            all.extend([
                ("effects.valve-hysteresis.width", hysteresis * rated, hysteresis_why),
                ("effects.dead-zone-asymmetry.difference", 0.03 * rated, "overlaps alike within 3 % of travel"),
                ("effects.metering-asymmetry.ratio", EDGES, "edges alike within 5 %, and areas: 8 % together"),
                ("effects.metering-asymmetry.ports", EDGES, "the same"),
                ("effects.metering-asymmetry.directions", EDGES, "the same"),
                ("effects.supply-droop.resistance_pa_s_per_m3", 0.03 * supply_pa / flow_m3_per_s, &gives_way),
                ("effects.tank-back-pressure.resistance_pa_s2_per_m6", 4e5 / flow_m3_per_s.powi(2), &returns),
                ("effects.sensor-offset.spool", 5e-3 * rated, "0.3 % of full scale, and the neutral"),
            ]);
            if self.overlap < ZERO_LAP {
                all.extend([
                    ("effects.valve-leakage.rounding", 0.02 * rated, "corners and play of 10 µm on a travel of 0.5 mm"),
                    ("effects.flow-gain-nonlinearity.beyond", 1.0, "about null, half to twice the gain of further out"),
                ]);
            } else {
                all.push((
                    "effects.valve-leakage.rounding",
                    0.01 * rated,
                    "corners and play of 10 to 20 µm on a travel of some mm",
                ));
            }
        }
        let listed = all.into_iter().filter(|(_, value, _)| *value > 0.0 && value.is_finite());
        listed.map(|(key, value, why)| Sigma { key, value, why: why.to_owned() }).collect()
    }
}

/// Largest difference between the sizes of two edges.
const EDGES: f64 = 0.08;
