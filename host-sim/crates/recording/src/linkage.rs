//! The linkage between a joint and the cylinder that moves it: the recorded angle of the joint is a position of the rod.
//!
//! Joint, cylinder's foot and rod's eye form a triangle. Its two sides at the joint, a (base) and b (arm), are fixed; the third side is the cylinder:
//!
//! L² = a² + b² − 2·a·b·cos φ,  y = L − L₀,  φ = φ₀ ± θ
//!
//! with the position y, the length L₀ at y = 0, the recorded angle θ, and the angle φ₀ between the sides where θ = 0. Linkages of more links are given by
//! a table. Both ways the relation is geometry alone and one to one: no value is ever extrapolated.

use std::f64::consts::PI;

/// An end that is met but for rounding is met.
const ROUNDED_RAD: f64 = 1e-12;

/// A linkage, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Linkage(Relation);

#[derive(Clone, Debug, PartialEq)]
enum Relation {
    Triangle(Triangle),
    Table(Table),
}

/// The triangle of joint, cylinder's foot and rod's eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// From the joint to the cylinder's foot, m.
    pub base_m: f64,
    /// From the joint to the rod's eye, m.
    pub arm_m: f64,
    /// From foot to eye with the rod fully in, m.
    pub length_retracted_m: f64,
    /// Angle between base and arm where the recorded angle is 0, rad.
    pub angle_at_zero_rad: f64,
    /// Which way the recorded angle rises.
    pub rises: Rises,
}

/// Which way a recorded angle rises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rises {
    /// As the rod extends.
    #[default]
    Extending,
    /// As the rod retracts.
    Retracting,
}

impl Rises {
    /// Its name in a machine file.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Rises::Extending => "extending",
            Rises::Retracting => "retracting",
        }
    }

    /// The way of this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        [Self::Extending, Self::Retracting].into_iter().find(|way| way.name() == name)
    }

    const fn sign(self) -> f64 {
        match self {
            Rises::Extending => 1.0,
            Rises::Retracting => -1.0,
        }
    }
}

/// Why there is no such linkage.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LinkageError {
    /// The triangle does not close over the whole stroke.
    #[error("a cylinder of {length_m} m between sides that it closes from {shortest_m} to {longest_m} m")]
    NoTriangle {
        /// Length of the cylinder within its stroke, m.
        length_m: f64,
        /// Difference of the sides, m.
        shortest_m: f64,
        /// Sum of the sides, m.
        longest_m: f64,
    },
    /// A table with fewer than two entries, or with more angles than positions.
    #[error("a table of {angles} angles and {positions} positions")]
    Entries {
        /// How many angles.
        angles: usize,
        /// How many positions.
        positions: usize,
    },
    /// Angles or positions that neither rise nor fall throughout.
    #[error("{before} is followed by {found} in entry {entry}, against the way of the first two")]
    TurnsBack {
        /// Whether it is in the positions, or else in the angles.
        in_positions: bool,
        /// The entry from which on it turns back, from 1.
        entry: usize,
        /// The value before, m or rad.
        before: f64,
        /// The value found, m or rad.
        found: f64,
    },
}

impl Linkage {
    /// The linkage of a triangle that has to close over the stroke of the cylinder, m.
    ///
    /// # Errors
    /// It does not close.
    pub fn of_sides(triangle: Triangle, stroke_m: f64) -> Result<Self, LinkageError> {
        let Triangle { base_m, arm_m, length_retracted_m, .. } = triangle;
        let (shortest_m, longest_m) = ((base_m - arm_m).abs(), base_m + arm_m);
        for length_m in [length_retracted_m, length_retracted_m + stroke_m] {
            if !(shortest_m..=longest_m).contains(&length_m) {
                return Err(LinkageError::NoTriangle { length_m, shortest_m, longest_m });
            }
        }
        Ok(Self(Relation::Triangle(triangle)))
    }

    /// The linkage of a table, in rad and m, each rising or falling throughout. Between its entries the position is a monotone cubic of the angle
    /// (Fritsch, Carlson 1980): the speed has no steps.
    ///
    /// # Errors
    /// Fewer than two entries, not as many angles as positions, or one of both turns back.
    pub fn of_table(angles_rad: &[f64], positions_m: &[f64]) -> Result<Self, LinkageError> {
        Table::new(angles_rad, positions_m).map(|table| Self(Relation::Table(table)))
    }

    /// Position of the rod, m, for a recorded angle, rad; `None` where the linkage does not reach it.
    #[must_use]
    pub fn position_m(&self, angle_rad: f64) -> Option<f64> {
        match &self.0 {
            Relation::Triangle(triangle) => triangle.position_m(angle_rad),
            Relation::Table(table) => table.position_m(angle_rad),
        }
    }

    /// The angle that is recorded, rad, at a position of the rod, m; at the nearest one that the linkage reaches, where it does not reach this one.
    #[must_use]
    pub fn angle_rad(&self, position_m: f64) -> f64 {
        match &self.0 {
            Relation::Triangle(triangle) => triangle.angle_rad(position_m),
            Relation::Table(table) => table.angle_rad(position_m),
        }
    }

    /// The lowest and the highest angle that the linkage reaches, rad.
    #[must_use]
    pub fn reach_rad(&self) -> (f64, f64) {
        match &self.0 {
            Relation::Triangle(triangle) => triangle.reach_rad(),
            Relation::Table(Table { nodes }) => (nodes[0].angle_rad, nodes[nodes.len() - 1].angle_rad),
        }
    }

    /// The triangle, where it is given by its sides.
    #[must_use]
    pub fn triangle(&self) -> Option<&Triangle> {
        if let Relation::Triangle(triangle) = &self.0 { Some(triangle) } else { None }
    }

    /// Angles, rad, and positions, m, by rising angle, where it is given by a table.
    #[must_use]
    pub fn table(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let Relation::Table(Table { nodes }) = &self.0 else { return None };
        Some(nodes.iter().map(|node| (node.angle_rad, node.position_m)).unzip())
    }
}

impl Triangle {
    fn position_m(&self, angle_rad: f64) -> Option<f64> {
        let between_rad = self.angle_at_zero_rad + self.rises.sign() * angle_rad;
        let (a, b) = (self.base_m, self.arm_m);
        let square = a * a + b * b - 2.0 * a * b * libm::cos(between_rad);
        (-ROUNDED_RAD..=PI + ROUNDED_RAD)
            .contains(&between_rad)
            .then(|| square.max(0.0).sqrt() - self.length_retracted_m)
    }

    fn angle_rad(&self, position_m: f64) -> f64 {
        let (a, b, length_m) = (self.base_m, self.arm_m, self.length_retracted_m + position_m);
        let cosine = (a * a + b * b - length_m.max(0.0).powi(2)) / (2.0 * a * b);
        self.rises.sign() * (libm::acos(cosine.clamp(-1.0, 1.0)) - self.angle_at_zero_rad)
    }

    fn reach_rad(&self) -> (f64, f64) {
        let [flat, stretched] = [0.0, PI].map(|between| self.rises.sign() * (between - self.angle_at_zero_rad));
        (flat.min(stretched), flat.max(stretched))
    }
}

/// A table by rising angle.
#[derive(Clone, Debug, PartialEq)]
struct Table {
    /// At least two.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    angle_rad: f64,
    position_m: f64,
    /// Of the position over the angle, m/rad.
    slope: f64,
}

impl Table {
    fn new(angles_rad: &[f64], positions_m: &[f64]) -> Result<Self, LinkageError> {
        let (angles, positions) = (angles_rad.len(), positions_m.len());
        if angles != positions || angles < 2 {
            return Err(LinkageError::Entries { angles, positions });
        }
        goes_one_way(angles_rad, false)?;
        goes_one_way(positions_m, true)?;
        let node = |(&angle_rad, &position_m): (&f64, &f64)| Node { angle_rad, position_m, slope: 0.0 };
        let mut nodes: Vec<Node> = angles_rad.iter().zip(positions_m).map(node).collect();
        if nodes[0].angle_rad > nodes[1].angle_rad {
            nodes.reverse();
        }
        let slopes = slopes(&nodes);
        nodes.iter_mut().zip(slopes).for_each(|(node, slope)| node.slope = slope);
        Ok(Self { nodes })
    }

    fn position_m(&self, angle_rad: f64) -> Option<f64> {
        let (first, last) = (self.nodes.first()?, self.nodes.last()?);
        if !(first.angle_rad..=last.angle_rad).contains(&angle_rad) {
            return None;
        }
        let after = self.nodes.partition_point(|node| node.angle_rad <= angle_rad).clamp(1, self.nodes.len() - 1);
        Some(cubic(&self.nodes[after - 1], &self.nodes[after], angle_rad))
    }

    /// By halving: the cubic is monotone between its nodes.
    fn angle_rad(&self, position_m: f64) -> f64 {
        let rises = self.nodes[0].position_m < self.nodes[1].position_m;
        let is_before = |position: f64| if rises { position <= position_m } else { position >= position_m };
        let after = self.nodes.partition_point(|node| is_before(node.position_m)).clamp(1, self.nodes.len() - 1);
        let (from, to) = (&self.nodes[after - 1], &self.nodes[after]);
        let (mut low, mut high) = (from.angle_rad, to.angle_rad);
        // An end is met exactly, and so is everything beyond it.
        for (node, is_beyond) in [(from, !is_before(from.position_m)), (to, is_before(to.position_m))] {
            if is_beyond || node.position_m.to_bits() == position_m.to_bits() {
                return node.angle_rad;
            }
        }
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            if is_before(cubic(from, to, middle)) { low = middle } else { high = middle }
        }
        f64::midpoint(low, high)
    }
}

fn goes_one_way(values: &[f64], in_positions: bool) -> Result<(), LinkageError> {
    let rises = values[1] > values[0];
    let against = |pair: &[f64]| if rises { pair[1] <= pair[0] } else { pair[1] >= pair[0] };
    match values.windows(2).position(against) {
        Some(at) => {
            let (before, found) = (values[at], values[at + 1]);
            Err(LinkageError::TurnsBack { in_positions, entry: at + 2, before, found })
        }
        None => Ok(()),
    }
}

/// The cubic between two nodes.
fn cubic(from: &Node, to: &Node, angle_rad: f64) -> f64 {
    let width = to.angle_rad - from.angle_rad;
    let t = (angle_rad - from.angle_rad) / width;
    let (rise, rest) = (t * t * (3.0 - 2.0 * t), 1.0 - t);
    let bent = width * (t * rest * rest * from.slope - t * t * rest * to.slope);
    from.position_m + rise * (to.position_m - from.position_m) + bent
}

/// Slopes at the nodes: that of a parabola through the nodes on either side, as far as it keeps the cubic monotone.
fn slopes(nodes: &[Node]) -> Vec<f64> {
    let width = |at: usize| nodes[at + 1].angle_rad - nodes[at].angle_rad;
    let mean = |at: usize| (nodes[at + 1].position_m - nodes[at].position_m) / width(at);
    let last = nodes.len() - 1;
    let slope = |at: usize| {
        if last == 1 {
            return mean(0);
        }
        // At an end the parabola goes through the three nodes there.
        let middle = at.clamp(1, last - 1);
        let (before, after) = (mean(middle - 1), mean(middle));
        let bend = (after - before) / (width(middle - 1) + width(middle));
        let between = |from: usize, to: usize| nodes[to].angle_rad - nodes[from].angle_rad;
        let parabola = before + bend * (between(middle - 1, at) + between(middle, at));
        let least = if at == 0 { mean(0) } else { mean(at - 1) };
        let other = if at == last { mean(last - 1) } else { mean(at) };
        let flatter = if least.abs() < other.abs() { least } else { other };
        flatter * (parabola / flatter).clamp(0.0, 3.0)
    };
    (0..nodes.len()).map(slope).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const BOOM: Triangle =
        Triangle { base_m: 0.6, arm_m: 0.5, length_retracted_m: 0.45, angle_at_zero_rad: 0.4, rises: Rises::Extending };

    fn boom() -> Linkage {
        Linkage::of_sides(BOOM, 0.3).unwrap()
    }

    #[test]
    fn a_right_angle_is_found_by_pythagoras() {
        let triangle = Triangle { base_m: 0.4, arm_m: 0.3, length_retracted_m: 0.3, ..BOOM };
        let position_m = Linkage::of_sides(triangle, 0.3).unwrap().position_m(PI / 2.0 - 0.4).unwrap();
        assert!((position_m - 0.2).abs() < 1e-12);
    }

    #[test]
    fn an_angle_that_rises_as_the_rod_retracts_has_the_other_sign() {
        let turned = Linkage::of_sides(Triangle { rises: Rises::Retracting, ..BOOM }, 0.3).unwrap();
        assert_eq!(turned.position_m(-0.3), boom().position_m(0.3));
        assert!(turned.position_m(-0.3) > turned.position_m(-0.2));
    }

    #[test]
    fn what_the_linkage_does_not_reach_has_no_position() {
        for (linkage, reach) in [(boom(), (-0.4, PI - 0.4)), (tabulated(9), (0.1, 1.1))] {
            let (low, high) = linkage.reach_rad();
            assert!((low - reach.0).abs() + (high - reach.1).abs() < 1e-12, "{low} {high}");
            assert!(linkage.position_m(low).is_some() && linkage.position_m(high).is_some());
            for beyond in [low - 1e-9, high + 1e-9, f64::NAN] {
                assert_eq!(linkage.position_m(beyond), None);
            }
        }
    }

    #[test]
    fn a_position_beyond_the_linkage_has_the_angle_of_its_end() {
        for linkage in [boom(), tabulated(9)] {
            let (low, high) = linkage.reach_rad();
            assert_eq!(
                (linkage.angle_rad(-5.0).to_bits(), linkage.angle_rad(5.0).to_bits()),
                (low.to_bits(), high.to_bits())
            );
        }
    }

    #[test]
    fn what_makes_no_linkage_is_refused() {
        let short = Linkage::of_sides(Triangle { arm_m: 0.05, ..BOOM }, 0.3).unwrap_err();
        assert!(matches!(short, LinkageError::NoTriangle { length_m: 0.45, .. }), "{short}");
        // The rod fully out, and not in, is longer than both sides.
        assert!(matches!(Linkage::of_sides(BOOM, 0.7).unwrap_err(), LinkageError::NoTriangle { .. }));
        let of = |angles: &[f64], positions: &[f64]| Linkage::of_table(angles, positions).unwrap_err();
        assert_eq!(of(&[0.0], &[0.0]), LinkageError::Entries { angles: 1, positions: 1 });
        assert_eq!(of(&[0.0, 1.0], &[0.0]), LinkageError::Entries { angles: 2, positions: 1 });
        let back = of(&[0.0, 1.0, 2.0], &[0.0, 0.1, 0.1]);
        assert_eq!(back, LinkageError::TurnsBack { in_positions: true, entry: 3, before: 0.1, found: 0.1 });
        assert!(matches!(of(&[1.0, 0.0, 0.5], &[0.0, 0.1, 0.2]), LinkageError::TurnsBack { in_positions: false, .. }));
    }

    /// The boom's triangle as a table of so many entries over its stroke.
    fn tabulated(entries: u32) -> Linkage {
        let angles: Vec<f64> = (0..entries).map(|k| 0.1 + f64::from(k) / f64::from(entries - 1)).collect();
        let positions: Vec<f64> = angles.iter().map(|angle| boom().position_m(*angle).unwrap()).collect();
        Linkage::of_table(&angles, &positions).unwrap()
    }

    /// The parabola at the ends makes it an error of third order.
    #[test]
    fn a_table_of_a_triangle_is_that_triangle_to_micrometres() {
        for (entries, most_m) in [(6, 2e-4), (11, 5e-5), (41, 1e-6)] {
            let table = tabulated(entries);
            let off = |k: i32| {
                let angle = 0.1 + f64::from(k) / 1000.0;
                (table.position_m(angle).unwrap() - boom().position_m(angle).unwrap()).abs()
            };
            let worst = (0..=1000).map(off).fold(0.0, f64::max);
            assert!(worst < most_m, "{entries}: {worst}");
        }
    }

    #[test]
    fn the_speed_through_a_table_has_no_steps() {
        let table = Linkage::of_table(&[0.0, 0.3, 0.4, 1.0], &[0.0, 0.02, 0.10, 0.12]).unwrap();
        let slope =
            |angle: f64| (table.position_m(angle + 1e-7).unwrap() - table.position_m(angle - 1e-7).unwrap()) / 2e-7;
        for node in [0.3, 0.4] {
            assert!((slope(node - 1e-5) - slope(node + 1e-5)).abs() < 2e-3, "{node}");
        }
    }

    proptest! {
        #[test]
        fn angle_and_position_are_inverse(share in 0.001..0.999, steps in proptest::collection::vec((0.01..1.0, 0.001..1.0), 1..12), falls: bool) {
            let sum = |values: Vec<f64>| values.iter().scan(0.0, |sum, step| { *sum += step; Some(*sum) }).collect::<Vec<f64>>();
            let angles = sum(steps.iter().map(|(angle, _)| *angle).chain([0.5]).collect());
            let sign = if falls { -1.0 } else { 1.0 };
            let positions: Vec<f64> = sum(steps.iter().map(|(_, position)| *position).chain([0.1]).collect()).iter().map(|y| sign * y).collect();
            for linkage in [boom(), Linkage::of_table(&angles, &positions).unwrap()] {
                let (low, high) = linkage.reach_rad();
                let angle = low + share * (high - low);
                let position = linkage.position_m(angle).unwrap();
                prop_assert!((linkage.position_m(linkage.angle_rad(position)).unwrap() - position).abs() < 1e-12);
                // Between its entries it never turns back.
                let next = linkage.position_m(angle + 1e-4 * (high - low)).unwrap();
                let way = if linkage.table().is_some() { sign } else { 1.0 };
                prop_assert!(way * (next - position) > -1e-15);
            }
        }
    }
}
