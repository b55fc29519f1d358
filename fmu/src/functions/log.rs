//! Where the messages of an instance go.

use std::ffi::{CString, c_void};

use super::pointers::{ERROR, Status, Text};
use crate::Refusal;

/// The tool's function for messages in FMI 3.0: environment, status, category, message.
pub(super) type Message = Option<unsafe extern "C" fn(*mut c_void, Status, Text, Text)>;
/// The one in FMI 2.0: environment, name of the instance, status, category, and a format of `printf` with its arguments.
pub(super) type Logger = Option<unsafe extern "C" fn(*mut c_void, Text, Status, Text, Text, ...)>;

/// A tool's log, by the version of the standard.
pub(super) enum Log {
    /// FMI 2.0.
    Two { environment: *mut c_void, instance: CString, logger: Logger },
    /// FMI 3.0.
    Three { environment: *mut c_void, message: Message },
}

impl Log {
    /// Logs an error whether or not debug logging is on: without the message nobody learns why a simulation ends.
    pub(super) fn error(&self, call: &str, refusal: &Refusal) {
        let category = c"logStatusError".as_ptr();
        let said = format!("{call}: {refusal}");
        match self {
            Log::Two { environment, instance, logger: Some(logger) } => {
                // No argument follows; a # that is not doubled would mark a variable.
                let format = c_text(&said.replace('%', "%%").replace('#', "##"));
                // SAFETY: the function is the tool's, and the texts last until it returns.
                unsafe { logger(*environment, instance.as_ptr(), ERROR, category, format.as_ptr()) };
            }
            Log::Three { environment, message: Some(message) } => {
                let said = c_text(&said);
                // SAFETY: as above.
                unsafe { message(*environment, ERROR, category, said.as_ptr()) };
            }
            Log::Two { logger: None, .. } | Log::Three { message: None, .. } => {}
        }
    }
}

/// A text for C. None of the texts of this program holds a zero byte; a file's name might.
pub(super) fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}
