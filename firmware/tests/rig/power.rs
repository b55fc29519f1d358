//! Supplies that are lost within a frame, dip, or come late, and frames that arrive corrupted, for each part on its wire.

use firmware::io::ad5754::{Ad5754, Channel, Reference};
use firmware::io::ads8688::{Ads8688, Range};
use firmware::io::ls7366r::{FilterClock, Ls7366r};
use firmware::io::{AnalogIn, PositionIn};
use firmware::period::Watchdog;
use firmware::supervision::{Device, Fault, Mode};

use crate::Bench;
use crate::parts::{Part, WireState};
use crate::world::{World, simple_plant};

/// Frames of a part in a period, and the bytes of the longest.
const FRAMES: [usize; 3] = [4, 2, 3];
const BYTES: [usize; 3] = [6, 5, 3];
const DEVICES: [(Device, Mode); 3] =
    [(Device::Inputs, Mode::RampingDown), (Device::Position, Mode::Neutral), (Device::Output, Mode::Neutral)];

#[test]
fn a_supply_that_is_lost_or_dips_within_any_frame_is_found_in_this_period_or_the_next() {
    for (device, mode) in DEVICES {
        for frames in 0..FRAMES[device as usize] {
            for (bytes, stays_away) in (0..=BYTES[device as usize]).flat_map(|bytes| [(bytes, true), (bytes, false)]) {
                let mut bench = Bench::on_the_way();
                *bench.world.lines[device as usize].borrow_mut() = WireState::LosesPower { frames, bytes, stays_away };
                let which = format!("{device:?}, frame {frames}, byte {bytes}, stays away {stays_away}");
                let mut report = bench.step(None);
                if bench.told.0.is_empty() {
                    assert_eq!((report.mode, report.watchdog), (Mode::Following, Watchdog::Feed), "{which}");
                    report = bench.step(None);
                }
                let [Fault::Silent { device: found, .. }] = bench.told.0[..] else {
                    panic!("{which}: {:?}", bench.told.0)
                };
                assert_eq!(found, device, "{which}");
                assert_eq!((report.mode, report.watchdog), (mode, Watchdog::Withhold), "{which}");
            }
        }
    }
}

#[test]
fn one_corrupted_frame_of_the_counter_is_read_again_and_the_place_is_kept() {
    for frame in 0..FRAMES[Device::Position as usize] {
        for bit in 0..8 {
            let mut bench = Bench::on_the_way();
            // A byte of a count that is worth 256 counts and more, or the status.
            *bench.world.lines[Device::Position as usize].borrow_mut() = WireState::Flips(frame, 1 << bit);
            let report = bench.step(None);
            assert_eq!(bench.told.0, [], "frame {frame}, bit {bit}");
            assert_eq!((report.mode, report.watchdog), (Mode::Following, Watchdog::Feed));
            assert_eq!(*bench.world.lines[Device::Position as usize].borrow(), WireState::Whole, "it was corrupted");
            let position_m = report.measured.position.to_f64() * crate::STROKE_M;
            assert!((position_m - bench.world.position_m).abs() < 1e-3, "{position_m} {}", bench.world.position_m);
            assert_eq!(bench.run(100).unwrap().mode, Mode::Following);
            assert_eq!(bench.told.0, []);
        }
    }
}

/// Begins a part that sleeps for a number of frames, again and again; returns how often it was refused.
fn refused(
    name: &str,
    sleeps: usize,
    line: &std::cell::RefCell<WireState>,
    mut begin: impl FnMut() -> Result<(), String>,
) -> usize {
    *line.borrow_mut() = WireState::Sleeps(sleeps);
    for refused in 0..50 {
        if begin().is_ok() {
            assert!(sleeps < 3 || refused > 0, "{name} begins although it slept for {sleeps} frames");
            return refused;
        }
    }
    panic!("{name} does not begin after {sleeps} frames")
}

#[test]
fn a_part_whose_supply_comes_late_is_refused_until_it_is_there_and_is_then_set_up_whole() {
    for sleeps in 0..40 {
        let world = World::new(simple_plant());
        refused("output", sleeps, &world.lines[2], || {
            let delay = &mut embedded_hal_mock::eh1::delay::NoopDelay::new();
            let begun = Ad5754::begin(world.wire(&world.dac, 2), delay, Channel::B, Reference::External, 1000);
            begun.map(drop).map_err(|error| format!("{error:?}"))
        });
        let volts = world.dac.borrow().volts(1).unwrap();
        assert!((volts - 1000.0 / 3276.8).abs() < 1e-9, "{sleeps}: {volts}");

        let ranges = [Some(Range::Bipolar10V), Some(Range::Unipolar5V), None, None, None, None, None, None];
        world.adc.borrow_mut().inputs_v[1] = Some(2.56);
        let mut inputs = None;
        refused("inputs", sleeps, &world.lines[0], || {
            inputs = Some(Ads8688::begin(world.wire(&world.adc, 0), ranges).map_err(|error| format!("{error:?}"))?);
            Ok(())
        });
        let count = inputs.unwrap().convert(1).unwrap();
        assert_eq!(count, 32_768, "{sleeps}");

        let mut counter = None;
        refused("counter", sleeps, &world.lines[1], || {
            let begun = Ls7366r::begin(world.wire(&world.counter, 1), FilterClock::Undivided);
            counter = Some(begun.map_err(|error| format!("{error:?}"))?);
            Ok(())
        });
        world.counter.borrow_mut().turn(5);
        assert_eq!(counter.unwrap().count(), Ok(5), "{sleeps}");
    }
}

#[test]
fn a_part_that_loses_its_supply_is_as_after_power_on() {
    let world = World::new(simple_plant());
    world.counter.borrow_mut().lose_power();
    assert_eq!(world.counter.borrow_mut().frame(&[0x70, 0]), [0, 0b1100], "counting enabled, supply lost");
}
