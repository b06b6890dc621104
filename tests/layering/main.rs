//! Imports run one way: reads every `crate::room` in `src` and fails on an arrow that runs back, and
//! holds the map of the house in ARCHITECTURE.md against the folders.

mod circles;

use std::fs;
use std::path::{Path, PathBuf};

const BASE: &[&str] = &["error", "math", "optics", "photo"];
const RECONSTRUCTION: &[&str] = &["calibration", "volume", "roots", "growth"];
const JUDGES: &[&str] = &["simulation", "evaluation"];

/// Each room with the rooms it may see.
const MAY_SEE: &[(&str, &[&[&str]])] = &[
    ("error", &[]),
    ("math", &[&["error"]]),
    ("optics", &[&["error", "math"]]),
    ("photo", &[&["error", "math", "optics"]]),
    ("calibration", &[BASE]),
    ("volume", &[BASE]),
    ("roots", &[BASE, &["volume"]]),
    ("growth", &[BASE, &["roots"]]),
    // The judge shares no code with the accused: neither `volume` nor `optics::inverse` (below).
    ("simulation", &[BASE, &["roots"]]),
    ("evaluation", &[BASE, &["volume", "roots", "simulation"]]),
    ("formats", &[BASE, RECONSTRUCTION, JUDGES]),
    ("report", &[BASE, RECONSTRUCTION, JUDGES, &["formats"]]),
    ("store", &[&["error"]]),
    ("flow", &[&["error", "store"]]),
    ("stages", &[BASE, RECONSTRUCTION, JUDGES, &["formats", "report", "store", "flow"]]),
    ("study", &[BASE, RECONSTRUCTION, JUDGES, &["formats", "report", "store", "flow", "stages"]]),
    ("view", &[BASE, RECONSTRUCTION, &["formats", "report", "store", "flow", "stages", "study"]]),
];

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).expect("folder is readable") {
        let path = entry.expect("entry is readable").path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    files.sort();
    files
}

fn src() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The text without comments.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).expect("source is readable");
    text.lines().map(|l| l.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Room names that follow `crate::` in `code`, through braces too: `crate::{math, optics::View}`.
fn rooms_named(code: &str) -> Vec<String> {
    let word = |s: &str| s.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let mut rooms = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        if let Some(group) = rest.strip_prefix('{') {
            let (mut depth, mut part) = (0, String::new());
            for c in group.chars() {
                match c {
                    '}' if depth == 0 => break,
                    '{' => depth += 1,
                    '}' => depth -= 1,
                    ',' if depth == 0 => rooms.push(word(std::mem::take(&mut part).trim())),
                    c => part.push(c),
                }
            }
            rooms.push(word(part.trim()));
        } else {
            rooms.push(word(rest));
        }
    }
    rooms
}

#[test]
fn imports_run_one_way() {
    let mut backward = Vec::new();
    for (room, may_see) in MAY_SEE {
        let folder = src().join(room);
        let files = if folder.is_dir() { rust_files(&folder) } else { vec![src().join(format!("{room}.rs"))] };
        for file in files {
            for named in rooms_named(&code(&file)) {
                let known = MAY_SEE.iter().any(|(r, _)| *r == named) || named == "cli";
                if known && named != *room && !may_see.concat().contains(&named.as_str()) {
                    backward.push(format!("{} sees `{named}`", file.display()));
                }
            }
        }
    }
    assert!(backward.is_empty(), "arrows that run back:\n{}", backward.join("\n"));
}

#[test]
fn every_room_has_its_rule() {
    for entry in fs::read_dir(src()).expect("src is readable") {
        let path = entry.expect("entry is readable").path();
        let name = path.file_stem().expect("has a name").to_string_lossy().into_owned();
        let is_room = path.is_dir() && name != "cli";
        assert!(!is_room || MAY_SEE.iter().any(|(r, _)| *r == name), "no rule for src/{name}");
    }
}

#[test]
fn the_judge_shares_no_code_with_the_accused() {
    for file in rust_files(&src().join("simulation")) {
        let code = code(&file);
        assert!(
            !code.contains("inverse") && !code.contains("ViewMap"),
            "{} uses the inverse projection",
            file.display()
        );
    }
}

#[test]
fn domain_rooms_touch_no_files_clocks_environment_or_terminals() {
    let banned = [
        "std::fs",
        "std::env",
        "std::time",
        "SystemTime",
        "Instant",
        "println!",
        "eprintln!",
        "std::process",
        "std::net",
    ];
    let rooms = [
        "math",
        "optics",
        "photo",
        "calibration",
        "volume",
        "roots",
        "growth",
        "simulation",
        "evaluation",
        "formats",
        "report",
    ];
    let mut found = Vec::new();
    for room in rooms {
        for file in rust_files(&src().join(room)) {
            let code = code(&file);
            for word in banned.iter().filter(|w| code.contains(**w)) {
                found.push(format!("{}: {word}", file.display()));
            }
        }
    }
    assert!(found.is_empty(), "domain code is pure:\n{}", found.join("\n"));
}

#[test]
fn only_the_store_knows_zarrs() {
    for file in rust_files(&src()) {
        let inside = file.strip_prefix(src()).expect("below src").starts_with("store");
        assert!(inside || !code(&file).contains("zarrs::"), "{} imports zarrs", file.display());
    }
}

#[test]
fn the_map_names_every_room() {
    let map =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    for entry in fs::read_dir(src()).expect("src is readable") {
        let path = entry.expect("entry is readable").path();
        if path.is_dir() {
            let name = format!("{}/", path.file_name().expect("has a name").to_string_lossy());
            assert!(map.contains(&name), "ARCHITECTURE.md does not name src/{name}");
        }
    }
    assert!(map.lines().count() < 200, "ARCHITECTURE.md has {} lines, under 200 are readable", map.lines().count());
}

#[test]
fn no_file_holds_more_than_one_idea() {
    let mut lengths: Vec<(usize, PathBuf)> = rust_files(&src())
        .into_iter()
        .map(|f| (fs::read_to_string(&f).expect("source is readable").lines().count(), f))
        .collect();
    lengths.sort();
    let (longest, file) = &lengths[lengths.len() - 1];
    assert!(*longest <= 600, "{} has {longest} lines", file.display());
    let median = lengths[lengths.len() / 2].0;
    assert!(median < 200, "the median file has {median} lines");
}
