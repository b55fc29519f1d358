//! The book, built: every chapter is in it, and every link of a built page leads somewhere.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use mdbook_driver::MDBook;
use mdbook_driver::book::BookItem;

use super::root;

/// A path without `..`, as a browser resolves it.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for component in path.components() {
        match component {
            Component::ParentDir => {
                plain.pop();
            }
            Component::CurDir => {}
            other => plain.push(other),
        }
    }
    plain
}

/// The values of an attribute in a page; the renderer writes them between double quotes.
fn values<'a>(page: &'a str, attribute: &str) -> Vec<&'a str> {
    let start = format!(" {attribute}=\"");
    page.split(&start).skip(1).filter_map(|rest| rest.split_once('"')).map(|(value, _)| value).collect()
}

/// Whether the target of a link in a built page exists: in the book or, outside it, in the repository, below which the book lies.
fn is_there(link: &str, page: &Path, book: &Path) -> bool {
    let (file, place) = link.split_once('#').map_or((link, None), |(file, place)| (file, Some(place)));
    let target = if file.is_empty() { page.to_owned() } else { plain(&page.parent().unwrap().join(file)) };
    if !target.starts_with(book) {
        let beyond = target.strip_prefix(book.parent().unwrap());
        return beyond.is_ok_and(|beyond| root().join(beyond).exists()) && place.is_none();
    }
    let has = |place: &str| std::fs::read_to_string(&target).is_ok_and(|page| values(&page, "id").contains(&place));
    target.is_file() && place.is_none_or(|place| place.is_empty() || has(place))
}

#[test]
fn the_book_is_built_and_no_link_in_it_is_dead() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().join("book");
    let mut book = MDBook::load(root().join("docs")).unwrap();
    book.config.build.build_dir.clone_from(&folder);
    book.build().unwrap();

    let pages: Vec<PathBuf> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "html"))
        // The print page repeats the links of the other pages; the other one is shown for missing pages.
        .filter(|path| !path.ends_with("print.html") && !path.ends_with("404.html"))
        .collect();
    let chapters = book.iter().filter(|item| matches!(item, BookItem::Chapter(_))).count();
    assert!(chapters >= 9 && pages.len() >= chapters, "{chapters} chapters, {pages:?}");
    let mut dead = Vec::new();
    for page in &pages {
        let text = std::fs::read_to_string(page).unwrap();
        for link in [values(&text, "href"), values(&text, "src")].concat() {
            if !link.contains(':') && !is_there(link, page, &folder) {
                dead.push(format!("{}: {link}", page.file_name().unwrap().display()));
            }
        }
    }
    assert!(dead.is_empty(), "dead links:\n{}", dead.join("\n"));
}

#[test]
fn every_document_is_a_chapter() {
    let docs = root().join("docs");
    let book = MDBook::load(&docs).unwrap();
    let chapters: BTreeSet<PathBuf> = book
        .iter()
        .filter_map(|item| match item {
            BookItem::Chapter(chapter) => chapter.source_path.clone(),
            _ => None,
        })
        .collect();
    let documents: BTreeSet<PathBuf> = std::fs::read_dir(&docs)
        .unwrap()
        .map(|entry| PathBuf::from(entry.unwrap().file_name()))
        .filter(|name| name.extension().is_some_and(|ending| ending == "md") && *name != *"SUMMARY.md")
        .collect();
    assert_eq!(documents, chapters, "documents and chapters of docs/SUMMARY.md");
}
