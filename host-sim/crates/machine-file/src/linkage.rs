//! `[linkage]`: how the angle of a joint becomes the position of the rod, by the sides of a triangle or by a table.
//!
//! The sides are parameters of the machine, which the controller's encoder uses as well. The table is for recordings alone.

use std::sync::Arc;

use toml_edit::{Item, TableLike, Value};

use model_core::machine::{Machine, Parameter};
use recording::Linkage;
use recording::linkage::{Rises, Triangle};

use crate::error::MachineFileError;
use crate::keys;
use crate::reader::{NUMBER, Reader, as_number};

/// The table.
pub(crate) const LINKAGE: &str = "linkage";
/// Which way the angle rises.
pub(crate) const RISES: &str = "angle_rises";
/// The table's angles, as they are written.
pub(crate) const ANGLES: &str = "angles_rad";
const ANGLES_DEG: &str = "angles_deg";
/// The table's positions.
pub(crate) const POSITIONS: &str = "positions_m";
/// The keys of `[linkage]` that are no parameters of the machine.
pub(crate) const KEYS: [&str; 4] = [RISES, ANGLES_DEG, ANGLES, POSITIONS];
/// Without all of these there is no triangle.
const SIDES: [Parameter; 3] = [Parameter::LinkageBase, Parameter::LinkageArm, Parameter::LinkageLengthRetracted];

/// What `[linkage]` says beside the parameters.
#[derive(Default)]
pub(crate) struct Given {
    rises: Option<Rises>,
    angles_rad: Option<Vec<f64>>,
    positions_m: Option<Vec<f64>>,
}

impl Reader<'_> {
    /// Reads a key of `[linkage]` that is no parameter.
    pub(crate) fn linkage_key(
        &mut self,
        table: &dyn TableLike,
        key: &str,
        item: &Item,
    ) -> Result<(), MachineFileError> {
        match key {
            RISES => {
                let name = format!("{LINKAGE}.{RISES}");
                let found = self.string(item, &name)?;
                let rises = Rises::parse(found).ok_or_else(|| MachineFileError::UnknownChoice {
                    place: self.place(item.span()),
                    key: name,
                    found: found.to_owned(),
                    choices: "\"extending\" or \"retracting\"",
                })?;
                self.linkage.rises = Some(rises);
            }
            POSITIONS => self.linkage.positions_m = Some(self.numbers(key, item)?),
            _ if self.linkage.angles_rad.is_some() => {
                let (one, other) = if key == ANGLES { (ANGLES_DEG, ANGLES) } else { (ANGLES, ANGLES_DEG) };
                return Err(self.one_linkage(table, one, other));
            }
            _ => {
                let per_unit = if key == ANGLES_DEG { std::f64::consts::PI / 180.0 } else { 1.0 };
                let angles = self.numbers(key, item)?;
                self.linkage.angles_rad = Some(angles.into_iter().map(|angle| angle * per_unit).collect());
            }
        }
        Ok(())
    }

    fn numbers(&self, key: &str, item: &Item) -> Result<Vec<f64>, MachineFileError> {
        let name = format!("{LINKAGE}.{key}");
        let array = item.as_array().ok_or_else(|| self.wrong_type(item, &name, "an array of numbers"))?;
        let number = |value: &Value| {
            let place = || self.place(value.span());
            let Some(found) = as_number(value) else {
                let (key, found) = (name.clone(), value.type_name().to_owned());
                return Err(MachineFileError::WrongType { place: place(), key, found, expected: NUMBER });
            };
            if found.is_finite() {
                return Ok(found);
            }
            let (min, max, unit) = (f64::MIN, f64::MAX, "1");
            Err(MachineFileError::OutOfRange { place: place(), key: name.clone(), value: found, min, max, unit })
        };
        array.iter().map(number).collect()
    }

    fn one_linkage(&self, table: &dyn TableLike, one: &'static str, other: &'static str) -> MachineFileError {
        MachineFileError::TwoLinkages { place: self.key_place(table, other), one, other }
    }

    /// The linkage of recordings: of all three sides, or of a table.
    pub(crate) fn linkage(&self, root: &dyn TableLike) -> Result<Option<Arc<Linkage>>, MachineFileError> {
        let Some(table) = root.get(LINKAGE).and_then(Item::as_table_like) else { return Ok(None) };
        let (given, machine) = (&self.linkage, &self.result.machine);
        let linkage = match (&given.angles_rad, &given.positions_m) {
            (Some(angles), Some(positions)) => {
                let in_table = keys::in_table(LINKAGE).map(|(_, at)| at.key).chain([RISES]);
                if let Some(other) = in_table.into_iter().find(|key| table.contains_key(key)) {
                    return Err(self.one_linkage(table, POSITIONS, other));
                }
                Linkage::of_table(angles, positions)
            }
            (None, None) if SIDES.iter().all(|side| self.result.given.contains(side)) => {
                Linkage::of_sides(triangle(machine, given.rises.unwrap_or_default()), machine.get(Parameter::Stroke))
            }
            (None, None) => return Ok(None),
            (angles, _) => {
                let (place, unit) = (self.key_place(root, LINKAGE), "m");
                let (key, unit, meaning) = match angles {
                    Some(_) => ("linkage.positions_m", unit, "the position of the rod at each angle of the table"),
                    None => (
                        "linkage.angles_rad",
                        "rad",
                        "(or angles_deg) the recorded angle at each position of the table",
                    ),
                };
                return Err(MachineFileError::MissingKey { place, key, unit, meaning });
            }
        };
        let place = || self.key_place(root, LINKAGE);
        linkage
            .map(|linkage| Some(Arc::new(linkage)))
            .map_err(|cause| MachineFileError::Linkage { place: place(), cause })
    }
}

fn triangle(machine: &Machine<f64>, rises: Rises) -> Triangle {
    Triangle {
        base_m: machine.get(Parameter::LinkageBase),
        arm_m: machine.get(Parameter::LinkageArm),
        length_retracted_m: machine.get(Parameter::LinkageLengthRetracted),
        angle_at_zero_rad: machine.get(Parameter::LinkageAngleAtZero),
        rises,
    }
}
