//! A period over devices that are awaited does what the blocking one does.

use std::cell::RefCell;
use std::future::poll_fn;
use std::pin::pin;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use firmware::io::asynchronous;
use firmware::io::{AnalogIn, AnalogOut, FromFn, PositionIn};
use firmware::measured::AnalogSignal;
use firmware::period::{BeginError, Devices, Period, Place};
use pollster::block_on;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::anything::{Anything, anything, wide};
use crate::bench::{STROKE, Shared, Told, Wanting, World, devices, limits, percent, rig};

/// A device that is awaited: it answers when it is asked a second time.
struct Awaited<D>(D);

/// Pending once.
async fn later() {
    let mut asked = false;
    poll_fn(|context| {
        if asked {
            return Poll::Ready(());
        }
        asked = true;
        context.waker().wake_by_ref();
        Poll::Pending
    })
    .await;
}

impl<D: AnalogIn> asynchronous::AnalogIn for Awaited<D> {
    type Error = D::Error;
    const SPAN_UV: u32 = D::SPAN_UV;

    async fn convert(&mut self, channel: u8) -> Result<i32, D::Error> {
        later().await;
        self.0.convert(channel)
    }
}

impl<D: AnalogOut> asynchronous::AnalogOut for Awaited<D> {
    type Error = D::Error;
    const SPAN_UV: u32 = D::SPAN_UV;

    async fn write(&mut self, count: i32) -> Result<(), D::Error> {
        later().await;
        self.0.write(count)
    }
}

impl<D: PositionIn> asynchronous::PositionIn for Awaited<D> {
    type Error = D::Error;

    async fn count(&mut self) -> Result<i32, D::Error> {
        later().await;
        self.0.count()
    }
}

fn awaited(
    world: &Shared,
) -> Devices<
    impl asynchronous::AnalogIn + use<>,
    impl asynchronous::PositionIn + use<>,
    impl asynchronous::AnalogOut + use<>,
> {
    let Devices { inputs, position, output } = devices(world);
    Devices { inputs: Awaited(inputs), position: Awaited(position), output: Awaited(output) }
}

fn worlds() -> [Shared; 2] {
    [(); 2].map(|()| Rc::new(RefCell::new(World { count: STROKE / 2, ..World::new() })))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, rng_seed: RngSeed::Fixed(20_201), ..ProptestConfig::default() })]
    #[test]
    fn whatever_comes_both_report_tell_ask_and_put_out_the_same(steps in prop::collection::vec(anything(), 1..250)) {
        let [one, other] = worlds();
        let mut blocking = Period::begin(devices(&one), rig(wide()), Wanting(one.clone()), Place::Known).unwrap();
        let begun = Period::begin_async(awaited(&other), rig(wide()), Wanting(other.clone()), Place::Known);
        let mut awaiting = block_on(begun).unwrap();
        let mut place = percent(50);
        for step in &steps {
            let enter = |world: &Shared| Anything::enter(step, &mut world.borrow_mut());
            enter(&one);
            enter(&other);
            if step.home {
                prop_assert_eq!(blocking.home(percent(50)), awaiting.home(percent(50)));
            }
            let request = step.request(place);
            let (mut told, mut told_too) = (Told::default(), Told::default());
            let report = blocking.step(&request, &mut told);
            prop_assert_eq!(report, block_on(awaiting.step_async(&request, &mut told_too)));
            prop_assert_eq!((told.faults, told.modes), (told_too.faults, told_too.modes));
            prop_assert_eq!(blocking.state(), awaiting.state());
            let (one, other) = (one.borrow(), other.borrow());
            prop_assert_eq!((one.asked, one.written), (other.asked, other.written));
            place = report.measured.position;
        }
    }
}

#[test]
fn a_counter_that_does_not_answer_is_told_at_the_start_and_a_voltage_is_read_between_two_periods() {
    let [world, _] = worlds();
    world.borrow_mut().position_silent = true;
    let begun = Period::begin_async(awaited(&world), rig(limits()), Wanting(world.clone()), Place::Known);
    assert!(matches!(block_on(begun).err(), Some(BeginError::Position(_))));
    assert_eq!(world.borrow().written, -2022); // −0.6172 V: neutral before anything else
    world.borrow_mut().position_silent = false;
    let begun = Period::begin_async(awaited(&world), rig(limits()), Wanting(world.clone()), Place::Known);
    let mut period = block_on(begun).unwrap();
    let read = block_on(period.voltage_async(AnalogSignal::PressureA)).unwrap().unwrap();
    assert_eq!((read.found_mv, read.from_mv, read.to_mv), (2500, 400, 4600));
    assert_eq!(block_on(period.voltage_async(AnalogSignal::OilTemperature)).unwrap(), None);
}

/// So that the comparison above means something: while a device is awaited the period hands the processor back, and has computed nothing yet.
#[test]
fn a_device_that_is_awaited_blocks_nobody() {
    let [world, _] = worlds();
    let begun = Period::begin_async(awaited(&world), rig(limits()), Wanting(world.clone()), Place::Known);
    let mut begun = pin!(begun);
    let mut context = Context::from_waker(Waker::noop());
    let asked = || world.borrow().asked;
    assert!(begun.as_mut().poll(&mut context).is_pending());
    assert_eq!(asked(), 0);
    assert!(begun.as_mut().poll(&mut context).is_pending());
    assert_eq!(asked(), 1);
    assert!(begun.as_mut().poll(&mut context).is_ready());
    assert_eq!(asked(), 2);
}

#[test]
fn a_closure_is_awaited_for_nothing() {
    let mut position = FromFn::<_>(|| Ok::<i32, ()>(5));
    let mut counted = pin!(asynchronous::PositionIn::count(&mut position));
    assert_eq!(counted.as_mut().poll(&mut Context::from_waker(Waker::noop())), Poll::Ready(Ok(5)));
}
