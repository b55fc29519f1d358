//! What every command answers.

use serde::Serialize;

/// The results of a command; what it does not have is empty.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Results {
    /// What the program prints.
    pub(crate) text: String,
    /// What it says beside that.
    pub(crate) notes: Vec<String>,
    /// The document for programs, to the byte as the program writes it.
    pub(crate) json: String,
    /// The machine file that the program saves.
    pub(crate) machine: Option<String>,
    /// The page for people.
    pub(crate) page: Option<String>,
}
