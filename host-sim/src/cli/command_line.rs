//! The command line as a text that an error can point into.

use std::error::Error;
use std::ffi::OsString;
use std::fmt;
use std::num::{ParseFloatError, ParseIntError};
use std::ops::Range;

use clap::error::{ContextKind, ContextValue, ErrorKind};

use recording::files::source_error::{self, Explained, Place, quoted};

/// What messages call it.
const NAME: &str = "command line";

/// The words of a command line, as a shell would take them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CommandLine {
    text: String,
    /// Each word with its range of bytes in `text`, without quotation marks.
    words: Vec<(String, Range<usize>)>,
}

/// The part of an option that an error refers to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Part<'a> {
    /// The option itself.
    Option,
    /// Its first value.
    Value,
    /// The part of a value with this text.
    Text(&'a str),
    /// The value that equals this number.
    Number(f64),
}

/// An error about what was typed.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {found}; expected {expected}")]
pub(crate) struct Mistyped {
    pub(crate) place: Place,
    pub(crate) found: String,
    pub(crate) expected: String,
}

impl Explained for Mistyped {
    fn place(&self) -> &Place {
        &self.place
    }
    fn found(&self) -> String {
        self.found.clone()
    }
    fn expected(&self) -> String {
        self.expected.clone()
    }
}

impl fmt::Display for CommandLine {
    /// As it may be typed again.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl CommandLine {
    /// The command line of this process.
    #[must_use]
    pub fn of_process() -> Self {
        Self::of(std::env::args_os().skip(1))
    }

    /// The command line of these arguments.
    pub fn of(arguments: impl IntoIterator<Item = OsString>) -> Self {
        let mut line = Self { text: "host-sim".to_owned(), words: Vec::new() };
        for argument in arguments {
            // The command line is shown as one line, without control characters.
            let word: String =
                argument.to_string_lossy().chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
            let mark = quotation_mark(&word);
            line.text.push(' ');
            line.text.push_str(mark);
            let start = line.text.len();
            line.text.push_str(&word);
            line.words.push((word, start..line.text.len()));
            line.text.push_str(mark);
        }
        line
    }

    /// Where this part stands, in a value of this option (with its dashes or without); without an option, in any word.
    pub(crate) fn place(&self, option: Option<&str>, part: Part<'_>) -> Option<Place> {
        let mut ours = option.is_none();
        for (word, span) in &self.words {
            let mut value = span.clone();
            let is_option = word.starts_with("--") && word.len() > 2;
            if is_option {
                let name = word.split('=').next().unwrap_or(word);
                ours = option.is_none_or(|option| option.trim_start_matches('-') == name.trim_start_matches('-'));
                let name = span.start..span.start + name.len();
                if ours && part == Part::Option {
                    return Some(self.span(name));
                }
                value.start = (name.end + 1).min(span.end);
            }
            if ours && let Some(found) = within(&self.text[value.clone()], part) {
                return Some(self.span(value.start + found.start..value.start + found.end));
            }
        }
        None
    }

    fn span(&self, bytes: Range<usize>) -> Place {
        Place::in_line(NAME, 1, &self.text, bytes)
    }

    /// The message on a value that an argument refuses; `None` where clap's own message says as much, with the usage.
    #[must_use]
    pub fn explained(&self, error: &clap::Error) -> Option<String> {
        let text = |kind| match error.get(kind) {
            Some(ContextValue::String(text)) => Some(text.as_str()),
            _ => None,
        };
        let (argument, value) = (text(ContextKind::InvalidArg)?, text(ContextKind::InvalidValue)?);
        if value.is_empty() || !matches!(error.kind(), ErrorKind::InvalidValue | ErrorKind::ValueValidation) {
            return None;
        }
        // `--tick <ms>`, or `<R.csv>` of a value without option.
        let option = argument.split([' ', '=']).next().filter(|name| name.starts_with("--"));
        let place = self.place(option, Part::Text(value))?;
        let (found, expected) = match (error.get(ContextKind::ValidValue), error.source()) {
            (Some(ContextValue::Strings(valid)), _) if !valid.is_empty() => {
                let nearest = text(ContextKind::SuggestedValue)
                    .map_or_else(String::new, |nearest| format!("; a similar one is `{nearest}`"));
                let found = format!("{} is not a value of {}", quoted(value), option.unwrap_or(argument));
                (found, format!("one of {}{nearest}", valid.join(", ")))
            }
            (_, Some(cause)) => refused(value, cause),
            _ => return None,
        };
        Some(source_error::render(&Mistyped { place, found, expected }))
    }
}

/// The message of a value's own reader.
fn refused(value: &str, cause: &(dyn Error + 'static)) -> (String, String) {
    if cause.is::<ParseFloatError>() {
        return (format!("{} is not a number", quoted(value)), "a number such as -12.5 or 1.5e-3".to_owned());
    }
    if cause.is::<ParseIntError>() {
        return (format!("{} is not a whole number", quoted(value)), "a whole number".to_owned());
    }
    let text = cause.to_string();
    match text.split_once(" is not in ") {
        Some((found, range)) => (format!("{} is out of range", quoted(found)), format!("a whole number in {range}")),
        None => split(&text),
    }
}

/// The found and the expected part of a message that has both.
pub(crate) fn split(message: &str) -> (String, String) {
    let (found, expected) = message.split_once("; expected ").unwrap_or((message, "another value"));
    (found.to_owned(), expected.to_owned())
}

/// The bytes of this part within a value.
fn within(value: &str, part: Part<'_>) -> Option<Range<usize>> {
    match part {
        Part::Option => None,
        Part::Value => (!value.is_empty()).then_some(0..value.len()),
        Part::Text(text) => value.find(text).map(|at| at..at + text.len()),
        Part::Number(number) => {
            value.parse::<f64>().is_ok_and(|read| read.total_cmp(&number).is_eq()).then_some(0..value.len())
        }
    }
}

/// The mark that a word needs on both sides, so that a shell takes it as one word.
fn quotation_mark(word: &str) -> &'static str {
    let plain = |c: char| c.is_alphanumeric() || "-_./:=,%+@^".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        ""
    } else if word.contains(['"', '$', '`', '\\', '!']) {
        "'"
    } else {
        "\""
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(words: &[&str]) -> CommandLine {
        CommandLine::of(words.iter().map(OsString::from))
    }

    fn marked(line: &CommandLine, option: Option<&str>, part: Part<'_>) -> Option<String> {
        let spot = line.place(option, part)?.spot?;
        Some(spot.text.chars().skip(spot.column - 1).take(spot.width).collect())
    }

    #[test]
    fn a_line_is_what_could_be_typed_again() {
        let line = line(&["compare", "--map", "position=Kolbenweg [mm]", "--plot=a b.svg", "$x", ""]);
        assert_eq!(line.text, "host-sim compare --map \"position=Kolbenweg [mm]\" \"--plot=a b.svg\" '$x' \"\"");
    }

    #[test]
    fn the_part_of_a_value_is_found_behind_its_option_only() {
        let line = line(&["plan", "foo", "--sensors", "position,foo:1mm", "--largest=-4.0", "--dither", "2", "foo"]);
        assert_eq!(line.place(Some("--sensors"), Part::Text("foo")).unwrap().spot.unwrap().column, 38);
        assert_eq!(marked(&line, Some("--largest"), Part::Number(-4.0)).unwrap(), "-4.0");
        assert_eq!(marked(&line, Some("--largest"), Part::Option).unwrap(), "--largest");
        assert_eq!(marked(&line, Some("dither"), Part::Value).unwrap(), "2");
        assert_eq!(marked(&line, Some("--dither"), Part::Text("foo")).unwrap(), "foo");
        assert_eq!(line.place(None, Part::Text("foo")).unwrap().spot.unwrap().column, 15);
        assert_eq!(marked(&line, Some("--out"), Part::Text("foo")), None);
    }
}
