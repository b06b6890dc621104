//! No circles between files: reads the paths in every file of `src` and fails where two files, or more in a ring, need each other.
//!
//! A file needs another where it names an item of it, by `crate::`, `super::` or `self::`, directly or through a re-export. A module and
//! what is declared below it are not held apart: a parent frames its children, and these may use what it defines. Tests inside of
//! files do not count.

use super::{code, rust_files, src};
use std::collections::{BTreeMap, BTreeSet};

type Path = Vec<String>;

/// Circles that are known, with the reason why they stay.
const KNOWN: &[(&[&str], &str)] = &[
    (
        &["simulation/bump", "simulation/capture/params", "simulation/room/furniture", "simulation/room/stand"],
        "the settings of a capture hold those of its room, and what is put into the room is placed by those of the capture",
    ),
    (
        &["simulation/growth/params", "simulation/growth/presets"],
        "a preset is a set of parameters, and parameters are read on top of the preset that they name",
    ),
    (&["study/batch", "study/trial"], "a batch may be a trial, and a trial adds its captures to the batch"),
    (&["study/document", "study/plants"], "a document is read with the list of plants, which a section of it gives"),
    (
        &["study/origin", "study/scale", "study/settings"],
        "settings without a spacing find one from the cameras that they name, and keep it with where they came from",
    ),
];

/// Words and marks of Rust code.
fn tokens(code: &str) -> Vec<String> {
    let (mut tokens, mut word) = (Vec::new(), String::new());
    let mut chars = code.chars().peekable();
    while let Some(c) = chars.next() {
        if c.is_alphanumeric() || c == '_' {
            word.push(c);
            continue;
        }
        tokens.extend((!word.is_empty()).then(|| std::mem::take(&mut word)));
        if c == ':' && chars.next_if_eq(&':').is_some() {
            tokens.push("::".into());
        } else if !c.is_whitespace() {
            tokens.push(c.into());
        }
    }
    tokens
}

/// The paths that begin at `tokens[at]`, those of a group one by one, each with the name that it gets; and where they end.
fn paths(tokens: &[String], mut at: usize, before: &[String]) -> (Vec<(Path, String)>, usize) {
    let is = |at: usize, mark: &str| tokens.get(at).is_some_and(|t| t == mark);
    let mut path = before.to_vec();
    loop {
        if is(at, "{") {
            let mut all = Vec::new();
            at += 1;
            while at < tokens.len() && !is(at, "}") {
                let (found, end) = paths(tokens, at, &path);
                all.extend(found);
                at = if is(end, ",") { end + 1 } else { end.max(at + usize::from(!is(end, "}"))) };
            }
            return (all, at + 1);
        }
        let Some(word) = tokens.get(at) else { break };
        // `a::{self}` is `a`.
        if word != "self" || path.is_empty() {
            path.push(word.clone());
        }
        at += 1;
        if !is(at, "::") {
            break;
        }
        at += 1;
    }
    let mut name = path.last().cloned().unwrap_or_default();
    if is(at, "as") {
        name = tokens.get(at + 1).cloned().unwrap_or_default();
        at += 2;
    }
    (vec![(path, name)], at)
}

/// A file: the paths that it names, and what it hands on of others.
#[derive(Default)]
struct File {
    named: Vec<Path>,
    handed_on: BTreeMap<String, Path>,
}

impl File {
    fn read(code: &str) -> Self {
        let tests = code.find("#[cfg(test)]").into_iter().chain(code.find("#[cfg(all(test"));
        let tokens =
            tokens(&code[..tests.filter(|at| code[*at..].contains("mod tests {")).min().unwrap_or(code.len())]);
        let (mut file, mut at) = (Self::default(), 0);
        while at < tokens.len() {
            let begins = at == 0 || tokens[at - 1] != "::";
            let handed_on = tokens[at] == "use" && {
                // `pub` or `pub(...)` stands before it.
                let head = &tokens[at.saturating_sub(5)..at];
                head.iter().rposition(|t| t == "pub").is_some_and(|k| !head[k..].iter().any(|t| t == ";"))
            };
            if handed_on {
                let (found, end) = paths(&tokens, at + 1, &[]);
                file.handed_on.extend(found.into_iter().map(|(path, name)| (name, path)));
                at = end;
            } else if begins && ["crate", "super", "self"].contains(&tokens[at].as_str()) {
                let (found, end) = paths(&tokens, at, &[]);
                file.named.extend(found.into_iter().map(|(path, _)| path));
                at = end.max(at + 1);
            } else {
                at += 1;
            }
        }
        file
    }
}

/// Files by the path of their module.
struct House(BTreeMap<Path, File>);

impl House {
    /// The module whose file holds what `path` names, seen from `from`.
    fn home(&self, from: &[String], path: &[String], depth: usize) -> Option<Path> {
        let (mut at, mut rest) = (from.to_vec(), path);
        match rest.first()?.as_str() {
            "crate" => (at, rest) = (Vec::new(), &rest[1..]),
            "self" => rest = &rest[1..],
            _ => {}
        }
        while rest.first().is_some_and(|word| word == "super") {
            at.pop();
            rest = &rest[1..];
        }
        while let Some(word) = rest.first() {
            let below = [&at[..], std::slice::from_ref(word)].concat();
            if self.0.contains_key(&below) {
                (at, rest) = (below, &rest[1..]);
            } else {
                let on = self.0.get(&at).and_then(|file| file.handed_on.get(word)).filter(|_| depth < 8);
                return on.map_or(Some(at.clone()), |on| self.home(&at, on, depth + 1));
            }
        }
        Some(at)
    }

    /// Whom each file needs.
    fn needs(&self) -> BTreeMap<&Path, BTreeSet<Path>> {
        let of = |(module, file): (&Path, &File)| {
            let homes = file.named.iter().filter_map(|path| self.home(module, path, 0));
            homes.filter(|home| !home.starts_with(module) && !module.starts_with(home)).collect()
        };
        self.0.iter().map(|entry| (entry.0, of(entry))).collect()
    }

    /// The sets of files that need each other, sorted.
    fn circles(&self) -> Vec<Vec<String>> {
        let needs = self.needs();
        let reached = |from: &Path| {
            let (mut reached, mut open) = (BTreeSet::new(), vec![from.clone()]);
            while let Some(module) = open.pop() {
                open.extend(needs.get(&module).into_iter().flatten().filter(|m| reached.insert((*m).clone())).cloned());
            }
            reached
        };
        let all: BTreeMap<&Path, BTreeSet<Path>> = needs.keys().map(|module| (*module, reached(module))).collect();
        let circle = |module: &Path| -> Vec<String> {
            let with = all[module].iter().filter(|other| all.get(*other).is_some_and(|back| back.contains(module)));
            with.map(|path| path.join("/")).collect()
        };
        let circles: BTreeSet<Vec<String>> =
            all.keys().map(|module| circle(module)).filter(|c| !c.is_empty()).collect();
        circles.into_iter().collect()
    }
}

fn house() -> House {
    let module = |path: &std::path::Path| -> Path {
        let inside = path.strip_prefix(src()).expect("below src").with_extension("");
        let mut parts: Path = inside.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        parts.pop_if(|last| last == "mod");
        parts
    };
    let files = rust_files(&src()).into_iter().filter(|path| !path.ends_with("main.rs") && !path.ends_with("lib.rs"));
    House(files.map(|path| (module(&path), File::read(&code(&path)))).collect())
}

#[test]
fn files_do_not_need_each_other() {
    let known: Vec<Vec<String>> =
        KNOWN.iter().map(|(files, _)| files.iter().map(|f| (*f).to_owned()).collect()).collect();
    let found = house().circles();
    let new: Vec<_> = found.iter().filter(|circle| !known.contains(circle)).collect();
    assert!(new.is_empty(), "files that need each other; move what both need into a file of its own:\n{new:#?}");
    let gone: Vec<_> = known.iter().filter(|circle| !found.contains(circle)).collect();
    assert!(gone.is_empty(), "known circles that are none any more; take them off the list:\n{gone:#?}");
}

#[test]
fn a_ring_of_three_through_groups_and_what_is_handed_on_is_found() {
    let files = [
        ("room", "pub mod a; mod b; mod c; pub(crate) use b::{Big as Large, Other}; struct Own;"),
        ("room/a", "use super::{Own, Large}; fn f(_: Large) {}"),
        ("room/b", "use crate::{error::Error, room::c::{self, Thing}}; pub struct Big;"),
        ("room/c", "fn f() { super::a::g() } #[cfg(test)]\nmod tests { use crate::room::d::X; }"),
        ("room/d", "use super::c::f;"),
        ("error", "pub struct Error;"),
    ];
    let module = |name: &str| name.split('/').map(str::to_owned).collect();
    let house = House(files.iter().map(|(name, code)| (module(name), File::read(code))).collect());
    assert_eq!(house.circles(), [["room/a", "room/b", "room/c"]]);
}
