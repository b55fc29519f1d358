//! A page's text with the names of signals as people say them: `pressure A`, where files and programs have `pressure_a`.
//!
//! It is done once, over the whole page, so that no sentence, table or list says it otherwise. What stands as code keeps its names: keys, commands. So do
//! the names that a user gave: headers of columns ([`own`]), recordings. A drawing says what its data say, which no script respells.

use maud::{Markup, html};
use recording::Signal;

use crate::plot::within_title;

/// Elements whose text is not prose.
const VERBATIM: [&str; 6] = ["code", "pre", "script", "style", "svg", "bdi"];

/// A name as it stands in a user's file.
pub(crate) fn own(name: &str) -> Markup {
    html! { bdi { (name) } }
}

/// The page with its signals' names as people say them, but for these names of recordings.
pub(crate) fn spoken(page: &str, recordings: &[&str]) -> String {
    let said = |text: &str| with_names(text, recordings);
    let mut result = String::with_capacity(page.len());
    let mut rest = page;
    while let Some(begins) = rest.find('<') {
        let (text, from_tag) = rest.split_at(begins);
        result += &said(text);
        let ends = from_tag.find('>').map_or(from_tag.len(), |at| at + 1);
        let (tag, after) = from_tag.split_at(ends);
        result += tag;
        // Up to where the element ends; a page has none within itself.
        let verbatim = VERBATIM.into_iter().find(|name| is_start_of(tag, name));
        let kept = verbatim.and_then(|name| after.find(&format!("</{name}>"))).unwrap_or(0);
        result += &after[..kept];
        rest = &after[kept..];
    }
    result + &said(rest)
}

fn is_start_of(tag: &str, name: &str) -> bool {
    tag.strip_prefix('<').and_then(|tag| tag.strip_prefix(name)).is_some_and(|rest| rest.starts_with([' ', '>']))
}

/// A text with the names of signals as people say them.
pub(crate) fn said(text: &str) -> String {
    with_names(text, &[])
}

/// A text with every word that is a signal's name, if it is no word that people say and none of these.
fn with_names(text: &str, kept: &[&str]) -> String {
    // A key such as `supply.tank_pressure_pa` is one word.
    let within = |letter: char| letter.is_alphanumeric() || matches!(letter, '_' | '.' | '-');
    let mut result = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(begins) = rest.find(within) {
        result += &rest[..begins];
        rest = &rest[begins..];
        let ends = rest.find(|letter| !within(letter)).unwrap_or(rest.len());
        let (word, after) = rest.split_at(ends);
        let (name, full_stop) = word.strip_suffix('.').map_or((word, ""), |name| (name, "."));
        match Signal::parse(name).filter(|_| name.contains('_') && !kept.contains(&name)) {
            Some(signal) => result += &(within_title(signal) + full_stop),
            None => result += word,
        }
        rest = after;
    }
    result + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signals_are_named_as_people_say_them_but_not_in_code_keys_or_attributes() {
        let page = "<p title=\"pressure_a\">seen in pressure_a, pressure_b.</p><code>pressure_a [bar]</code><td>supply.tank_pressure_pa</td><td>tank_pressure</td>";
        let expected = "<p title=\"pressure_a\">seen in pressure A, pressure B.</p><code>pressure_a [bar]</code><td>supply.tank_pressure_pa</td><td>tank pressure</td>";
        let spoken = |page: &str| spoken(page, &[]);
        assert_eq!(spoken(page), expected);
        assert_eq!(spoken("position of a spool"), "position of a spool");
        let script = "<script type=\"application/json\">{\"a\":\"pressure_a\"}</script>pressure_a";
        assert_eq!(spoken(script), "<script type=\"application/json\">{\"a\":\"pressure_a\"}</script>pressure A");
    }

    #[test]
    fn what_a_user_called_so_keeps_its_name() {
        let page = format!(
            "<p>{} of load_force: pressure_a</p><svg><text>tank_pressure</text></svg>",
            own("pressure_b raw").0
        );
        let expected =
            "<p><bdi>pressure_b raw</bdi> of load_force: pressure A</p><svg><text>tank_pressure</text></svg>";
        assert_eq!(spoken(&page, &["load_force"]), expected);
    }
}
