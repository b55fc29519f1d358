//! Errors about files, rendered for people: place, the line itself with carets, what was expected.

use std::fmt;

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

/// The characters of one line that an error is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spot {
    /// Line number, from 1.
    pub line: usize,
    /// Column of the first character concerned, counted in characters from 1.
    pub column: usize,
    /// Number of characters concerned; at least 1.
    pub width: usize,
    /// The line, without its end.
    pub text: String,
}

/// A part of a file that has no lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// What it is called, such as "channel `position`".
    pub name: String,
    /// A row of it, from 1.
    pub row: Option<usize>,
}

/// A file, and the line and column in it where they are known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file, as the user named it.
    pub file: Box<str>,
    /// Where the file has no lines: the part that is meant.
    pub part: Option<Box<Part>>,
    /// `None` when the error is about the file as a whole, or the file has no lines.
    pub spot: Option<Box<Spot>>,
}

impl Place {
    /// The file as a whole.
    #[must_use]
    pub fn file(file: &str) -> Self {
        Self { file: file.into(), part: None, spot: None }
    }

    /// A part of a file that has no lines, such as "channel `position`".
    #[must_use]
    pub fn part(file: &str, part: &str) -> Self {
        Self { part: Some(Box::new(Part { name: part.to_owned(), row: None })), ..Self::file(file) }
    }

    /// A row of a part, from 1.
    #[must_use]
    pub fn row_of(file: &str, part: &str, row: usize) -> Self {
        Self { part: Some(Box::new(Part { name: part.to_owned(), row: Some(row) })), ..Self::file(file) }
    }

    /// The bytes `span` of a line.
    ///
    /// A span that extends beyond the line is cut to it.
    #[must_use]
    pub fn in_line(file: &str, line: usize, text: &str, span: std::ops::Range<usize>) -> Self {
        let start = floor_boundary(text, span.start);
        let end = floor_boundary(text, span.end).max(start);
        let column = text[..start].chars().count() + 1;
        let width = text[start..end].chars().count().max(1);
        let spot = Spot { line, column, width, text: text.to_owned() };
        Self { spot: Some(Box::new(spot)), ..Self::file(file) }
    }

    /// The bytes `span` of a whole text; if a span covers several lines, only the first is marked.
    #[must_use]
    pub fn in_text(file: &str, text: &str, span: std::ops::Range<usize>) -> Self {
        let start = floor_boundary(text, span.start);
        let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |at| start + at);
        let line = text[..start].matches('\n').count() + 1;
        let content = text[line_start..line_end].trim_end_matches('\r');
        let end = span.end.min(line_end).saturating_sub(line_start);
        Self::in_line(file, line, content, start - line_start..end)
    }

    /// The line number, from 1, where there is one.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        self.spot.as_ref().map(|spot| spot.line)
    }

    /// The row of a part, from 1, where there is one.
    #[must_use]
    pub fn row(&self) -> Option<usize> {
        self.part.as_ref().and_then(|part| part.row)
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(spot) = &self.spot {
            return write!(f, ":{}:{}", spot.line, spot.column);
        }
        let Some(part) = &self.part else { return Ok(()) };
        write!(f, ", {}", part.name)?;
        part.row.map_or(Ok(()), |row| write!(f, ", row {row}"))
    }
}

/// An error that knows its place and what was expected there.
pub trait Explained: std::error::Error {
    /// Where it is.
    fn place(&self) -> &Place;
    /// What was found, without place.
    fn found(&self) -> String;
    /// What was expected instead, or what to do; a phrase without full stop.
    fn expected(&self) -> String;
    /// The key or the header of the column that it is about, where it is about one.
    fn key(&self) -> Option<String> {
        None
    }
}

/// The error as several lines of plain text, in the manner of a compiler's message:
///
/// ```text
/// error: column `position [mm]` holds `abc`
///   --> run.csv:3:5
///    |
///  3 | 0.1,abc
///    |     ^^^
///    |
///    = expected: a decimal number
/// ```
#[must_use]
pub fn render(error: &impl Explained) -> String {
    let found = error.found();
    let expected = error.expected();
    let place = error.place();
    let title = Level::ERROR.primary_title(found.as_str());
    let note = Level::NOTE.with_name("expected").message(expected.as_str());
    match &place.spot {
        None => format!("error: {found}\n  --> {place}\n   = expected: {expected}"),
        Some(spot) => {
            let start = byte_of_char(&spot.text, spot.column - 1);
            let end = byte_of_char(&spot.text, spot.column - 1 + spot.width);
            let snippet = Snippet::source(spot.text.as_str())
                .line_start(spot.line)
                .path(&*place.file)
                .annotation(AnnotationKind::Primary.span(start..end));
            Renderer::plain().render(&[title.element(snippet).element(note)])
        }
    }
}

/// Whether a text is a number, with a point or a comma.
pub(crate) fn is_number(text: &str) -> bool {
    text.replacen(',', ".", 1).parse::<f64>().is_ok()
}

/// A piece of a file for use in a message: short, and with control characters escaped.
pub fn quoted(text: &str) -> String {
    const LONGEST: usize = 60;
    if text.is_empty() {
        return "an empty cell".to_owned();
    }
    let mut short: String = text.chars().take(LONGEST).flat_map(visible).collect();
    if text.chars().nth(LONGEST).is_some() {
        short.push('…');
    }
    format!("`{short}`")
}

/// A count with its noun: `1 row`, `2 rows`.
pub(crate) fn counted(count: usize, thing: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {thing}{plural}")
}

/// A unit as it follows a number, with a space before it; a pure number has none.
pub fn after_number(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

/// A number rounded to six significant digits, which is enough for a duration.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// A number with all its digits. From a million on, and below a thousandth, it has a power of ten that is a multiple of three:
/// `0.25`, `31.5e6`.
pub fn engineering(value: f64) -> String {
    if value == 0.0 || !value.is_finite() || (1e-3..1e6).contains(&value.abs()) {
        return value.to_string();
    }
    let scientific = format!("{value:e}");
    let Some((mantissa, exponent)) = scientific.split_once('e') else { return scientific };
    let Ok(exponent) = exponent.parse::<i32>() else { return scientific };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let shift = usize::try_from(exponent.rem_euclid(3)).unwrap_or(0);
    let fraction = format!("{fraction:0<shift$}");
    let (moved, rest) = fraction.split_at(shift);
    let point = if rest.is_empty() { "" } else { "." };
    format!("{whole}{moved}{point}{rest}e{}", exponent.div_euclid(3) * 3)
}

/// A message that may contain names from files, made safe for a terminal, which would obey control characters: they are escaped.
pub fn printable(text: &impl fmt::Display) -> String {
    let kept = |character: char| matches!(character, '\n' | '\t');
    text.to_string()
        .chars()
        .flat_map(|character| {
            let plain = kept(character).then_some(character);
            plain.into_iter().chain(visible(character).filter(move |_| plain.is_none()))
        })
        .collect()
}

fn visible(character: char) -> impl Iterator<Item = char> {
    // The last two are not characters, and XML refuses them.
    let escaped = character.is_control() || matches!(character, '\u{fffe}' | '\u{ffff}');
    character.escape_debug().filter(move |_| escaped).chain((!escaped).then_some(character))
}

fn floor_boundary(text: &str, at: usize) -> usize {
    text.floor_char_boundary(at.min(text.len()))
}

fn byte_of_char(text: &str, count: usize) -> usize {
    text.char_indices().nth(count).map_or(text.len(), |(at, _)| at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("{place}")]
    struct Example {
        place: Place,
    }

    impl Explained for Example {
        fn place(&self) -> &Place {
            &self.place
        }
        fn found(&self) -> String {
            "column `position [mm]` holds `abc`".to_owned()
        }
        fn expected(&self) -> String {
            "a decimal number".to_owned()
        }
    }

    #[test]
    fn a_rendered_error_shows_the_line_and_marks_the_cell() {
        let place = Place::in_text("run.csv", "time\n°C\n0.1,abc\n", 13..16);
        let text = render(&Example { place });
        let expected = "\
error: column `position [mm]` holds `abc`
 --> run.csv:3:5
  |
3 | 0.1,abc
  |     ^^^
  |
  = expected: a decimal number";
        assert_eq!(text, expected);
    }

    #[test]
    fn an_error_about_the_whole_file_has_no_snippet() {
        let text = render(&Example { place: Place::file("run.csv") });
        assert!(text.contains("--> run.csv\n"), "{text}");
        assert!(text.contains("= expected: a decimal number"), "{text}");
    }

    #[test]
    fn a_part_of_a_file_without_lines_is_named() {
        let text = render(&Example { place: Place::part("run.mf4", "channel `position`") });
        assert!(text.contains("--> run.mf4, channel `position`\n"), "{text}");
        assert_eq!(Place::row_of("run.mf4", "channel `position`", 3).to_string(), "run.mf4, channel `position`, row 3");
    }

    #[test]
    fn columns_count_characters_and_odd_spans_are_cut() {
        let place = Place::in_line("f", 7, "°C;x", 4..5);
        assert_eq!(place.to_string(), "f:7:4");
        assert_eq!(Place::in_line("f", 1, "°", 1..900).to_string(), "f:1:1");
    }

    #[test]
    fn large_and_small_numbers_have_powers_of_thousand() {
        let told = [0.0, 0.25, -999_999.0, 31.5e6, 1e300, -1.234_567e8, 2e-5, f64::INFINITY].map(engineering);
        assert_eq!(told, ["0", "0.25", "-999999", "31.5e6", "1e300", "-123.4567e6", "20e-6", "inf"]);
        assert_eq!(engineering(rounded(1e300 / 3.0)), "333.333e297");
    }

    #[test]
    fn found_text_is_short_and_without_control_characters() {
        assert_eq!(quoted("a\u{1b}[1m"), "`a\\u{1b}[1m`");
        assert!(quoted(&"x".repeat(1000)).len() < 100);
    }
}
