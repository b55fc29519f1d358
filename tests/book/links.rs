//! Links of the documentation as it lies in the repository: as it is read there, and on a forge.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

use super::root;

/// The targets of a document's links, and the anchors in it.
#[derive(Debug, Default)]
struct Document {
    links: Vec<String>,
    anchors: BTreeSet<String>,
}

/// The anchor that forges give a heading: letters, digits, `-` and `_` in lower case, a space as `-`.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase().replace(' ', "-");
    kept.chars().filter(|&c| c.is_alphanumeric() || c == '-' || c == '_').collect()
}

fn document(text: &str) -> Document {
    let mut found = Document::default();
    let mut heading: Option<String> = None;
    for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
        match event {
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                found.links.push(dest_url.into_string());
            }
            Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
            Event::End(TagEnd::Heading(_)) => {
                let plain = anchor(&heading.take().unwrap_or_default());
                // A second heading of the same name gets a number.
                let numbered = (1..).map(|number| format!("{plain}-{number}"));
                let free = std::iter::once(plain.clone()).chain(numbered).find(|name| !found.anchors.contains(name));
                found.anchors.extend(free);
            }
            Event::Text(text) | Event::Code(text) => {
                if let Some(heading) = &mut heading {
                    heading.push_str(&text);
                }
            }
            _ => {}
        }
    }
    found
}

/// Every Markdown file that belongs to the repository and is not its history.
fn documents() -> Vec<PathBuf> {
    let folders = ["", "docs", "firmware", "firmware/boards", "examples", "presets", "tests", "fuzz"];
    let mut found = Vec::new();
    for folder in folders {
        let folder = root().join(folder);
        let inside = |path: &Path| -> Vec<PathBuf> {
            std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()).collect()
        };
        for path in inside(&folder) {
            let is_example = folder.ends_with("examples") || folder.ends_with("boards");
            let further = if is_example && path.is_dir() { inside(&path) } else { vec![path] };
            found.extend(further.into_iter().filter(|path| path.extension().is_some_and(|ending| ending == "md")));
        }
    }
    found.sort();
    found
}

#[test]
fn every_link_of_the_documentation_leads_to_a_file_and_a_heading_that_are_there() {
    let documents = documents();
    assert!(documents.iter().any(|path| path.ends_with("README.md")) && documents.len() > 10, "{documents:?}");
    let mut dead = Vec::new();
    for path in &documents {
        let read = document(&std::fs::read_to_string(path).unwrap());
        for link in read.links.iter().filter(|link| !link.contains("://") && !link.starts_with("mailto:")) {
            let (file, place) = link.split_once('#').map_or((link.as_str(), None), |(file, place)| (file, Some(place)));
            let target = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            let there = target.exists()
                && place.is_none_or(|place| {
                    std::fs::read_to_string(&target).is_ok_and(|text| document(&text).anchors.contains(place))
                });
            if !there {
                dead.push(format!("{}: {link}", path.display()));
            }
        }
    }
    assert!(dead.is_empty(), "dead links:\n{}", dead.join("\n"));
}

#[test]
fn a_link_to_what_is_not_there_would_be_seen() {
    let text = "# One `two`, *three*\n\n[a](b.md#c) ![d](e.svg)\n\n# Again\n\n# Again\n\n```\n[not](a.link)\n```\n";
    let found = document(text);
    assert_eq!(found.links, ["b.md#c", "e.svg"]);
    assert_eq!(found.anchors, ["again", "again-1", "one-two-three"].map(str::to_owned).into());
}
