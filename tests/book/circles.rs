//! No circle of imports between files of different folders: whoever reads a file need not have read those that use it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use petgraph::algo::tarjan_scc;
use petgraph::graphmap::DiGraphMap;
use quote::ToTokens;
use syn::visit::{self, Visit};
use syn::{Attribute, ItemMod, ItemUse, UseTree, Visibility};

use super::root;

/// A module's path below its crate.
type Module = Vec<String>;

/// What a file says of modules of its own crate.
#[derive(Default)]
struct Source {
    /// Paths as written, one for each imported name.
    uses: Vec<Vec<String>>,
    /// Paths under which it offers names of others again.
    offers: Vec<Vec<String>>,
}

/// Whether an item belongs to tests only.
fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg") && attribute.meta.to_token_stream().to_string().contains("test")
    })
}

/// Every name that a tree of imports brings in, with its path.
fn spread(tree: &UseTree, before: &[String], into: &mut Vec<Vec<String>>) {
    let with = |name: String| [before, &[name]].concat();
    match tree {
        UseTree::Path(path) => spread(&path.tree, &with(path.ident.to_string()), into),
        UseTree::Name(name) => into.push(with(name.ident.to_string())),
        UseTree::Rename(name) => into.push(with(name.ident.to_string())),
        UseTree::Glob(_) => into.push(before.to_vec()),
        UseTree::Group(group) => group.items.iter().for_each(|tree| spread(tree, before, into)),
    }
}

impl<'ast> Visit<'ast> for Source {
    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        if !is_for_tests(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        if !is_for_tests(&item.attrs) {
            let offers = !matches!(item.vis, Visibility::Inherited);
            spread(&item.tree, &[], if offers { &mut self.offers } else { &mut self.uses });
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        // A visibility names a module alone.
        if path.segments.len() > 1 && ["crate", "super"].iter().any(|top| path.segments[0].ident == top) {
            self.uses.push(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        }
        visit::visit_path(self, path);
    }
}

/// The files of a crate by module.
struct Sources(BTreeMap<Module, (PathBuf, Source)>);

impl Sources {
    fn of(folder: &Path) -> Self {
        let mut files = BTreeMap::new();
        let mut folders = vec![folder.to_owned()];
        while let Some(next) = folders.pop() {
            for entry in std::fs::read_dir(next).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|ending| ending == "rs") {
                    let below = path.strip_prefix(folder).unwrap().with_extension("");
                    let mut module: Module = below.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
                    if module.last().is_some_and(|last| ["mod", "lib", "main"].contains(&last.as_str())) {
                        module.pop();
                    }
                    let mut source = Source::default();
                    source.visit_file(&syn::parse_file(&std::fs::read_to_string(&path).unwrap()).unwrap());
                    files.insert(module, (path, source));
                }
            }
        }
        Self(files)
    }

    /// A path as written in a module, from the top of the crate; `None` where it leads out of the crate.
    fn absolute(&self, from: &[String], written: &[String]) -> Option<Module> {
        let climbs = written.iter().take_while(|part| *part == "super").count();
        match written[0].as_str() {
            "crate" => Some(written[1..].to_vec()),
            "self" => Some([from, &written[1..]].concat()),
            "super" => Some([&from[..from.len().checked_sub(climbs)?], &written[climbs..]].concat()),
            first => {
                let child = [from, &[first.to_owned()]].concat();
                self.0.contains_key(&child).then(|| [from, written].concat())
            }
        }
    }

    /// The module that defines what a path means, through names that are offered again.
    fn defines(&self, path: &[String]) -> Option<&Module> {
        let (module, (_, source)) = (0..=path.len()).rev().find_map(|length| self.0.get_key_value(&path[..length]))?;
        let Some(name) = path.get(module.len()) else { return Some(module) };
        let again = source.offers.iter().find(|offer| offer.last() == Some(name));
        let further = again.and_then(|offer| self.defines(&self.absolute(module, offer)?));
        Some(further.unwrap_or(module))
    }

    /// Circles of files in more than one folder.
    fn circles(&self) -> Vec<Vec<&Path>> {
        let mut imports: DiGraphMap<&Path, ()> = DiGraphMap::new();
        for (module, (path, source)) in &self.0 {
            for written in &source.uses {
                if let Some(used) = self.absolute(module, written).and_then(|path| self.defines(&path)) {
                    imports.add_edge(path, &self.0[used].0, ());
                }
            }
        }
        let folders = |circle: &Vec<&Path>| circle.iter().any(|path| path.parent() != circle[0].parent());
        tarjan_scc(&imports).into_iter().filter(folders).collect()
    }
}

#[test]
fn no_circle_of_imports_is_between_files_of_different_folders() {
    let crates = std::fs::read_dir(root().join("host-sim/crates")).unwrap().map(|entry| entry.unwrap().path());
    let others =
        ["model-core", "firmware", "firmware/boards/mps2", "firmware/boards/simulated-press", "host-sim", "fmu"]
            .map(|name| root().join(name));
    for folder in crates.chain(others) {
        let sources = Sources::of(&folder.join("src"));
        assert_eq!(sources.circles(), Vec::<Vec<&Path>>::new());
    }
}

/// So that the test above can fail.
#[test]
fn a_circle_between_two_folders_is_found_and_one_within_a_folder_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    write("lib.rs", "mod one; mod two; pub use one::One;");
    write("one/mod.rs", "mod inner; pub struct One; use inner::Inner;");
    write("one/inner.rs", "pub struct Inner; use super::One;");
    write("two.rs", "use crate::One; #[cfg(test)] mod tests { use crate::one::One; }");
    assert_eq!(Sources::of(folder.path()).circles(), Vec::<Vec<&Path>>::new());
    write("one/inner.rs", "pub struct Inner; fn f() { crate::two::f() }");
    let sources = Sources::of(folder.path());
    let circles = sources.circles();
    assert_eq!((circles.len(), circles[0].len()), (1, 3), "{circles:?}");
}
