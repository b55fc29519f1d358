//! What the monitor says of recordings as JSON, schema `host-sim/watch/1`: SI units, as in a machine file.

use serde_json::{Value, json};

use machine_file::{Band, MachineFile, Spread};
use watch::{Left, Seen, Watched};

use super::diagnosis::digits;

/// The document: the band of the file, and what was watched.
#[must_use]
pub fn watch(file: &MachineFile, all: &[Watched]) -> Value {
    json!({
        "schema": "host-sim/watch/1",
        "machine": file.name,
        "in_band": all.iter().all(|one| one.left.is_none()),
        "band": file.band.as_ref().map(band),
        "recordings": all.iter().map(recording).collect::<Vec<_>>(),
    })
}

fn band(band: &Band) -> Value {
    let spread = |of: Option<Spread>| {
        of.map(|of| json!({ "sigma": digits(of.sigma, 6), "correlation_s": digits(of.correlation_s, 6) }))
    };
    json!({
        "memory_s": digits(band.memory_s, 6),
        "spool": spread(band.spool),
        "pressure": spread(band.pressure),
        "position": spread(band.position),
    })
}

fn recording(one: &Watched) -> Value {
    let left = |left: &Left| {
        json!({
            "signal": left.signal.name(),
            "unit": left.signal.si_unit().symbol(),
            "link": left.link.name(),
            "at_s": digits(left.at_s, 6),
            "off_by": digits(left.off_by, 6),
        })
    };
    let seen = |seen: &Seen| {
        json!({
            "signal": seen.signal.name(),
            "mean_square": digits(seen.square, 4),
            "at_s": digits(seen.at_s, 6),
            "limit": digits(seen.limit, 4),
        })
    };
    json!({
        "recording": one.recording,
        "duration_s": digits(one.duration_s, 6),
        "in_band": one.left.is_none(),
        "left": one.left.as_ref().map(left),
        "signals": one.signals.iter().map(seen).collect::<Vec<_>>(),
    })
}
