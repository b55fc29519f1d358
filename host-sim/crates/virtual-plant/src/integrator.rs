//! The stiff integrator: crate `diffsol` with a fifth-order tableau.
//!
//! One-step, so that it loses no history at a corner of the input: Kværnø's ESDIRK 5(4) with seven stages
//! (A. Kværnø, BIT 44 (2004) 489–502), stiffly accurate, explicit first stage.

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::sync::Arc;

use diffsol::small::{SmallMat, SmallVec};
use diffsol::{
    DiffsolError, NalgebraContext, NalgebraLU, NalgebraMat, NalgebraVec, NonLinearOp, OdeBuilder, OdeEquationsImplicit,
    OdeSolverMethod, OdeSolverProblem, OdeSolverStopReason, RkState, Sdirk, Tableau, Vector,
};

use crate::boundary::Segment;
use crate::physics::Physics;
use crate::tangent::Tangent;

const STAGES: usize = 7;
/// The diagonal element.
const G: f64 = 0.26;
/// The rows below the diagonal; the last is the solution, the one before it the embedded solution.
#[rustfmt::skip]
#[expect(clippy::excessive_precision, reason = "as the author prints them")]
const ROWS: [[f64; STAGES - 1]; STAGES] = [
    [0.0; 6],
    [G, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.13, 0.840_333_209_967_908_09, 0.0, 0.0, 0.0, 0.0],
    [0.223_719_614_783_205_05, 0.476_755_323_197_996_99, -0.064_708_953_631_126_15, 0.0, 0.0, 0.0],
    [0.166_485_643_232_483_21, 0.104_500_188_415_917_20, 0.036_314_822_720_987_15, -0.130_907_044_510_739_98, 0.0, 0.0],
    [0.138_556_402_312_682_24, 0.0, -0.042_453_372_017_520_43, 0.024_466_578_980_031_41, 0.619_430_390_724_806_76, 0.0],
    [
        0.136_597_511_776_402_91,
        0.0,
        -0.054_969_087_965_383_76,
        -0.041_186_267_283_210_46,
        0.629_933_048_990_164_03,
        0.069_624_794_482_027_28,
    ],
];

/// Entry of the tableau, diagonal included.
fn entry(row: usize, column: usize) -> f64 {
    match row.cmp(&column) {
        std::cmp::Ordering::Greater => ROWS[row][column],
        std::cmp::Ordering::Equal if row > 0 => G,
        _ => 0.0,
    }
}

fn tableau() -> Tableau<f64> {
    let mut a = SmallMat::zeros(STAGES, STAGES);
    let (mut b, mut c, mut d) = (SmallVec::zeros(STAGES), SmallVec::zeros(STAGES), SmallVec::zeros(STAGES));
    for row in 0..STAGES {
        for column in 0..STAGES {
            a[(row, column)] = entry(row, column);
            c[row] += entry(row, column);
        }
        b[row] = entry(STAGES - 1, row);
        d[row] = entry(STAGES - 1, row) - entry(STAGES - 2, row);
    }
    // The error estimate has order 4; this is the order that the step-size control needs.
    Tableau::new(a, b, c, d, 4, None)
}

type Matrix = NalgebraMat<f64>;

/// The error allowed in one step, relative to the tolerance of the whole solution: errors of steps add up.
const SHARE_OF_A_STEP: f64 = 0.1;

/// Builds the problem: `states` scaled, `segment` says what acts from outside.
pub(crate) fn problem(
    physics: &Arc<Physics>,
    segment: &Rc<Cell<Segment>>,
    start_s: f64,
    states: Vec<f64>,
    tolerance: f64,
) -> Result<
    OdeSolverProblem<impl OdeEquationsImplicit<M = Matrix, V = NalgebraVec<f64>, T = f64, C = NalgebraContext>>,
    DiffsolError,
> {
    let count = states.len();
    let tolerance = SHARE_OF_A_STEP * tolerance;
    let (rhs_physics, rhs_segment) = (Arc::clone(physics), Rc::clone(segment));
    let (jacobian_physics, jacobian_segment) = (Arc::clone(physics), Rc::clone(segment));
    let zeros = vec![Tangent::new(0.0, 0.0); count];
    let scratch = RefCell::new((zeros.clone(), zeros));
    let mut problem = OdeBuilder::<Matrix>::new()
        .t0(start_s)
        .h0(1e-6)
        .rtol(tolerance)
        .atol(vec![tolerance; count])
        .rhs_implicit(
            move |y, _p, t, rates| {
                rhs_physics.rates(&rhs_segment.get().inputs(&rhs_physics, t), y, rates);
            },
            move |y, _p, t, direction, product| {
                let (variables, rates) = &mut *scratch.borrow_mut();
                for ((variable, &value), &slope) in variables.iter_mut().zip(y).zip(direction) {
                    *variable = Tangent::new(value, slope);
                }
                let inputs = jacobian_segment.get().inputs(&jacobian_physics, t);
                jacobian_physics.rates(&inputs, variables, rates);
                for (target, rate) in product.iter_mut().zip(rates.iter()) {
                    *target = rate.slope;
                }
            },
        )
        .init(move |_p, _t, y| y.copy_from_slice(&states), count)
        .build()?;
    let options = &mut problem.ode_options;
    // The library counts them over the whole run; a kink may cause a few.
    options.max_nonlinear_solver_failures = usize::MAX;
    options.nonlinear_solver_tolerance = 0.02;
    options.min_timestep = 1e-16;
    options.max_timestep_growth = Some(5.0);
    options.min_timestep_growth = Some(1.2);
    options.min_timestep_shrink = Some(0.1);
    Ok(problem)
}

/// The solver, stopped and restarted at every corner of the input.
pub(crate) struct Stepper<'a, Equations>
where
    Equations: OdeEquationsImplicit<M = Matrix, V = NalgebraVec<f64>, T = f64, C = NalgebraContext>,
{
    solver: Sdirk<'a, Equations, NalgebraLU<f64>>,
    /// The step the error control would take if no stop were in its way, s.
    free_step_s: f64,
}

impl<'a, Equations> Stepper<'a, Equations>
where
    Equations: OdeEquationsImplicit<M = Matrix, V = NalgebraVec<f64>, T = f64, C = NalgebraContext> + 'a,
{
    pub(crate) fn new(problem: &'a OdeSolverProblem<Equations>) -> Result<Self, DiffsolError> {
        let tableau = tableau();
        let state: RkState<NalgebraVec<f64>> = problem.rk_state(&tableau)?;
        let solver = problem.sdirk_solver(state, tableau)?;
        let free_step_s = solver.state().h;
        Ok(Self { solver, free_step_s })
    }

    /// Scaled state `index`.
    pub(crate) fn state(&self, index: usize) -> f64 {
        self.solver.state().y.get_index(index)
    }

    /// Integrates to `end_s`, over an interval on which the input is smooth. The input may have jumped
    /// at the start.
    pub(crate) fn advance(&mut self, end_s: f64) -> Result<(), DiffsolError> {
        // An interval shorter than this is a rounding error between two corners that coincide.
        const SHORTEST_S: f64 = 1e-11;
        let problem = self.solver.problem();
        let free_step_s = self.free_step_s;
        let state = self.solver.state_mut();
        if end_s - *state.t < SHORTEST_S {
            *state.t = end_s;
            return Ok(());
        }
        problem.eqn.rhs().call_inplace(state.y, *state.t, state.dy);
        *state.h = free_step_s;
        self.solver.set_stop_time(end_s)?;
        loop {
            let left_s = end_s - self.solver.state().t;
            let reason = self.solver.step()?;
            let proposed_s = self.solver.state().h;
            match reason {
                OdeSolverStopReason::TstopReached => {
                    // A step that was shortened by the stop says little about the next step.
                    self.free_step_s = proposed_s.max(if left_s < self.free_step_s { self.free_step_s } else { 0.0 });
                    *self.solver.state_mut().t = end_s;
                    return Ok(());
                }
                OdeSolverStopReason::InternalTimestep | OdeSolverStopReason::RootFound(..) => {
                    self.free_step_s = proposed_s;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sums over the tableau that a method of order five must satisfy (Hairer & Wanner's trees).
    #[test]
    fn the_tableau_has_order_five_and_its_estimate_order_four() {
        let a = |i: usize, j: usize| entry(i, j);
        let c = |i: usize| (0..STAGES).map(|j| a(i, j)).sum::<f64>();
        let apply = |f: &dyn Fn(usize) -> f64, i: usize| (0..STAGES).map(|j| a(i, j) * f(j)).sum::<f64>();
        let ac = |i| apply(&c, i);
        let ac2 = |i| apply(&|j| c(j).powi(2), i);
        let ac3 = |i| apply(&|j| c(j).powi(3), i);
        let aac = |i| apply(&ac, i);
        let aac2 = |i| apply(&ac2, i);
        let acac = |i| apply(&|j| c(j) * ac(j), i);
        let aaac = |i| apply(&aac, i);
        let upto_four: [(&dyn Fn(usize) -> f64, f64); 8] = [
            (&|_| 1.0, 1.0),
            (&c, 1.0 / 2.0),
            (&|i| c(i).powi(2), 1.0 / 3.0),
            (&ac, 1.0 / 6.0),
            (&|i| c(i).powi(3), 1.0 / 4.0),
            (&|i| c(i) * ac(i), 1.0 / 8.0),
            (&ac2, 1.0 / 12.0),
            (&aac, 1.0 / 24.0),
        ];
        let five: [(&dyn Fn(usize) -> f64, f64); 9] = [
            (&|i| c(i).powi(4), 1.0 / 5.0),
            (&|i| c(i).powi(2) * ac(i), 1.0 / 10.0),
            (&|i| c(i) * ac2(i), 1.0 / 15.0),
            (&|i| c(i) * aac(i), 1.0 / 30.0),
            (&|i| ac(i).powi(2), 1.0 / 20.0),
            (&ac3, 1.0 / 20.0),
            (&acac, 1.0 / 40.0),
            (&aac2, 1.0 / 60.0),
            (&aaac, 1.0 / 120.0),
        ];
        let sum = |row: usize, f: &dyn Fn(usize) -> f64| (0..STAGES).map(|i| a(row, i) * f(i)).sum::<f64>();
        for (index, (tree, value)) in upto_four.iter().enumerate() {
            assert!((sum(STAGES - 1, tree) - value).abs() < 1e-13, "solution, tree {index}");
            assert!((sum(STAGES - 2, tree) - value).abs() < 1e-13, "estimate, tree {index}");
        }
        for (index, (tree, value)) in five.iter().enumerate() {
            assert!((sum(STAGES - 1, tree) - value).abs() < 1e-13, "solution, tree {index} of order five");
        }
    }
}
