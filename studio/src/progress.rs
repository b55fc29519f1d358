//! How far a command is, told to the page.

use std::sync::atomic::{AtomicU64, Ordering};

use js_sys::Function;
use wasm_bindgen::JsValue;

/// Calls the page's function with what is done and with all there is to do.
#[derive(Debug)]
pub(crate) struct Progress<'a> {
    shown_by: &'a Function,
    done: AtomicU64,
}

impl<'a> Progress<'a> {
    pub(crate) fn shown_by(function: &'a Function) -> Self {
        Self { shown_by: function, done: AtomicU64::new(0) }
    }

    /// Adds what has been done meanwhile.
    #[expect(clippy::cast_precision_loss, reason = "a bar is not that long")]
    pub(crate) fn add(&self, more: u64, of: u64) {
        let done = self.done.fetch_add(more, Ordering::Relaxed) + more;
        // What a page does with it is its own affair.
        let _ = self.shown_by.call2(&JsValue::NULL, &JsValue::from_f64(done as f64), &JsValue::from_f64(of as f64));
    }
}
