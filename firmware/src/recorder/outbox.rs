//! A recording on its way out, byte by byte: whoever has a moment between two periods asks for the next byte, and nobody waits for a line.

use heapless::Vec;

use super::frame::{FrameWriter, LARGEST};
use super::{Progress, Recorder, Stream};

/// What goes out: one frame at a time.
#[derive(Clone, Debug, Default)]
pub struct Outbox {
    /// `None` where nothing is asked for.
    stream: Option<Stream>,
    frames: FrameWriter,
    frame: Vec<u8, LARGEST>,
    /// Bytes of the frame that have gone.
    gone: usize,
}

impl Outbox {
    /// Asks for what a recorder has frozen, from its start; the frame that is on its way is ended first.
    pub fn send(&mut self) {
        self.stream = Some(Stream::new());
    }

    /// The next byte, or none: nothing is asked for, all is out, or the recorder has frozen nothing.
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
            // A frame fits its room, so nothing refuses it.
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
