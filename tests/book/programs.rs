//! The listings of programs with RTIC and Embassy in the book are those that the tests build and run.

use pulldown_cmark::{CodeBlockKind, Event, Parser, Tag, TagEnd};

use super::root;

/// The files that are listed, whole or in parts.
const LISTED: [&str; 5] = [
    "mps2-rtic/Cargo.toml",
    "mps2-rtic/.cargo/config.toml",
    "mps2-rtic/src/main.rs",
    "mps2-embassy/Cargo.toml",
    "mps2-embassy/src/main.rs",
];

/// Lines without indentation, empty ones, remarks of a configuration, and the folder that this repository builds into: a listing in the book may be without.
fn lines(text: &str) -> Vec<&str> {
    let left_out = |line: &&str| line.is_empty() || line.starts_with("# ") || line.starts_with("target-dir");
    text.lines().map(str::trim).filter(|line| !left_out(line)).collect()
}

/// The listings of a part of a chapter that are not compiled as documentation.
fn listings(chapter: &str) -> Vec<String> {
    let (mut found, mut listing) = (Vec::new(), None::<String>);
    for event in Parser::new(chapter) {
        match event {
            Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(kind))) if &*kind != "rust" => {
                listing = Some(String::new());
            }
            Event::Text(text) => listing.iter_mut().for_each(|listing| listing.push_str(&text)),
            Event::End(TagEnd::CodeBlock) => found.extend(listing.take()),
            _ => {}
        }
    }
    found
}

/// Whether a file has these lines one after the other.
fn has(file: &str, listing: &str) -> bool {
    let (file, listing) = (lines(file), lines(listing));
    file.windows(listing.len()).any(|window| window == listing)
}

#[test]
fn a_program_in_the_book_is_one_that_is_built_and_run() {
    let chapter = std::fs::read_to_string(root().join("docs/embedding.md")).unwrap();
    let (_, part) = chapter.split_once("\n## With RTIC or Embassy\n").unwrap();
    let (part, _) = part.split_once("\n## ").unwrap();
    let files = LISTED.map(|file| {
        let path = root().join("firmware/boards").join(file);
        std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    });
    let listings = listings(part);
    assert_eq!(listings.len(), 6);
    for listing in &listings {
        assert!(files.iter().any(|file| has(file, listing)), "in none of {LISTED:?}:\n{listing}");
    }
    let whole = lines(&files[2]);
    assert!(listings.iter().any(|listing| lines(listing) == whole), "the program with RTIC is listed whole");
}

/// So that the test above can fail.
#[test]
fn a_listing_with_another_line_is_none_of_a_file() {
    let file = "fn one() {\n    two();\n\n    three();\n}\n";
    assert!(has(file, "two();\nthree();"));
    assert!(!has(file, "two();\nfour();"));
    assert!(!has(file, "one();"));
}
