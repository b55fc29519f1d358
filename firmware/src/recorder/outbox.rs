//! Sends a recording byte by byte: the next byte is fetched in the free time between two periods, so nothing waits for the line.

use heapless::Vec;

use super::frame::{FrameWriter, LARGEST};
use super::{Progress, Recorder, Stream};

/// The outgoing data: one frame at a time.
#[derive(Clone, Debug, Default)]
pub struct Outbox {
    /// `None` while nothing is requested.
    stream: Option<Stream>,
    frames: FrameWriter,
    frame: Vec<u8, LARGEST>,
    /// Bytes of the frame that have been sent.
    gone: usize,
}

impl Outbox {
    /// Requests what a recorder has frozen, from its start; a frame that is being sent is finished first.
    pub fn send(&mut self) {
        self.stream = Some(Stream::new());
    }

    /// The next byte, or none: nothing is requested, everything is sent, or the recorder has frozen nothing.
    pub fn next<const CHANNELS: usize, const ROWS: usize>(
        &mut self,
        recorder: &Recorder<CHANNELS, ROWS>,
        machine: &str,
        tick_ns: u32,
    ) -> Option<u8> {
        if self.gone == self.frame.len() {
            self.frame.clear();
            self.gone = 0;
            let stream = self.stream.as_mut()?;
            // A frame fits in its buffer, so writing it cannot fail.
            let progress = stream.write(recorder, machine, tick_ns, &mut self.frames, &mut self.frame);
            if !matches!(progress, Ok(Progress::More)) {
                self.stream = None;
            }
        }
        let byte = self.frame.get(self.gone).copied();
        self.gone += usize::from(byte.is_some());
        byte
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec as Bytes;

    use model_core::number::PerUnit;

    use super::*;
    use crate::recorder::{Channel, Range};

    fn recorder() -> Recorder<1, 400> {
        let channel = Channel { name: "position", unit: "m", base: 0.3, range: Range::One };
        let mut recorder = Recorder::new([channel], 100).unwrap();
        for tick in 0..1000 {
            if tick == 500 {
                recorder.trigger();
            }
            recorder.record(&[Some(PerUnit::from_bits(tick << 16))]);
        }
        recorder
    }

    fn all(outbox: &mut Outbox, recorder: &Recorder<1, 400>) -> Bytes<u8> {
        core::iter::from_fn(|| outbox.next(recorder, "press", 1_000_000)).collect()
    }

    #[test]
    fn what_goes_out_is_what_the_stream_writes() {
        let recorder = recorder();
        let (mut stream, mut frames, mut written) = (Stream::new(), FrameWriter::default(), Bytes::new());
        while stream.write(&recorder, "press", 1_000_000, &mut frames, &mut written) == Ok(Progress::More) {}
        let mut outbox = Outbox::default();
        assert_eq!(outbox.next(&recorder, "press", 1_000_000), None);
        outbox.send();
        let sent = all(&mut outbox, &recorder);
        assert_eq!(sent, written);
        assert!(sent.len() > 2 * LARGEST);
        assert_eq!(outbox.next(&recorder, "press", 1_000_000), None);
    }

    #[test]
    fn nothing_frozen_is_nothing_to_send_and_what_is_asked_for_anew_follows_a_whole_frame() {
        let mut fresh = recorder();
        fresh.arm();
        let mut outbox = Outbox::default();
        outbox.send();
        assert_eq!(outbox.next(&fresh, "press", 1_000_000), None);

        let recorder = recorder();
        let mut reader = crate::recorder::frame::FrameReader::new();
        outbox.send();
        let begun: Bytes<u8> = (0..10).filter_map(|_| outbox.next(&recorder, "press", 1_000_000)).collect();
        outbox.send();
        let frames = begun.into_iter().chain(all(&mut outbox, &recorder)).filter_map(|byte| reader.take(byte)).count();
        assert_eq!((reader.losses().missing, reader.losses().refused), (0, 0));
        assert!(frames > 6, "{frames}");
    }
}
