//! The valve's four edges with the lines before and after them: from spool position and pressures to Qa and Qb.

use super::orifice::{limited, signed_root};
use crate::tangent::Real;

/// How the flow grows with the opening beyond the dead zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GainCurve {
    /// In proportion: the paper's model.
    Proportional,
    /// Notches: a smaller slope up to a rounded knee, the full one beyond.
    Notch {
        /// Opening at the knee, 1.
        knee: f64,
        /// Slope below the knee, relative to the slope beyond it.
        slope: f64,
        /// How far the knee is rounded, 1.
        rounding: f64,
    },
    /// A power of the opening, which leaves the flow unchanged at one opening.
    Power {
        /// The exponent; 1 is proportional.
        exponent: f64,
        /// The opening that keeps its flow, 1.
        unchanged_at: f64,
    },
}

impl GainCurve {
    /// The opening of a proportional valve that has the same flow; an odd function.
    #[must_use]
    pub fn shaped(&self, opening: f64) -> f64 {
        let size = opening.abs();
        let shaped = match *self {
            Self::Proportional => return opening,
            Self::Notch { knee, slope, rounding } => {
                let beyond = |at: f64| 0.5 * ((at - knee) + (at - knee).hypot(rounding));
                slope * size + (1.0 - slope) * (beyond(size) - beyond(0.0))
            }
            Self::Power { exponent, unchanged_at } => {
                if size > 0.0 {
                    unchanged_at * libm::pow(size / unchanged_at, exponent)
                } else {
                    0.0
                }
            }
        };
        shaped.copysign(opening)
    }
}

/// A line in series with an edge: Δp = linear·Q + quadratic·Q².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SeriesLine {
    /// Pa·s/m³.
    pub(crate) linear: f64,
    /// Pa·s²/m⁶.
    pub(crate) quadratic: f64,
}

/// The pressures at the valve's ports.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ports<R> {
    pub(crate) supply: R,
    pub(crate) tank_pa: f64,
    pub(crate) a: R,
    pub(crate) b: R,
}

/// The edges of a valve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edges {
    /// m³/s per √Pa of a fully open spool.
    pub(crate) coefficient: f64,
    /// Overlap on the extending and on the retracting side.
    pub(crate) dead_zone: [f64; 2],
    pub(crate) transition_pa: f64,
    /// Pressure difference up to which a sharp edge is laminar (in series with the root); 0 is none.
    pub(crate) laminar_pa: f64,
    pub(crate) flow_limit: f64,
    pub(crate) gain: GainCurve,
    /// Sizes of P-A, B-T (extending), P-B and A-T (retracting), relative to the coefficient.
    pub(crate) sizes: [f64; 4],
    pub(crate) supply_line: SeriesLine,
    pub(crate) return_line: SeriesLine,
}

impl Edges {
    /// Spool travel beyond the dead zone, with the spool's sign.
    #[must_use]
    pub(crate) fn opening(&self, spool: f64) -> f64 {
        let [extending, retracting] = self.dead_zone;
        if spool > extending {
            spool - extending
        } else if spool < -retracting {
            spool + retracting
        } else {
            0.0
        }
    }

    /// Qa into A and Qb out of B, m³/s. (3), (4)
    pub(crate) fn flows<R: Real>(&self, spool: f64, ports: &Ports<R>) -> (R, R) {
        let opening = self.opening(spool);
        let gain = self.coefficient * self.gain.shaped(opening);
        let from_supply = |port: R| ports.supply - port;
        let to_tank = |port: R| port - ports.tank_pa;
        let [supply_a, b_tank, supply_b, a_tank] = self.sizes;
        let (supply, back) = (self.supply_line, self.return_line);
        let (a, b) = if gain > 0.0 {
            (self.edge(gain * supply_a, from_supply(ports.a), supply), self.edge(gain * b_tank, to_tank(ports.b), back))
        } else if gain < 0.0 {
            (self.edge(gain * a_tank, to_tank(ports.a), back), self.edge(gain * supply_b, from_supply(ports.b), supply))
        } else {
            return (0.0.into(), 0.0.into());
        };
        (limited(a, self.flow_limit), limited(b, self.flow_limit))
    }

    /// The one of these flows that the supply delivers, m³/s.
    pub(crate) fn delivered<R: Real>(&self, spool: f64, (flow_a, flow_b): (R, R)) -> R {
        if self.opening(spool) < 0.0 { -flow_b } else { flow_a }
    }

    /// Flow through an edge of `gain` (m³/s per √Pa; its sign is that of the flow) with a line in series.
    fn edge<R: Real>(&self, gain: f64, across: R, line: SeriesLine) -> R {
        let root = signed_root(across, self.transition_pa);
        let linear = line.linear + self.laminar_pa.sqrt() / gain.abs();
        if linear <= 0.0 {
            return root * (gain / (1.0 + line.quadratic * gain * gain).sqrt());
        }
        // Δp = linear·Q + (1/gain² + quadratic)·Q², solved for Q.
        let square = 1.0 / (gain * gain) + line.quadratic;
        let flow = root * root.abs() * 2.0 / ((root * root * (4.0 * square) + linear * linear).sqrt() + linear);
        if gain < 0.0 { -flow } else { flow }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edges() -> Edges {
        Edges {
            coefficient: 1e-6,
            dead_zone: [0.1, 0.1],
            transition_pa: 1.0,
            laminar_pa: 0.0,
            flow_limit: f64::INFINITY,
            gain: GainCurve::Proportional,
            sizes: [1.0; 4],
            supply_line: SeriesLine::default(),
            return_line: SeriesLine::default(),
        }
    }

    const PORTS: Ports<f64> = Ports { supply: 10e6, tank_pa: 0.0, a: 6e6, b: 4e6 };

    #[test]
    fn an_edge_and_its_line_share_the_pressure_difference() {
        let line = SeriesLine { linear: 2e9, quadratic: 5e12 };
        let (qa, qb) = Edges { return_line: line, ..edges() }.flows(0.6, &PORTS);
        assert!((qa - 0.5e-6 * 2000.0).abs() < 1e-9);
        let across_edge = (qb / 0.5e-6).powi(2);
        let across_line = 2e9 * qb + 5e12 * qb * qb;
        assert!((across_edge + across_line - 4e6).abs() < 10.0);
        assert!(across_line > 1e6);
    }

    #[test]
    fn only_the_side_with_the_larger_overlap_opens_later() {
        let edges = Edges { dead_zone: [0.2, 0.1], ..edges() };
        assert!(edges.flows(0.15, &PORTS).0.abs() < 1e-18);
        assert!(edges.flows(-0.15, &PORTS).0 < -1e-8);
    }

    #[test]
    fn a_laminar_edge_is_linear_at_small_differences_and_a_root_at_large_ones() {
        let edges = Edges { laminar_pa: 1e5, ..edges() };
        let flow = |difference: f64| edges.flows(0.6, &Ports { a: 10e6 - difference, ..PORTS }).0;
        assert!((flow(2e3) / flow(1e3) - 2.0).abs() < 0.05);
        assert!((flow(8e6) / flow(2e6) - 2.0).abs() < 0.15);
    }

    #[test]
    fn curves_keep_the_sign_and_bend_as_they_say() {
        let notch = GainCurve::Notch { knee: 0.2, slope: 0.4, rounding: 0.01 };
        assert!((notch.shaped(0.1) - 0.04).abs() < 2e-3);
        assert!((notch.shaped(-0.6) + 0.4 * 0.6 + 0.6 * 0.4).abs() < 2e-3);
        let power = GainCurve::Power { exponent: 1.3, unchanged_at: 0.3 };
        assert!((power.shaped(0.3) - 0.3).abs() < 1e-12 && power.shaped(0.1) < 0.1 && power.shaped(-0.1) > -0.1);
    }
}
