//! Effects of the flow link: what the openings of the four metering edges have beyond the paper's dead zone.
//!
//! Everything here is in slider travel, before the flow gain `K_Q`. Each is `None` where its strength is nil; where all are,
//! and the supply does not droop, the flow link does not come here at all.

use crate::number::Number;
use crate::supply::Droop;

/// Coefficients of the edges' effects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeEffects<N: Number> {
    pub(crate) curve: Option<GainCurve<N>>,
    /// `metering-asymmetry`: what the tank edges' opening is more than the supply edges', as a share. −1..4.
    pub(crate) tank_excess: Option<N::Gain>,
    pub(crate) return_line: Option<ReturnLine<N>>,
    pub(crate) leakage: Option<ValveLeakage<N>>,
    pub(crate) droop: Option<Droop<N>>,
    /// 1/`SLOPE_SCALE`: steepnesses are carried that much smaller, so that they fit a signal.
    pub(crate) slope_fraction: N,
    /// `SLOPE_SCALE`
    pub(crate) slope_scale: N::Steep,
    /// 1, as a slope.
    pub(crate) unity: N::Steep,
}

/// What an opening times its root's slope is divided by to fit a signal: 8192 at most, where a root has 2600 at Δp = 0 with the
/// machine's laminar transition at its least. Resolved to 4e-6, finer than the slope itself.
pub(crate) const SLOPE_SCALE: f64 = 1024.0;

impl<N: Number> EdgeEffects<N> {
    /// Metering opening of either side for the travel beyond its dead zone, not negative.
    #[inline]
    pub(crate) fn metered(&self, beyond: N) -> N {
        self.curve.as_ref().map_or(beyond, |curve| curve.opening(beyond))
    }

    /// What every edge is open beside its metering opening.
    #[inline]
    pub(crate) fn leaking(&self, slider: N) -> N {
        self.leakage.as_ref().map_or(N::ZERO, |leakage| leakage.opening(slider))
    }

    /// Opening of a tank edge with the return line behind it.
    #[inline]
    pub(crate) fn tank_opening(&self, metered: N, leaking: N) -> N {
        let sized = match self.tank_excess {
            Some(excess) => metered + N::dot([excess], [metered]),
            None => metered,
        };
        let edge = sized + leaking;
        match &self.return_line {
            Some(line) => line.opening(self.unity, edge),
            None => edge,
        }
    }
}

/// `flow-gain-nonlinearity`: o becomes o·(1 + linear·o + quadratic·o²), held where it would change its sign.
///
/// o is the travel beyond the dead zone. Two steps (7.5e-9) of error. Notched edges: Jelali & Kroll 2003, ch. 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GainCurve<N: Number> {
    /// A quarter of both coefficients, which reach 10.
    pub(crate) quarters: [N::Gain; 2],
}

impl<N: Number> GainCurve<N> {
    #[inline]
    fn opening(&self, beyond: N) -> N {
        let square = beyond.times(beyond);
        let quarter = N::dot(self.quarters, [square, square.times(beyond)]);
        let half = quarter + quarter;
        (beyond + half + half).max(N::ZERO)
    }
}

/// `tank-back-pressure`: the return line, an orifice in series with the tank edge, o becomes o/√(1 + R·o²).
///
/// With Q = o·√(p − pr) and pr − pt = R·Q² the pressure pr between them drops out: Q = o/√(1 + R·o²)·√(p − pt). So each chamber
/// has its own line, which holds as only one of them returns at a time. R per unit, `K_Q`² included; error 4e-8 of the opening.
/// Two orifices in series: Merritt 1967, ch. 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ReturnLine<N: Number> {
    pub(crate) resistance: N::Gain,
}

impl<N: Number> ReturnLine<N> {
    #[inline]
    fn opening(&self, unity: N::Steep, edge: N) -> N {
        let drop = N::dot([self.resistance], [edge.times(edge)]);
        // (1 + z)^-½ as √(1 + z) / (1 + z): smooth in R down to none.
        let (root, _) = (N::ONE + drop).orifice_root(N::ZERO);
        edge.times(root).times(N::inverse_one_plus([drop], [unity]))
    }
}

/// `valve-leakage`: beside its metering opening every edge is open by `opening`/(1 + (x/reach)²).
///
/// x is the slider's travel from the centre. Turbulent like the edges themselves, and limited with them. Error 2e-8 of the opening,
/// and 2e-9/reach² of it where x is of the reach's size. The leakage flow of a worn or underlapped spool: Merritt 1967, 5-4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ValveLeakage<N: Number> {
    pub(crate) opening: N,
    /// 1/reach²
    pub(crate) narrowness: N::Steep,
}

impl<N: Number> ValveLeakage<N> {
    #[inline]
    fn opening(&self, slider: N) -> N {
        self.opening.times(N::inverse_one_plus([slider.times(slider)], [self.narrowness]))
    }
}
