//! The oil in each chamber changes by what flows in and out, and by nothing else. (1), (2), (7), (9)–(11)
//!
//! What a chamber holds beyond its volume at rest is C·p + A·y, with C = V/E0 and its hose. A tick of the core changes it by the
//! flows that the core returns. The integrator's truncation does not enter that balance at any tick, so only rounding may make it
//! miss. The rounding is summed tick by tick, from the formats (`fixed_point`): a gain and a product are half a step off, a pressure
//! carries the remainder of its rounding, a steep coefficient is off by half of its own step.

use proptest::prelude::*;

use model_core::drive::{Drive, DriveInput, Interfaces, Load};
use model_core::flow::PumpDrive;
use model_core::machine::{Machine, Parameter as P, Source, Tick};
use model_core::number::{PerUnit, Scalar};
use model_core::ports::{Flows, Spool};
use recording::excitation::signals::Excitation;
use system_tests::any_effects::{NO_FLOOR, any_side_effects};
use system_tests::any_machine::{any_machine, any_tick};
use system_tests::simulate::{DELAY, State, at_rest};
use virtual_plant::InitialState;

use super::cases;
use super::physics::gentle;

/// Half a step of a signal and of a gain.
const HALF: f64 = 1.0 / (1_u64 << 29) as f64;
/// Half a step of a steep coefficient.
const HALF_STEEP: f64 = 1.0 / (1_u64 << 17) as f64;
/// Largest steep coefficient that the core gives a stop.
const STEEPEST: f64 = 6e4;
/// Error of an inverse, as `fixed_point` states it.
const INVERSE: f64 = 2e-8;
/// Atmospheric pressure, Pa.
const ATMOSPHERE_PA: f64 = 1.013e5;

/// What rounding may do to a number of this type.
trait Rounded: Scalar<Real = f64> {
    /// Whether its coefficients and products are rounded to the formats above.
    const TO_FORMAT: bool;
    /// Largest value of a signal.
    const END: f64;
}

impl Rounded for f64 {
    const TO_FORMAT: bool = false;
    const END: f64 = f64::INFINITY;
}

impl Rounded for PerUnit {
    const TO_FORMAT: bool = true;
    const END: f64 = 8.0;
}

/// One chamber, in SI units.
struct Chamber {
    /// +1 where the rod makes room by extending.
    side: f64,
    area_m2: f64,
    volume_m3: f64,
    modulus_pa: f64,
    hose_m3_per_pa: f64,
    air: f64,
    follows: f64,
    stroke_m: f64,
    /// Least capacity that the format holds, m³/Pa.
    least_m3_per_pa: f64,
}

/// A capacity with the error that rounding may give it.
struct Capacity {
    m3_per_pa: f64,
    /// Relative error in fixed point.
    error: f64,
}

impl Chamber {
    fn of(machine: &Machine<f64>, drive: &Drive<impl Scalar<Real = f64>>, (area, volume, side): (P, P, f64)) -> Self {
        let bases = drive.bases();
        Self {
            side,
            area_m2: machine.get(area),
            volume_m3: machine.get(volume),
            modulus_pa: machine.get(P::BulkModulus),
            hose_m3_per_pa: machine.get(P::HoseCompliance),
            air: machine.get(P::AirShare),
            follows: machine.get(P::VolumeShare),
            stroke_m: machine.get(P::Stroke),
            least_m3_per_pa: bases.tick_s * bases.flow_m3_per_s / (3.9 * bases.pressure_pa),
        }
    }

    /// (7), with entrained air at the pressure halfway through a tick, and a volume that follows the piston, at its start. Signals are limited to `end`: a position in
    /// strokes, and a volume in volumes at mid-stroke.
    fn capacity(&self, pressure_pa: f64, strokes: f64, end: f64) -> Capacity {
        let oil = self.volume_m3 / self.modulus_pa;
        if self.air == 0.0 && self.follows == 0.0 {
            return Capacity { m3_per_pa: oil + self.hose_m3_per_pa, error: 0.0 };
        }
        let least = if self.follows == 0.0 {
            1.0
        } else {
            ((self.least_m3_per_pa - self.hose_m3_per_pa) / oil).clamp(0.02, 1.0)
        };
        let out = self.side * (strokes - 0.5).clamp(-end, end - 0.5);
        let reach = self.follows * self.area_m2 * self.stroke_m / self.volume_m3;
        let volume = (1.0 + reach * out).clamp(least, end);
        let thin = 1.0 / (1.0 + pressure_pa.max(0.0) / ATMOSPHERE_PA);
        let air = 0.75 * self.air * self.modulus_pa / ATMOSPHERE_PA;
        // Of bubbles with an exponent of 4/3.
        let soft = thin.powf(1.75);
        let whole = oil * (volume + air * volume * soft) + self.hose_m3_per_pa;
        // The core computes the capacity relative to the smallest one, 1 + (volume − least)·o + volume·soft·(air·o): o, air·o, the reach and
        // the pressure in atmospheres are steep coefficients, and soft has two roots.
        let smallest = oil * least + self.hose_m3_per_pa;
        let o = oil / smallest;
        let volume_error = HALF_STEEP * out.abs() + 2.0 * HALF * (1.0 + reach);
        let thin_error = INVERSE + HALF_STEEP * thin;
        let error = (o + air * o * soft) * volume_error
            + HALF_STEEP * (volume - least + volume * soft)
            + o * 2.0 * HALF
            + air * o * (volume * 1.75 * thin.powf(0.75) * thin_error + 6.0 * HALF);
        let share = smallest / whole;
        Capacity { m3_per_pa: whole, error: error * share + INVERSE / share }
    }
}

/// The value that should be found, and the difference that rounding may account for.
#[derive(Clone, Copy, Debug, Default)]
struct Account {
    should: f64,
    allowed: f64,
}

impl Account {
    fn add(&mut self, change: f64, allowed: f64) {
        self.should += change;
        self.allowed += allowed;
    }

    /// How far `found` is off, as a multiple of what is allowed.
    fn off(&self, found: f64) -> f64 {
        (found - self.should).abs() / self.allowed
    }
}

/// Balances of a drive: both pressures in supply pressures and the position in strokes, as computed from the flows and the velocity.
struct Books {
    chambers: [Chamber; 2],
    pressures: [Account; 2],
    position: Account,
    /// h·Q/p of the bases, m³/Pa.
    per_capacity: f64,
    ratio: f64,
    travel: f64,
    /// A void of 1, in ticks of flow 1.
    voids: f64,
}

impl Books {
    fn open<N: Rounded>(machine: &Machine<f64>, drive: &Drive<N>, state: &State<N>) -> Self {
        let bases = drive.bases();
        // A chamber that starts below its floor is lifted to it.
        let account = |start: N| Account {
            should: start.to_f64().max(floor(machine, drive)),
            allowed: if N::TO_FORMAT { HALF } else { 1e-15 },
        };
        let position = N::strokes(state.motion.position);
        Self {
            chambers: [(P::AreaA, P::VolumeA, 1.0), (P::AreaB, P::VolumeB, -1.0)]
                .map(|which| Chamber::of(machine, drive, which)),
            pressures: [account(state.chambers.a), account(state.chambers.b)],
            position: Account { should: position, allowed: 1e-15 },
            per_capacity: bases.tick_s * bases.flow_m3_per_s / bases.pressure_pa,
            ratio: machine.get(P::AreaB) / machine.get(P::AreaA),
            travel: bases.tick_s * bases.velocity_m_per_s / bases.stroke_m,
            voids: bases.void_m3() / (bases.tick_s * bases.flow_m3_per_s),
        }
    }

    /// Adds a tick from the state `before` to the state `after`. A rod that `met` a stop in this tick had that speed at both ends of it, added up.
    fn enter<N: Rounded>(
        &mut self,
        [before, after]: [&State<N>; 2],
        seen: &Interfaces<N>,
        pressure_pa: f64,
        met: Option<f64>,
    ) {
        let (qa, qb, v) = (seen.flows.a.to_f64(), seen.flows.b.to_f64(), seen.velocity.to_f64());
        let strokes = N::strokes(before.motion.position);
        // The flow that fills or closes a void does not raise the pressure.
        let [then, now] =
            [before, after].map(|state| [state.voids.a, state.voids.b].map(|void| self.voids * N::strokes(void)));
        let nets = [qa - v + now[0] - then[0], self.ratio * v - qb + now[1] - then[1]];
        let pressures = [before.chambers.a, before.chambers.b].map(Scalar::to_f64);
        // α is a gain, and the flow that B displaces is rounded before anything is subtracted from it.
        let nets_off = [0.0, HALF * (v.abs() + 1.0)];
        let midway = [seen.midway.a, seen.midway.b].map(Scalar::to_f64);
        for side in 0..2 {
            let capacity = self.chambers[side].capacity(midway[side] * pressure_pa, strokes, N::END);
            let per_net = self.per_capacity / capacity.m3_per_pa;
            let rise = per_net * nets[side];
            let varies = if capacity.error > 0.0 { 3.0 * HALF } else { HALF };
            let allowed = if N::TO_FORMAT {
                nets[side].abs() * (varies + per_net * capacity.error) + (per_net + varies) * nets_off[side]
            } else {
                0.0
            };
            self.pressures[side]
                .add(rise, allowed + 1e-15 * (pressures[side].abs() + rise.abs() + per_net * (then[side] + now[side])));
        }
        // A rod that meets a stop is set down on its face. The depth is a difference of two signals; the velocity is reduced by a steep coefficient
        // times the depth. For a very slow rod this coefficient is limited to the largest one, which removes less than the depth.
        let depth = 1.5 * self.travel * met.unwrap_or(0.0);
        let short = depth * (1.0 - STEEPEST * self.travel).max(0.0);
        let signals = if met.is_some() { 6.0 * HALF + HALF_STEEP * self.travel * depth } else { 0.0 };
        let allowed = short + if N::TO_FORMAT { HALF * v.abs() + signals } else { 0.0 };
        self.position.add(self.travel * v, allowed + 1e-15 * (strokes.abs() + (self.travel * v).abs()));
    }

    /// How far the state is off in each account, as a multiple of what rounding may do.
    fn off<N: Rounded>(&self, state: &State<N>) -> [f64; 3] {
        [
            self.pressures[0].off(state.chambers.a.to_f64()),
            self.pressures[1].off(state.chambers.b.to_f64()),
            self.position.off(N::strokes(state.motion.position)),
        ]
    }
}

/// What drives the model.
#[derive(Clone, Copy, Debug)]
enum Way {
    Command,
    Flow,
    Pump,
}

fn drive_input<N: Scalar>(way: Way, ratio: f64, volts: [f64; 2]) -> DriveInput<N> {
    let flows = |volts: f64| Flows { a: N::saturated(0.04 * volts), b: N::saturated(0.04 * ratio * volts) };
    let direction = if volts[1] > 0.0 { 1 } else { -1 };
    match way {
        Way::Command => DriveInput::Command(N::saturated(volts[1] / 10.0)),
        Way::Flow => DriveInput::Flow { from: flows(volts[0]), to: flows(volts[1]) },
        Way::Pump => DriveInput::Pump(PumpDrive { speed: N::saturated(volts[1].abs() / 10.0), direction }),
    }
}

/// The pressure below which no pressure falls, in supply pressures.
fn floor(machine: &Machine<f64>, drive: &Drive<impl Scalar<Real = f64>>) -> f64 {
    let floor_pa = machine.get(P::CavitationFloor);
    if floor_pa < -ATMOSPHERE_PA { f64::NEG_INFINITY } else { floor_pa / drive.bases().pressure_pa }
}

/// Largest error of both balances and of the rod's travel, as a multiple of what rounding may do, over a run or until the run comes near the
/// ends of the formats, ±8 of signals and ±128 strokes, where sums saturate and nothing can balance.
fn missed<N: Rounded>(machine: &Machine<f64>, tick: Tick, way: Way, volts: &[f64]) -> [f64; 3] {
    let drive = Drive::<N>::new::<DELAY>(machine, tick).unwrap();
    let middle_m = 0.5 * machine.get(P::Stroke);
    let mut state: State<N> = at_rest(&drive, 0.0, &InitialState::at_rest(machine, middle_m));
    let mut books = Books::open(machine, &drive, &state);
    let (mut missed, ratio) = ([0.0_f64; 3], machine.get(P::AreaB) / machine.get(P::AreaA));
    let stops = [P::StopRetracted, P::StopExtended].map(|stop| machine.get(stop) / machine.get(P::Stroke));
    let mut before_v = 0.0;
    for &now_v in volts {
        let before = state;
        let seen = drive.step(&mut state, drive_input(way, ratio, [before_v, now_v]), Load::NONE);
        before_v = now_v;
        let words = [seen.flows.a, seen.flows.b, seen.velocity, state.chambers.a, state.chambers.b];
        let at = N::strokes(state.motion.position);
        if words.iter().any(|word| word.to_f64().abs() > 3.5) || at.abs() > 100.0 {
            break;
        }
        let fast = [before, state].iter().map(|state| state.motion.velocity.to_f64().abs()).sum();
        let met = stops.iter().any(|stop| (at - stop).abs() < 1e-7);
        books.enter([&before, &state], &seen, drive.bases().pressure_pa, met.then_some(fast));
        let lowest = state.chambers.a.to_f64().min(state.chambers.b.to_f64());
        if lowest < floor(machine, &drive) - HALF {
            return [f64::INFINITY; 3];
        }
        for (missed, off) in missed.iter_mut().zip(books.off(&state)) {
            *missed = if off <= *missed { *missed } else { off };
        }
    }
    missed
}

/// What makes a chamber differ from (7), in sizes that suit a machine: external leakage, air, volumes that follow the piston, stops, oil
/// whose viscosity falls, a floor of the pressures.
#[derive(Clone, Copy, Debug)]
struct ChamberEffects {
    shares: [f64; 10],
    which: u8,
}

fn any_chamber_effects() -> impl Strategy<Value = ChamberEffects> {
    (prop::array::uniform10(0.0..1.0_f64), any::<u8>()).prop_map(|(shares, which)| ChamberEffects { shares, which })
}

impl ChamberEffects {
    fn on(&self, machine: &Machine<f64>) -> Machine<f64> {
        let decades = |share: f64, from: f64, to: f64| from * (to / from).powf(share);
        let on = |bit: u8, value: f64| if self.which >> bit & 1 == 1 { value } else { 0.0 };
        let [out_a, out_b, air, follows, within, stiffness, damping, thins, time, deep] = self.shares;
        let laminar = 0.05 * machine.get(P::FlowCoefficient) / machine.get(P::SupplyPressure).sqrt();
        let stroke_m = machine.get(P::Stroke);
        let (stiffness, damping) = (decades(stiffness, 1e6, 1e9), decades(damping, 1e2, 1e6));
        let reach_m = stroke_m * decades(within, 0.002, 0.5);
        machine.with(&[
            (P::ExternalLeakageA, on(0, out_a * laminar)),
            (P::ExternalLeakageB, on(1, out_b * laminar)),
            (P::AirShare, on(2, decades(air, 1e-4, 0.1))),
            (P::VolumeShare, on(3, follows)),
            (P::StopStiffness, on(4, stiffness)),
            (P::StopDamping, on(4, damping)),
            (P::StopRetracted, 0.5 * stroke_m - reach_m),
            (P::StopExtended, 0.5 * stroke_m + reach_m),
            (P::ViscosityLoss, on(5, 0.8 - 1.6 * thins)),
            (P::WarmingTime, decades(time, 0.1, 10.0)),
            (P::CavitationFloor, if self.which >> 6 & 1 == 1 { -ATMOSPHERE_PA * deep } else { NO_FLOOR.1 }),
        ])
    }
}

proptest! {
    #![proptest_config(cases(1500))]

    #[test]
    fn each_chamber_holds_what_flowed_into_it(
        machine in any_machine().prop_map(gentle),
        tick in any_tick(),
        effects in prop::option::of((any_side_effects(), any::<u16>())),
        own in prop::option::of(any_chamber_effects()),
        way in prop_oneof![4 => Just(Way::Command), 1 => Just(Way::Flow), 2 => Just(Way::Pump)],
        seed in any::<u64>(),
    ) {
        let mut machine = effects.map_or(machine, |(effects, which)| effects.on(&machine, |index| which >> index & 1 == 1));
        if let Way::Pump = way {
            machine.source = Source::Pump;
            machine.set(P::PumpDisplacement, machine.get(P::FlowCoefficient) * machine.get(P::SupplyPressure).sqrt() / 50.0);
            machine.set(P::ReturnCoefficient, machine.get(P::FlowCoefficient));
            machine.set(P::PumpSlip, machine.get(P::InternalLeakage));
        }
        let machine = own.map_or(machine, |own| own.on(&machine));
        prop_assume!(Drive::<PerUnit>::new::<DELAY>(&machine, tick).is_ok());
        let volts = &Excitation::random_steps(seed).sample(tick.seconds());
        let real = missed::<f64>(&machine, tick, way, volts);
        let fixed = missed::<PerUnit>(&machine, tick, way, volts);
        prop_assert!(real.iter().chain(&fixed).all(|missed| *missed <= 1.0), "A, B and the rod: {real:?}, in fixed point {fixed:?}");
    }
}

/// With a closed valve, and without external leakage, all the oil that leaves one chamber enters the other: exactly the same word, so that
/// not one step of oil is gained or lost over any time.
fn passed<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick, start: [f64; 3]) -> bool {
    let drive = Drive::<N>::new::<DELAY>(machine, tick).unwrap();
    let mut state: State<N> = at_rest(&drive, 0.0, &InitialState::at_rest(machine, 0.0));
    (state.chambers.a, state.chambers.b) = (N::saturated(start[0]), N::saturated(start[1]));
    state.motion.velocity = N::saturated(start[2]);
    let closed = Spool { from: N::ZERO, to: N::ZERO };
    (0..200).all(|_| {
        let seen = drive.step(&mut state, DriveInput::Spool(closed), Load::NONE);
        seen.flows.a == seen.flows.b
    })
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn what_leaks_out_of_one_chamber_is_in_the_other(
        machine in any_machine(),
        tick in any_tick(),
        start in prop::array::uniform3(-1.0..1.0_f64),
    ) {
        let machine = machine.with(&[(P::DeadZone, 0.05)]);
        prop_assert!(passed::<f64>(&machine, tick, start), "f64");
        prop_assert!(passed::<PerUnit>(&machine, tick, start), "fixed point");
    }
}
