//! Everything that a board does, except its pins: keys move the rod through every part, and the recording comes out.

use firmware::app::press::{self, BY_HAND};
use firmware::app::{Assembly, Desk, DeskError, OperatorError, ROWS, StationError, Wired, wired};
use firmware::io::{AnalogIn, AnalogOut, PositionIn};
use firmware::period::{Answer, Report, Request, Timing, Watchdog};
use firmware::recorder::frame::FrameReader;
use firmware::recorder::message::Message;
use firmware::recorder::{Outbox, Recording};
use firmware::set_point::SetPoint;
use firmware::supervision::{Command, Fault, Mode};
use model_core::number::{Number, PerUnit};

use crate::Told;
use crate::following::plant;
use crate::world::{STROKE_M, World};

/// Types keys, and runs so many periods.
fn typed<A: AnalogIn, P: PositionIn, O: AnalogOut>(
    desk: &mut Desk<'_, A, P, O>,
    world: &mut World,
    told: &mut Told,
    keys: &str,
    periods: u32,
) -> (Report, Option<Answer>) {
    for key in keys.bytes() {
        desk.key(key).unwrap();
    }
    let first = desk.step(Timing::Kept, told);
    world.tick();
    let step = |_| {
        let report = desk.step(Timing::Kept, told);
        world.tick();
        report
    };
    ((1..periods).map(step).last().unwrap_or(first), first.answer)
}

#[test]
fn keys_move_the_rod_and_bring_its_record_out() {
    let mut world = World::of_press(plant(&press::machine()));
    let (mut memory, mut told) = (None, Told::default());
    let delay = &mut embedded_hal_mock::eh1::delay::NoopDelay::new();
    let (inputs, counter, output) = world.wires();
    let station = wired(inputs, counter, output, delay, &mut memory).unwrap();
    let mut desk = Desk::new(station, BY_HAND);
    let mut typed = |desk: &mut _, keys, periods| typed(desk, &mut world, &mut told, keys, periods);

    // The rod's position has not been given yet.
    typed(&mut desk, "", 200);
    assert_eq!(typed(&mut desk, "f", 1).1, Some(Answer::Lost));
    // 40 % of the stroke; what was recorded before counts from elsewhere.
    let (report, answer) = typed(&mut desk, "120zn\r\nf\r\n", 1);
    assert_eq!((report.mode, answer), (Mode::Following, Some(Answer::Taken)));
    assert_eq!(desk.key(b'z'), Err(DeskError::Operator(OperatorError::NoPosition { letter: b'z' })));
    assert_eq!("120z".bytes().map(|key| desk.key(key)).last(), Some(Err(DeskError::NotNeutral)));

    typed(&mut desk, "", 600);
    let (report, _) = typed(&mut desk, "t150g", 2500);
    assert_eq!((report.mode, report.watchdog), (Mode::Following, Watchdog::Feed));
    let (_, answer) = typed(&mut desk, "140g", 4000);
    assert_eq!(answer, None);
    let (report, answer) = typed(&mut desk, "s", 1000);
    assert_eq!((report.mode, answer), (Mode::Neutral, Some(Answer::Taken)));

    // All at once, because nothing waits here; on a board between the periods.
    typed(&mut desk, "d", 1);
    let mut reader = FrameReader::new();
    let frames: Vec<_> = std::iter::from_fn(|| desk.byte()).filter_map(|byte| reader.take(byte)).collect();
    let mut rows = Vec::new();
    for frame in &frames {
        if let Message::Rows(some) = Message::of(frame).unwrap() {
            rows.extend(some.words().collect::<Vec<_>>().chunks_exact(5).map(|row| row[4]));
        }
    }
    assert_eq!((reader.losses().missing, reader.losses().refused), (0, 0));
    // Position is the last channel; its full scale is the stroke.
    let millimetres = |word: i16| f64::from(word) / 32_768.0 * STROKE_M * 1e3;
    let farthest = rows.iter().copied().max().unwrap();
    assert!((millimetres(farthest) - 150.0).abs() < 0.2, "{}", millimetres(farthest));
    assert!((millimetres(rows[0]) - 120.0).abs() < 0.1, "{}", millimetres(rows[0]));
    assert!((world.position_m - 0.14).abs() < 1e-3, "{}", world.position_m);
    assert_eq!(told.0, []);
}

#[test]
fn a_fault_freezes_the_recorder_with_as_much_from_before_it_as_was_asked_for() {
    let mut world = World::of_press(plant(&press::machine()));
    let (mut memory, mut told) = (None, Told::default());
    let delay = &mut embedded_hal_mock::eh1::delay::NoopDelay::new();
    let (inputs, counter, output) = world.wires();
    let assembly = Assembly::new(5_120_000, 20_000_000).unwrap().recording_before(2.5).unwrap();
    let mut station = assembly.wired(inputs, counter, output, delay, &mut memory).unwrap();
    assert!(station.home(PerUnit::saturated(0.4)));
    let set_point = SetPoint { position: PerUnit::saturated(0.4), velocity: PerUnit::ZERO };
    let mut run = |station: &mut Wired<'_, _, _, _>, world: &mut World, command, periods| {
        for period in 0..periods {
            let command = if period == 0 { command } else { None };
            station.step(&Request { set_point, command, timing: Timing::Kept }, &mut told);
            world.tick();
        }
    };
    run(&mut station, &mut world, None, 200);
    run(&mut station, &mut world, Some(Command::Follow), 3000);
    assert_eq!(station.recorder().recording(), Recording::Waiting);
    world.wired = false;
    run(&mut station, &mut world, None, 10);
    assert_eq!(station.recorder().recording(), Recording::Triggered);
    run(&mut station, &mut world, None, 4000);
    assert_eq!(station.recorder().recording(), Recording::Frozen);
    assert!(matches!(told.0[..], [Fault::OpenWire { .. }]), "{:?}", told.0);

    let (mut outbox, mut reader) = (Outbox::default(), FrameReader::new());
    outbox.send();
    let sent = std::iter::from_fn(|| outbox.next(station.recorder(), "press", 1_000_000));
    let header = sent.filter_map(|byte| reader.take(byte)).find_map(|frame| match Message::of(&frame).unwrap() {
        Message::Header(header) => Some((header.trigger - header.first, header.rows as usize)),
        _ => None,
    });
    assert_eq!(header, Some((2500, ROWS)), "rows before the trigger, and all of them");
}

#[test]
fn a_recorder_without_room_for_what_is_asked_for_is_refused() {
    for seconds in [6.0, -0.1, f64::NAN] {
        let refused = Assembly::new(5_120_000, 20_000_000).unwrap().recording_before(seconds);
        assert!(matches!(refused, Err(StationError::Recorder(_))), "{seconds}");
    }
}
