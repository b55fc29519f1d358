//! Excitations at the keyboard: the rod moves as it should through every part, the recorder holds it, and every limit stays in force.

use firmware::app::press::{self, BY_HAND};
use firmware::app::{Desk, DeskError, OperatorError, Ring, Wired, wired};
use firmware::commissioning::CommissioningError;
use firmware::excitation::{Excitation, ExcitationError};
use firmware::period::{Report, Timing};
use firmware::recorder::frame::FrameReader;
use firmware::recorder::message::Message;
use firmware::set_point::Bounds;
use firmware::supervision::{Fault, Mode};

use crate::Told;
use crate::following::plant;
use crate::parts::{Adc, Counter, Dac, Wire};
use crate::world::{STROKE_M, World};

/// Where the rod stands, mm.
const START_MM: f64 = 120.0;

pub(crate) type TheDesk<'a> = Desk<
    'a,
    firmware::io::ads8688::Ads8688<Wire<Adc>>,
    firmware::io::ls7366r::Ls7366r<Wire<Counter>>,
    firmware::io::ad5754::Ad5754<Wire<Dac>>,
>;

/// A press with its desk.
pub(crate) struct Hall<'a> {
    pub(crate) world: World,
    pub(crate) desk: TheDesk<'a>,
    pub(crate) told: Told,
}

impl<'a> Hall<'a> {
    /// At rest, and not yet following.
    fn new(memory: &'a mut Option<Ring>) -> Self {
        Self::with(World::of_press(plant(&press::machine())), BY_HAND, memory)
    }

    /// The same with another press, or bounds.
    pub(crate) fn with(world: World, bounds: Bounds, memory: &'a mut Option<Ring>) -> Self {
        let delay = &mut embedded_hal_mock::eh1::delay::NoopDelay::new();
        let (inputs, counter, output) = world.wires();
        let station: Wired<'_, _, _, _> = wired(inputs, counter, output, delay, memory).unwrap();
        let mut hall = Self { world, desk: Desk::new(station, bounds), told: Told::default() };
        hall.run(200);
        hall
    }

    pub(crate) fn following(memory: &'a mut Option<Ring>) -> Self {
        let mut hall = Self::new(memory);
        hall.types("120zn f").unwrap();
        assert_eq!(hall.run(2500).mode, Mode::Following);
        hall
    }

    /// An encoder that turns round while something is played: the rod runs away, and that is told within so many periods. Once it is right again and the rod is
    /// at home, where these keys say, it follows and nothing goes on.
    pub(crate) fn loses_its_encoder(&mut self, within: usize, home: &str) {
        self.world.sense = -1;
        let periods = (1..=2000).find(|_| self.period().mode != Mode::Following);
        println!("{periods:?} periods: {:?}", self.told.0);
        assert!(periods.is_some_and(|periods| periods < within), "{periods:?} periods");
        let first = self.told.0[0];
        assert!(
            matches!(first, Fault::VelocityError { .. } | Fault::FollowingError { .. } | Fault::Alarm { .. }),
            "{first:?}"
        );
        self.world.sense = 1;
        self.run(2000);
        self.types(home).unwrap();
        self.run(200);
        self.types("f").unwrap();
        let before = self.run(500).followed.position;
        assert_eq!(self.run(3000).followed.position, before, "it stands");
    }

    pub(crate) fn types(&mut self, keys: &str) -> Result<(), DeskError> {
        keys.bytes().try_for_each(|key| self.desk.key(key))
    }

    pub(crate) fn period(&mut self) -> Report {
        let report = self.desk.step(Timing::Kept, &mut self.told);
        self.world.tick();
        report
    }

    pub(crate) fn run(&mut self, periods: u32) -> Report {
        (0..periods).map(|_| self.period()).last().unwrap()
    }

    /// The record: rows of command (10 V), spool, both pressures, position (stroke).
    pub(crate) fn record(&mut self) -> Vec<[f64; 5]> {
        self.types("d").unwrap();
        let mut reader = FrameReader::new();
        let frames: Vec<_> = std::iter::from_fn(|| self.desk.byte()).filter_map(|byte| reader.take(byte)).collect();
        let mut rows = Vec::new();
        for frame in &frames {
            if let Message::Rows(some) = Message::of(frame).unwrap() {
                let words: Vec<f64> = some.words().map(|word| f64::from(word) / 32_768.0).collect();
                rows.extend(words.chunks_exact(5).map(|row| <[f64; 5]>::try_from(row).unwrap()));
            }
        }
        assert_eq!((reader.losses().missing, reader.losses().refused), (0, 0));
        rows
    }
}

#[test]
fn a_sweep_is_played_through_every_part_and_the_recorder_holds_it_from_its_start_to_its_end() {
    let mut memory = None;
    let mut hall = Hall::following(&mut memory);
    hall.types("2e").unwrap();
    let mut farthest_mm = 0.0_f64;
    for _ in 0..4100 {
        let report = hall.period();
        assert_eq!(report.mode, Mode::Following);
        let error = report.measured.position.to_f64() - report.followed.position.to_f64();
        farthest_mm = farthest_mm.max(1e3 * STROKE_M * error.abs());
    }
    assert_eq!(hall.told.0, []);
    println!("{farthest_mm:.3} mm from its set point at most");
    // A third of what the limit of deviation permits; 0.48 mm were found.
    assert!(farthest_mm < 0.6, "{farthest_mm}");
    let at_the_end_mm = hall.world.position_m * 1e3;
    assert!((at_the_end_mm - START_MM).abs() < 0.1, "{at_the_end_mm}");

    // Two seconds of rest, four of the sweep.
    let offsets_mm: Vec<f64> = hall.record().iter().map(|row| row[4] * STROKE_M * 1e3 - START_MM).collect();
    assert_eq!(offsets_mm.len(), 6000);
    let largest = |rows: std::ops::Range<usize>| offsets_mm[rows].iter().fold(0.0_f64, |most, mm| most.max(mm.abs()));
    let turns = |rows: std::ops::Range<usize>| {
        // Around the mean of the stretch, with more than the encoder's step between.
        let (mut turns, mut above) = (0, false);
        for mm in &offsets_mm[rows] {
            turns += u32::from(!above && *mm > 0.03);
            above = if above { *mm > -0.03 } else { *mm > 0.03 };
        }
        turns
    };
    assert!(largest(0..1900) < 0.05, "{}", largest(0..1900));
    assert!(largest(2000..4500) > 1.5, "{}", largest(2000..4500));
    // 0.5·T/ln 20·(20^(t/T) − 1) turns: 2.3 in the first half, 10.4 in the second.
    assert!((1..=3).contains(&turns(2000..4000)), "{}", turns(2000..4000));
    assert!((8..=11).contains(&turns(4000..6000)), "{}", turns(4000..6000));
}

#[test]
fn every_excitation_is_played_without_a_fault_one_after_the_other() {
    let mut memory = None;
    let mut hall = Hall::following(&mut memory);
    for (number, excitation) in (1..).zip(&press::EXCITATIONS) {
        hall.types(&format!("{number}e")).unwrap();
        assert_eq!(hall.types("1e"), Err(OperatorError::Moving.into()));
        assert_eq!(hall.types("130g"), Err(OperatorError::Moving.into()));
        let report = hall.run(4000);
        assert_eq!((report.mode, &hall.told.0[..]), (Mode::Following, &[][..]), "{excitation:?}");
        assert_eq!(hall.record().len(), 6000);
        let at_the_end_mm = hall.world.position_m * 1e3;
        assert!((at_the_end_mm - START_MM).abs() < 0.1, "{excitation:?}: {at_the_end_mm}");
        hall.types("n").unwrap();
        hall.run(2100);
    }
    hall.types("130g").unwrap();
    assert_eq!(hall.run(3000).mode, Mode::Following);
}

#[test]
fn a_fault_ends_an_excitation_and_nothing_begins_it_again() {
    let mut memory = None;
    let mut hall = Hall::following(&mut memory);
    hall.types("2e").unwrap();
    hall.run(1500);
    assert_eq!(hall.told.0, []);
    hall.loses_its_encoder(500, "120za");
}

#[test]
fn a_stop_ends_it_by_the_ramp() {
    let mut memory = None;
    let mut hall = Hall::following(&mut memory);
    hall.types("2e").unwrap();
    hall.run(1200);
    hall.types("s").unwrap();
    assert_eq!(hall.run(1).mode, Mode::RampingDown);
    assert_eq!(hall.run(300).mode, Mode::Neutral);
    assert_eq!(hall.told.0, []);
}

#[test]
fn it_begins_only_while_the_rod_follows_at_rest_with_room_on_either_side_and_outside_the_commissioning() {
    let mut memory = None;
    let mut hall = Hall::new(&mut memory);
    assert_eq!(hall.types("2e"), Err(OperatorError::NotFollowing.into()));
    hall.types("120z").unwrap();
    assert_eq!(hall.types("2e"), Err(OperatorError::NotFollowing.into()));
    hall.types("1c").unwrap();
    hall.run(1);
    assert_eq!(hall.types("2e"), Err(CommissioningError::Busy.into()));
    // There is oil, so the first step is refused, and the commissioning has not ended.
    hall.run(1000);
    assert_eq!(hall.types("2e"), Err(CommissioningError::Unfinished.into()));

    let mut memory = None;
    let mut hall = Hall::following(&mut memory);
    let most = press::EXCITATIONS.len() + 1;
    assert_eq!(hall.types("e"), Err(OperatorError::NoExcitation { most }.into()));
    assert_eq!(hall.types("0e"), Err(OperatorError::NoExcitation { most }.into()));
    assert_eq!(hall.types("5e"), Err(OperatorError::NoExcitation { most }.into()));
    // 2 mm from the bound, where the sweep may need 10.
    hall.types("12g").unwrap();
    hall.run(8000);
    let Err(DeskError::Operator(OperatorError::Excitation(ExcitationError::Amplitude { amplitude_m, most_m }))) =
        hall.types("2e")
    else {
        panic!("it is played")
    };
    let Excitation::Sweep { amplitude_m: stated_m, .. } = press::EXCITATIONS[1] else { panic!("no sweep") };
    assert!((amplitude_m - stated_m).abs() < 1e-12 && (most_m - 2e-3).abs() < 1e-4, "{most_m}");
    assert_eq!(hall.run(10).mode, Mode::Following);
}
