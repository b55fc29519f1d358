//! A drive, as its machine file describes it.

use std::path::PathBuf;

use ::recording::ChannelMap;
use machine_file::{MachineFile, keys};
use model_core::machine::Parameter;
use pyo3::prelude::*;
use report::refused::Refused;

use crate::error::OrRaise;

/// A drive: the parameters of a machine file, SI, by their keys (`valve.gain_per_v`).
#[pyclass(frozen, module = "host_sim", skip_from_py_object)]
#[derive(Clone, Debug)]
pub(crate) struct Machine {
    /// The machine file as the user named it.
    pub(crate) path: String,
    pub(crate) file: MachineFile,
}

impl Machine {
    /// Which columns hold which signals: what is given here takes precedence over the machine file.
    pub(crate) fn channels(&self, maps: &[String]) -> Result<ChannelMap, Refused> {
        Ok(self.file.channels.clone().overlaid_with(&maps_of(maps)?))
    }

    /// Another machine file of the same drive.
    pub(crate) fn with(&self, file: MachineFile) -> Self {
        Self { path: self.path.clone(), file }
    }
}

/// The maps of `position=Kolbenweg [mm]`.
pub(crate) fn maps_of(maps: &[String]) -> Result<ChannelMap, Refused> {
    Ok(ChannelMap::from_arguments(maps.iter().map(String::as_str))?)
}

fn parameter(key: &str) -> Result<Parameter, Refused> {
    let found = Parameter::ALL.iter().copied().find(|parameter| parameter.description().key == key);
    let text = "is no parameter of a machine; expected a key of a machine file, such as valve.gain_per_v";
    found.ok_or_else(|| Refused::argument(key, text))
}

#[pymethods]
impl Machine {
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let file = machine_file::read(&path).or_raise(py)?;
        Ok(Self { path: path.display().to_string(), file })
    }

    #[staticmethod]
    fn from_toml(py: Python<'_>, text: &str, name: &str) -> PyResult<Self> {
        Ok(Self { path: name.to_owned(), file: machine_file::read_text(name, text).or_raise(py)? })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.file.name
    }

    #[getter]
    fn path(&self) -> &str {
        &self.path
    }

    #[getter]
    fn source(&self) -> &'static str {
        self.file.machine.source.name()
    }

    #[getter]
    fn effects(&self) -> Vec<&'static str> {
        self.file.effects.iter().copied().collect()
    }

    /// The keys that the file gives.
    fn keys(&self) -> Vec<&'static str> {
        self.file.given.iter().map(|parameter| parameter.description().key).collect()
    }

    fn __getitem__(&self, py: Python<'_>, key: &str) -> PyResult<f64> {
        parameter(key).map(|parameter| self.file.machine.get(parameter)).or_raise(py)
    }

    /// Unit, meaning, and least and largest value of a parameter.
    #[staticmethod]
    fn describe(py: Python<'_>, key: &str) -> PyResult<(&'static str, &'static str, f64, f64)> {
        let told = parameter(key).or_raise(py)?.description();
        Ok((told.unit, told.meaning, told.min, told.max))
    }

    /// This drive with other values, checked as those of a file.
    fn replaced(&self, py: Python<'_>, values: Vec<(String, f64)>) -> PyResult<Self> {
        let mut file = self.file.clone();
        for (key, value) in values {
            let parameter = parameter(&key).or_raise(py)?;
            file.machine.set(parameter, value);
            file.given.insert(parameter);
            file.effects.extend(keys::effect_of(keys::table_of(parameter)));
        }
        let text = file.to_text(&self.path).or_raise(py)?;
        Ok(self.with(machine_file::read_text(&self.path, &text).or_raise(py)?))
    }

    fn to_toml(&self, py: Python<'_>) -> PyResult<String> {
        self.file.to_text(&self.path).or_raise(py)
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        self.file.save(&path).or_raise(py)
    }
}
