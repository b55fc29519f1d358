//! The firmware's log on the emulated target, decoded: which link deviates, each fault once, and every change of the mode.

use defmt_decoder::{DecodeError, Table};

use system_tests::emulator::Processor;

/// Lines of a log, as level and text.
fn decoded(image: &[u8], log: &[u8]) -> Vec<String> {
    let table = Table::parse(image).unwrap().expect("an image with defmt holds its texts");
    let mut decoder = table.new_stream_decoder();
    decoder.received(log);
    let mut lines = Vec::new();
    loop {
        match decoder.decode() {
            Ok(frame) => {
                let level = frame.level().map_or("", |level| level.as_str());
                lines.push(format!("{level} {}", frame.display_message()));
            }
            Err(DecodeError::UnexpectedEof) => return lines,
            Err(DecodeError::Malformed) => panic!("a damaged frame after {lines:#?}"),
        }
    }
}

#[test]
fn the_link_that_misses_is_told_once_and_so_is_each_fault() {
    for processor in Processor::ALL {
        if !processor.can_be_emulated() {
            return;
        }
        let (image, log) = processor.log("log");
        let lines = decoded(&image, &log);
        println!("{processor:?}\n{}", lines.join("\n"));
        let untold = [" is off by ", " { from: "];
        let told: Vec<&str> = lines
            .iter()
            .map(|line| untold.iter().fold(line.as_str(), |line, rest| line.split(rest).next().unwrap_or(line)))
            .collect();
        assert_eq!(
            told,
            [
                "info mode: Starting -> Following",
                "warn alarm: Mechanics misses: Position",
                "error fault: Alarm { signal: Position, response: RampDown }",
                "info mode: Following -> RampingDown",
                "info mode: RampingDown -> Neutral",
                "error fault: MovesAtNeutral",
                "error fault: OpenWire { signal: PressureA, count: 0 }",
                "error fault: EncoderJump { counts: 10000 }",
            ],
            "{processor:?}"
        );
        let (_, much) = lines[1].split_once(" is off by ").unwrap();
        let (off, square) = much.split_once(" of its base, its mean square ").unwrap();
        let (off, square): (f64, f64) = (off.parse().unwrap(), square.parse().unwrap());
        // The position deviates from the model by 2 % of the stroke in all.
        assert!((0.001..0.02).contains(&off) && (1.0..32.0).contains(&square), "{much}");
    }
}
