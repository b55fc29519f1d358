//! The studio: what `host-sim` does, for a page in a browser.
//!
//! A browser's worker holds one [`Studio`] with the bytes of the files that were dropped on the page. Each command takes a request as JSON and returns
//! its results as JSON: the program's text, its document for programs, the machine file, the page. They come from the same libraries as those of the
//! program. Nothing is read from or written to anywhere else.

mod commands;
mod compare;
mod desk;
mod diagnose;
mod fit;
mod inspect;
mod mapping;
mod progress;
mod sheet;

use js_sys::Function;
use wasm_bindgen::prelude::*;

use desk::Desk;
use progress::Progress;

/// The files of a page, and what can be done with them. Every error is a text for people.
#[wasm_bindgen]
#[derive(Debug, Default)]
pub struct Studio {
    desk: Desk,
}

#[wasm_bindgen]
impl Studio {
    /// Without a file. From here on a panic is an exception of JavaScript with its message, after which the worker is of no more use.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        #[cfg(target_family = "wasm")]
        std::panic::set_hook(Box::new(|panic| wasm_bindgen::throw_str(&panic.to_string())));
        Self::default()
    }

    /// Keeps a recording's file; one of the same name is replaced.
    pub fn put(&mut self, name: String, bytes: Vec<u8>) {
        self.desk.put(name, bytes);
    }

    /// Forgets a recording's file.
    pub fn remove(&mut self, name: &str) {
        self.desk.remove(name);
    }

    /// The items of a data sheet, as the form asks for them.
    pub fn questions(&self) -> String {
        sheet::questions().to_string()
    }

    /// The machine file of a filled form: `{"name", "over_both_edges", "answers": {flag: text}}`.
    pub fn machine_of_sheet(&self, form: &str) -> Result<String, String> {
        Ok(sheet::machine_file(&read(form)?)?)
    }

    /// The columns of the recordings with their guessed signals, and the signals that there are.
    pub fn columns(&self, request: &str) -> Result<String, String> {
        Ok(mapping::columns(&self.desk, &read(request)?)?.to_string())
    }

    /// The machine file with columns mapped by hand.
    pub fn mapped(&self, request: &str) -> Result<String, String> {
        Ok(mapping::written(&read(request)?)?)
    }

    /// What recordings hold and can test.
    pub fn inspect(&self, request: &str) -> Result<String, String> {
        told(&inspect::inspect(&self.desk, &read(request)?)?)
    }

    /// The fit of every measured signal; `progress` is called with the done share.
    pub fn compare(&self, request: &str, progress: &Function) -> Result<String, String> {
        told(&compare::compare(&self.desk, &read(request)?, &Progress::shown_by(progress))?)
    }

    /// A refit of the base parameters.
    pub fn fit(&self, request: &str, progress: &Function) -> Result<String, String> {
        told(&fit::fit(&self.desk, &read(request)?, &Progress::shown_by(progress))?)
    }

    /// What the model lacks.
    pub fn diagnose(&self, request: &str, progress: &Function) -> Result<String, String> {
        told(&diagnose::diagnose(&self.desk, &read(request)?, &Progress::shown_by(progress))?)
    }
}

/// What a request's JSON holds.
fn read<T: serde::de::DeserializeOwned>(request: &str) -> Result<T, String> {
    serde_json::from_str(request).map_err(|error| format!("a request of the page cannot be read: {error}"))
}

/// Results as JSON.
fn told(results: &commands::Results) -> Result<String, String> {
    serde_json::to_string(results).map_err(|error| format!("a result cannot be written: {error}"))
}
