//! Everything that an instance remembers, to be stored and restored, in memory or as bytes.

use serde::{Deserialize, Serialize};

use simulation::{Inputs, Kept};

use crate::{Mode, Refusal};

/// The state of an instance at one moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// The [fingerprint](model_export::fmu::fingerprint) of the drive.
    pub(crate) drive: u64,
    pub(crate) mode: Mode,
    pub(crate) inputs: Inputs,
    pub(crate) position_start_m: f64,
    pub(crate) start_s: f64,
    pub(crate) ticks: u64,
    /// None while no drive has been put at rest.
    pub(crate) kept: Option<Kept>,
}

impl Snapshot {
    /// The snapshot as bytes; `token` identifies the FMU that it belongs to.
    pub(crate) fn to_bytes(&self, token: &str) -> Result<Vec<u8>, Refusal> {
        Ok(postcard::to_stdvec(&(token, self))?)
    }

    /// The snapshot from bytes that [`Snapshot::to_bytes`] gave for the same token.
    pub(crate) fn of_bytes(token: &str, bytes: &[u8]) -> Result<Self, Refusal> {
        // The token is read first, because the bytes after it may be unreadable if another version wrote them.
        let (found, rest): (&str, &[u8]) = postcard::take_from_bytes(bytes)?;
        if found != token {
            return Err(Refusal::ForeignState { found: found.to_owned(), expected: token.to_owned() });
        }
        Ok(postcard::from_bytes(rest)?)
    }
}
