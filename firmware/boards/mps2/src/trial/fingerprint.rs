//! The fingerprint of a run: CRC-64/XZ of everything that the run computed.

use core::fmt;
use core::hash::Hasher;

use crc::{CRC_64_XZ, Crc, Digest};

static CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);

/// A running checksum that takes words by [`Hasher`] and text by [`fmt::Write`].
///
/// Lengths and discriminants enter as 64 bits, so that targets of any word length give the same result; all of them are little-endian.
#[derive(Clone)]
pub struct Fingerprint {
    digest: Digest<'static, u64>,
}

impl Fingerprint {
    /// With nothing entered yet.
    #[must_use]
    pub fn new() -> Self {
        Self { digest: CRC.digest() }
    }
}

impl Default for Fingerprint {
    fn default() -> Self {
        Self::new()
    }
}

impl fmt::Debug for Fingerprint {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "Fingerprint({:016x})", self.finish())
    }
}

impl Hasher for Fingerprint {
    fn write(&mut self, bytes: &[u8]) {
        self.digest.update(bytes);
    }

    fn write_usize(&mut self, word: usize) {
        self.write_u64(word as u64);
    }

    fn finish(&self) -> u64 {
        self.digest.clone().finalize()
    }
}

impl fmt::Write for Fingerprint {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.digest.update(text.as_bytes());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_catalogues_checksum() {
        let mut fingerprint = Fingerprint::new();
        fingerprint.write(b"1234");
        fmt::Write::write_str(&mut fingerprint, "56789").unwrap();
        assert_eq!(fingerprint.finish(), 0x995d_c9bb_df19_39fa, "the check value of CRC-64/XZ");
    }
}
