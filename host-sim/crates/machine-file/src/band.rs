//! `[watch]`: how far the sensors of a healthy drive are from its model, and how long the average is over which that is judged.
//!
//! The same values as the settings of the controller's monitor. `host-sim watch --healthy` finds them.

use toml_edit::{DocumentMut, InlineTable, Item, TableLike, Value};

use crate::error::MachineFileError;
use crate::reader::{Reader, TABLE};
use crate::writer::{number, put, table};

/// The name of the table.
pub(crate) const WATCH: &str = "watch";
const MEMORY: &str = "memory_s";
const CORRELATION: &str = "correlation_s";
/// Longest memory, s: the monitor's.
const MOST_S: f64 = 1e3;

/// How far recorded signals spread about the simulated ones while the drive is as its file says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Of the spool, 1; `None` where it was not recorded.
    pub spool: Option<Spread>,
    /// Of either chamber pressure, Pa.
    pub pressure: Option<Spread>,
    /// Of the position, m.
    pub position: Option<Spread>,
    /// Time over which the squares are averaged, s.
    pub memory_s: f64,
}

/// How far the difference of recorded and simulated spreads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Standard deviation, in the signal's SI unit.
    pub sigma: f64,
    /// Time in which its correlation falls to e⁻¹, s.
    pub correlation_s: f64,
}

/// A signal's key, and the keys of its standard deviation with the unit of that.
const SIGNALS: [(&str, &str, &str); 3] =
    [("spool", "sigma", "1"), ("pressure", "sigma_pa", "Pa"), ("position", "sigma_m", "m")];

impl Band {
    /// The spread of each signal, in the order of [`SIGNALS`].
    fn spreads(&self) -> [Option<Spread>; 3] {
        [self.spool, self.pressure, self.position]
    }
}

impl Reader<'_> {
    /// Reads the table.
    pub(crate) fn band(&self, table: &dyn TableLike) -> Result<Band, MachineFileError> {
        let known = SIGNALS.map(|(signal, ..)| signal).into_iter().chain([MEMORY]).collect::<Vec<_>>();
        self.only(table, WATCH, &known)?;
        let memory = table.get(MEMORY).ok_or_else(|| MachineFileError::MissingKey {
            place: self.place(None),
            key: "watch.memory_s",
            unit: "s",
            meaning: "time over which the squares of the differences are averaged",
        })?;
        let memory_s = self.between(memory, "watch.memory_s", (0.0, MOST_S), "s")?;
        let spread = |(signal, sigma, unit): (&str, &'static str, &'static str)| {
            let Some(item) = table.get(signal) else { return Ok(None) };
            let name = format!("{WATCH}.{signal}");
            let given = item.as_table_like().ok_or_else(|| self.wrong_type(item, &name, TABLE))?;
            self.only(given, &name, &[sigma, CORRELATION])?;
            let Some(value) = given.get(sigma) else {
                let place = self.key_place(table, signal);
                let meaning = "standard deviation of recorded less simulated while the drive is healthy";
                return Err(MachineFileError::MissingKey { place, key: sigma, unit, meaning });
            };
            let sigma_si = self.between(value, &format!("{name}.{sigma}"), (f64::MIN_POSITIVE, f64::MAX), unit)?;
            let correlation = given.get(CORRELATION);
            let correlation_s = correlation
                .map_or(Ok(0.0), |item| self.between(item, &format!("{name}.{CORRELATION}"), (0.0, memory_s), "s"))?;
            Ok(Some(Spread { sigma: sigma_si, correlation_s }))
        };
        let [spool, pressure, position] = SIGNALS.map(spread);
        Ok(Band { spool: spool?, pressure: pressure?, position: position?, memory_s })
    }

    fn between(
        &self,
        item: &Item,
        key: &str,
        (min, max): (f64, f64),
        unit: &'static str,
    ) -> Result<f64, MachineFileError> {
        let value = self.number(item, key)?;
        if (min..=max).contains(&value) {
            return Ok(value);
        }
        Err(MachineFileError::OutOfRange { place: self.place(item.span()), key: key.to_owned(), value, min, max, unit })
    }
}

/// Writes the table where it differs from the one that stands there.
pub(crate) fn put_band(document: &mut DocumentMut, band: Option<&Band>, before: Option<&Band>) {
    if band == before {
        return;
    }
    let Some(band) = band else {
        document.remove(WATCH);
        return;
    };
    let written = table(document.as_table_mut(), WATCH);
    put(written, MEMORY, number(band.memory_s));
    for ((signal, sigma, _), spread) in SIGNALS.into_iter().zip(band.spreads()) {
        let Some(spread) = spread else {
            written.remove(signal);
            continue;
        };
        let mut values = InlineTable::new();
        values.insert(sigma, number(spread.sigma));
        values.insert(CORRELATION, number(spread.correlation_s));
        put(written, signal, Value::from(values));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_text;

    const DRIVE: &str =
        "[supply]\npressure_pa = 7e6\n[valve]\ngain_per_v = 0.06\n[cylinder]\narea_a_m2 = 3e-3\narea_b_m2 = 2e-3\n";

    fn refused(band: &str) -> String {
        read_text("d.toml", &format!("{DRIVE}[watch]\n{band}")).unwrap_err().to_string()
    }

    #[test]
    fn a_band_is_read_back_as_it_was_written_and_leaves_with_its_table() {
        let mut file = read_text("d.toml", DRIVE).unwrap();
        let spread = |sigma, correlation_s| Some(Spread { sigma, correlation_s });
        let band = Band { spool: None, pressure: spread(1.5e5, 0.02), position: spread(2.1e-4, 0.0), memory_s: 0.5 };
        file.band = Some(band);
        let text = file.to_text("d.toml").unwrap();
        assert!(text.contains("pressure = { sigma_pa = 150000.0, correlation_s = 0.02 }"), "{text}");
        let mut again = read_text("d.toml", &text).unwrap();
        assert_eq!(again.band, Some(band));
        again.band = None;
        assert!(!again.to_text("d.toml").unwrap().contains("watch"));
    }

    #[test]
    fn what_is_no_band_is_refused_with_its_key() {
        for (band, told) in [
            ("position = { sigma_m = 1e-4 }", "`watch.memory_s` is missing"),
            ("memory_s = 0.5\nposition = { sigma = 1e-4 }", "perhaps `sigma_m`"),
            ("memory_s = 0.5\nposition = { correlation_s = 0.1 }", "`sigma_m` is missing"),
            ("memory_s = 0.5\nposition = { sigma_m = 0.0 }", "`watch.position.sigma_m` is 0.0 m"),
            ("memory_s = 0.5\nposition = { sigma_m = 1e-4, correlation_s = 2.0 }", "0.0 to 0.5 s"),
            ("memory_s = 0.5\nposition = 1e-4", "`watch.position` is of type float"),
            ("memory_s = 0.5\nvelocity = { sigma = 1.0 }", "unknown key `velocity` in [watch]"),
            ("memory_s = \"1 s\"", "`watch.memory_s` is of type string"),
        ] {
            let message = refused(band);
            assert!(message.contains(told), "{band}: {message}");
        }
    }
}
