//! A table for what no effect of the catalogue accounts for: better than nothing on the controller, and never a finding.
//!
//! Tables that suit the located link are first fitted roughly, together with the base parameters; the best of them are then fitted to the end.
//! A table is kept if it gains more than its values cost on left-out recordings, on all but one of them (what happens once is a disturbance),
//! and if the model with it follows the held-out recordings better: all together, at least half of them, and no signal clearly worse.

use identification::parallel;

use identification::experiment::Prepared;
use identification::fit::{Counts, Estimate, FitError, Free, Freedom, From, Residuals, fit, settle, standardised};
use machine_file::LoadSource;
use model_core::machine::{Machine, Parameter};
use recording::Signal;
use simulation::{InputPoint, simulate_f64};

use crate::catalogue::{Scene, Subsystem};
use crate::localisation::error_shape::Shape;
use crate::localisation::{Case, Location};
use crate::selection::decision_rule::{TABLE_GAINS, TABLE_MAY_LOSE_POINTS};
use crate::selection::{Candidate, Confirmation, Gained, Question, confirm};

/// The first, rough search ends when the loss falls by less than this share in a step.
const ROUGHLY: f64 = 0.03;
/// The same for the tables that are fitted to the end.
const PRECISION: f64 = 1e-4;
/// Number of tables that are fitted to the end.
const FINISHED: usize = 3;
/// Share of the rows that lie below the first node, and above the last.
const OUTSIDE: f64 = 0.01;
/// Usual size of a table's values, as a share of full force, full flow or full travel.
const USUAL: f64 = 0.05;
/// Nodes over the first state, and over the second.
const NODES: [usize; 2] = [7, 3];

/// The quantity that a table adds to, with its number in the machine file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Force on the rod; positive extends.
    Force = 1,
    /// Flow into A.
    FlowA = 2,
    /// Flow out of B.
    FlowB = 3,
    /// Spool travel after the lags.
    Travel = 4,
}

impl Quantity {
    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Force => "force on the rod",
            Quantity::FlowA => "flow into A",
            Quantity::FlowB => "flow out of B",
            Quantity::Travel => "spool travel",
        }
    }

    /// SI unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::Force => "N",
            Quantity::FlowA | Quantity::FlowB => "m3/s",
            Quantity::Travel => "1",
        }
    }

    fn usual(self, scene: &Scene<'_>) -> f64 {
        USUAL
            * match self {
                Quantity::Force => scene.full_force_n(),
                Quantity::FlowA | Quantity::FlowB => scene.full_flow_m3_per_s(),
                Quantity::Travel => 1.0,
            }
    }
}

/// A state that a table depends on, with its number in the machine file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableState {
    /// Velocity.
    Velocity = 1,
    /// Position.
    Position = 2,
    /// Spool.
    Spool = 3,
    /// Pressure in A.
    PressureA = 4,
    /// Pressure in B.
    PressureB = 5,
}

impl TableState {
    /// In words.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            TableState::Velocity => "velocity",
            TableState::Position => "position",
            TableState::Spool => "spool",
            TableState::PressureA => "pressure A",
            TableState::PressureB => "pressure B",
        }
    }

    /// SI unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        self.signal().si_unit().symbol()
    }

    fn signal(self) -> Signal {
        match self {
            TableState::Velocity => Signal::Velocity,
            TableState::Position => Signal::Position,
            TableState::Spool => Signal::Spool,
            TableState::PressureA => Signal::PressureA,
            TableState::PressureB => Signal::PressureB,
        }
    }
}

/// Nodes over one state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// The state.
    pub state: TableState,
    /// Value of the state at the first node, SI.
    pub from: f64,
    /// Value of the state at the last node, SI.
    pub to: f64,
    /// Nodes, equally spaced.
    pub nodes: usize,
}

/// A table with which the model follows the recordings better.
#[derive(Clone, Debug, PartialEq)]
pub struct Unnamed {
    /// What it adds to.
    pub quantity: Quantity,
    /// The states that it depends on: one or two.
    pub over: Vec<Axis>,
    /// Its values, row by row.
    pub values: Vec<Estimate>,
    /// Log-likelihood gained on left-out training recordings, less what its values cost.
    pub net: f64,
    /// What the held-out recordings said.
    pub confirmation: Confirmation,
}

/// A quantity, with the states over which a table of it is tried.
type Plan = (Quantity, &'static [TableState]);

/// Tables that suit the link, the likeliest first.
fn plans(subsystem: Subsystem) -> &'static [Plan] {
    use Quantity::{FlowA, FlowB, Force, Travel};
    use TableState::{Position, PressureA, PressureB, Spool, Velocity};
    match subsystem {
        Subsystem::Valve => &[
            (Travel, &[Spool]),
            (Travel, &[Spool, PressureA]),
            (Travel, &[Velocity]),
            (Travel, &[PressureA]),
            (FlowA, &[Spool]),
            (Force, &[Velocity]),
        ],
        Subsystem::Flow => &[
            (FlowA, &[Spool]),
            (FlowB, &[Spool]),
            (FlowA, &[Spool, PressureA]),
            (FlowB, &[Spool, PressureB]),
            (FlowA, &[PressureA]),
            (FlowB, &[PressureB]),
            (Travel, &[Spool]),
            (Force, &[Velocity]),
        ],
        Subsystem::Chambers => &[
            (FlowA, &[PressureA]),
            (FlowB, &[PressureB]),
            (FlowA, &[PressureB]),
            (FlowA, &[PressureA, Position]),
            (FlowA, &[Velocity]),
            (FlowB, &[Velocity]),
            (FlowA, &[Spool]),
            (Force, &[Velocity]),
        ],
        Subsystem::Mechanics | Subsystem::Sensing => &[
            (Force, &[Velocity]),
            (Force, &[Position]),
            (Force, &[Velocity, Position]),
            (Force, &[PressureA]),
            (Force, &[PressureB]),
            (Force, &[Velocity, PressureA]),
            (FlowA, &[Spool]),
            (Travel, &[Spool]),
        ],
    }
}

/// Whether the model has the quantity and the states at this input point.
fn applies(scene: &Scene<'_>, (quantity, states): &Plan) -> bool {
    let spool = matches!(scene.input_point, InputPoint::Command | InputPoint::Spool);
    let hydraulic = scene.input_point != InputPoint::Force;
    let states = states.iter().all(|state| match state {
        TableState::Velocity | TableState::Position => true,
        TableState::Spool => spool,
        TableState::PressureA | TableState::PressureB => hydraulic,
    });
    states
        && match quantity {
            // A load computed from the recorded pressures already contains every force.
            Quantity::Force => scene.load != LoadSource::RecordedPressures,
            Quantity::FlowA | Quantity::FlowB => hydraulic,
            Quantity::Travel => scene.input_point == InputPoint::Command,
        }
}

/// Whether a table can be tried: not for an error that happens once, since it is no function of the drive's state; and not where the machine already has a
/// table, or nothing was held out.
pub fn may_help(question: &Question<'_>, location: &Location, held: &[&Prepared]) -> bool {
    let once = matches!(location.shape, Shape::Once { .. });
    let has_one = question.scene.machine.get(Parameter::TableQuantity) != 0.0;
    !once && !has_one && !held.is_empty() && question.training.len() > 1
}

/// The base model with the best table, if it follows the held-out recordings better. None where [no table can be tried](may_help).
pub fn improved(
    question: &Question<'_>,
    base: &Candidate,
    location: &Location,
    cases: &[Case<'_>],
    held: &[&Prepared],
) -> Result<Option<(Candidate, Unnamed)>, FitError> {
    if !may_help(question, location, held) {
        return Ok(None);
    }
    let seen = Seen::of(&base.fit.machine, cases)?;
    let plans: Vec<&Plan> = plans(location.subsystem).iter().filter(|plan| applies(question.scene, plan)).collect();
    let with_axes = plans.into_iter().filter_map(|plan| Some((plan, seen.axes(plan.1)?)));
    let mut tables: Vec<(&Plan, Vec<Axis>, Candidate)> = parallel::try_each(with_axes, |(plan, axes)| {
        let candidate = fitted(question, base, None, plan.0, &axes, ROUGHLY)?;
        Ok::<_, FitError>((plan, axes, candidate))
    })?;
    tables.sort_by(|a, b| a.2.fit.loss.total_cmp(&b.2.fit.loss));
    tables.truncate(FINISHED);
    let left_out = base.left_out(question)?;
    let precision = if question.scene.is_sparse { base.precision(question) } else { PRECISION };
    let mut best: Option<(f64, Candidate, Quantity, Vec<Axis>)> = None;
    for (&(quantity, _), over, rough) in tables {
        let candidate = fitted(question, base, Some(&rough), quantity, &over, precision)?;
        let Some(net) = net(&left_out, &candidate.left_out(question)?, count(&over), question.counts()) else {
            continue;
        };
        if best.as_ref().is_none_or(|(known, ..)| net > *known) {
            best = Some((net, candidate, quantity, over));
        }
    }
    let Some((net, candidate, quantity, over)) = best else { return Ok(None) };
    // The held-out recordings take no part in the choice.
    let confirmation = confirm(base, &candidate, question.training, held)?;
    if !confirmation.gains_as_promised() || !fits_better(&base.fit.machine, &candidate.fit.machine, held)? {
        return Ok(None);
    }
    let mut values = candidate.estimates(question)?;
    values.retain(|estimate| Parameter::TABLE_VALUES.contains(&estimate.parameter));
    Ok(Some((candidate, Unnamed { quantity, over, values, net, confirmation })))
}

fn count(over: &[Axis]) -> usize {
    over.iter().map(|axis| axis.nodes).product()
}

/// The base model with a table, refitted.
fn fitted(
    question: &Question<'_>,
    base: &Candidate,
    rough: Option<&Candidate>,
    quantity: Quantity,
    over: &[Axis],
    precision: f64,
) -> Result<Candidate, FitError> {
    use Parameter as P;
    let mut machine = *question.scene.machine;
    machine.set(P::TableQuantity, f64::from(quantity as u8));
    let places = [(P::TableOver, P::TableFrom, P::TableTo), (P::TableOver2, P::TableFrom2, P::TableTo2)];
    for (axis, (state, from, to)) in over.iter().zip(places) {
        machine.set(state, f64::from(axis.state as u8));
        machine.set(from, axis.from);
        machine.set(to, axis.to);
    }
    let freedom = Freedom::Around { nominal: 0.0, sigma: quantity.usual(question.scene) };
    let values = P::TABLE_VALUES.into_iter().take(count(over)).map(|parameter| Free { parameter, freedom });
    let free: Vec<Free> = question.base_parameters.iter().copied().chain(values).collect();
    let from = From { solution: Some(&rough.unwrap_or(base).fit), ..From::default() };
    let fit = fit(&machine, &free, question.training, &from, precision)?;
    Candidate::of(question, Vec::new(), fit, Vec::new(), true)
}

/// Log-likelihood gained on left-out recordings less what `values` cost; none if that is too little, or if too few recordings gain.
fn net(before: &Residuals, after: &Residuals, values: usize, counts: Counts) -> Option<f64> {
    let gained = Gained::of(before, after, counts);
    let net = gained.all - gained.cost(values);
    (net > TABLE_GAINS && gained.repeats).then_some(net)
}

/// Whether the mean NRMSE fit on the held-out recordings rises, and no signal's falls clearly.
fn fits_better(before: &Machine<f64>, after: &Machine<f64>, held: &[&Prepared]) -> Result<bool, FitError> {
    let mut rises: Vec<(Signal, f64)> = Vec::new();
    for case in held {
        let from = standardised(before, case, settle(before, case)?)?;
        let to = standardised(after, case, settle(after, case)?)?;
        for (channel, (from, to)) in case.channels.iter().zip(from.iter().zip(&to)) {
            let rise = (channel.fit_percent(to) - channel.fit_percent(from)) / held.len() as f64;
            match rises.iter_mut().find(|(signal, _)| *signal == channel.signal) {
                Some((_, sum)) => *sum += rise,
                None => rises.push((channel.signal, rise)),
            }
        }
    }
    let sum: f64 = rises.iter().map(|(_, rise)| rise).sum();
    Ok(sum > 0.0 && rises.iter().all(|(_, rise)| *rise > -TABLE_MAY_LOSE_POINTS))
}

/// The values that the states took on the training recordings.
struct Seen(Vec<(TableState, Vec<f64>)>);

impl Seen {
    /// Simulated by the base model; the spool as recorded where it drives the model.
    fn of(machine: &Machine<f64>, cases: &[Case<'_>]) -> Result<Self, FitError> {
        const STATES: [TableState; 5] = [
            TableState::Velocity,
            TableState::Position,
            TableState::Spool,
            TableState::PressureA,
            TableState::PressureB,
        ];
        let mut seen: Vec<_> = STATES.map(|state| (state, Vec::new())).into();
        for case in cases {
            let trajectory = simulate_f64(machine, &case.prepared.stimulus, case.start.offset(machine, case.prepared))?;
            for (state, values) in &mut seen {
                let signal = state.signal();
                let series = trajectory.signal(signal).or_else(|| case.recording.signal(signal));
                values.extend(series.unwrap_or(&[]).iter().copied().filter(|value| value.is_finite()));
            }
        }
        for (_, values) in &mut seen {
            values.sort_by(f64::total_cmp);
        }
        Ok(Self(seen))
    }

    /// Nodes over the states; none where a state is constant. Velocity and spool have a node at 0.
    fn axes(&self, states: &[TableState]) -> Option<Vec<Axis>> {
        let axis = |(&state, nodes): (&TableState, usize)| {
            let (_, values) = self.0.iter().find(|(known, _)| *known == state)?;
            let last = values.len().checked_sub(1)? as f64;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index within the values")]
            let quantile = |share: f64| values.get((share * last).round() as usize).copied();
            let (low, high) = (quantile(OUTSIDE)?, quantile(1.0 - OUTSIDE)?);
            let (from, to) = if matches!(state, TableState::Velocity | TableState::Spool) {
                let most = low.abs().max(high.abs());
                (-most, most)
            } else {
                (low, high)
            };
            (to - from > 1e-9 * from.abs().max(to.abs()) && to > from).then_some(Axis { state, from, to, nodes })
        };
        states.iter().zip(NODES).map(axis).collect()
    }
}
