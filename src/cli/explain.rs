//! Plans in words: why nodes would run, alike nodes on one line.
//!
//! `render/000.jpg` to `render/017.jpg` that would run for the same reason are one line, `render/* (18)`.

use crate::flow::Change;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Changes shown of one node.
const SHOWN: usize = 3;
/// Letters shown of a digest.
const LETTERS: usize = 8;

/// One line about a node, or about several that are alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Name of the node, or of the family.
    pub name: String,
    /// What would happen to it.
    pub state: &'static str,
    /// Why.
    pub why: String,
    /// Whether something of its own changed, so that it is a cause and no consequence.
    pub is_cause: bool,
    /// Seconds and bytes by experience.
    pub cost: Option<(f64, u64)>,
    /// What the line says with its view left open.
    pattern: String,
}

impl Line {
    /// A line about the node `name`.
    pub fn new(name: &str, state: &'static str, changes: &[Change], cost: Option<(f64, u64)>) -> Self {
        let is_cause = changes.iter().any(|change| !matches!(change, Change::Input { .. }));
        let pattern = match view(name) {
            Some(view) => sentence(changes, false).replace(&format!("/{view}`"), "/*`"),
            None => String::new(),
        };
        Self { name: name.to_owned(), state, why: sentence(changes, true), is_cause, cost, pattern }
    }

    /// A line about a node that changes do not explain.
    pub fn plain(name: &str, state: &'static str, why: &str) -> Self {
        let (name, why) = (name.to_owned(), why.to_owned());
        Self { name, state, pattern: why.clone(), why, is_cause: false, cost: None }
    }
}

/// The view in the name of a node of one view: `003.jpg` of `render/003.jpg [1-4]`.
fn view(name: &str) -> Option<&str> {
    let (_, rest) = name.split_once('/')?;
    Some(rest.split(" [").next().unwrap_or(rest))
}

/// The name with its view left open: `render/* [1-4]`.
fn family(name: &str) -> String {
    view(name).map_or_else(|| name.to_owned(), |view| name.replacen(view, "*", 1))
}

/// Lines of one family that say the same become one, at the place of the last of them.
pub fn folded(lines: Vec<Line>) -> Vec<Line> {
    let mut groups: BTreeMap<(String, &str, String), Vec<Line>> = BTreeMap::new();
    let mut order = BTreeMap::new();
    for (n, line) in lines.into_iter().enumerate() {
        let alone = if view(&line.name).is_some() { line.pattern.clone() } else { format!("{n}") };
        let group = (family(&line.name), line.state, alone);
        order.insert(group.clone(), n);
        groups.entry(group).or_default().push(line);
    }
    let mut groups: Vec<_> = groups.into_iter().collect();
    groups.sort_by_key(|(group, _)| order.get(group).copied());
    groups.into_iter().filter_map(|((family, ..), lines)| one(family, lines)).collect()
}

fn one(family: String, mut lines: Vec<Line>) -> Option<Line> {
    let (count, cost) = (lines.len(), total(&lines));
    let line = lines.pop()?;
    if count == 1 {
        return Some(line);
    }
    Some(Line { name: format!("{family} ({count})"), why: line.pattern.clone(), cost, ..line })
}

/// What all lines cost together; `None` where one is not known.
fn total(lines: &[Line]) -> Option<(f64, u64)> {
    lines.iter().try_fold((0.0, 0), |(seconds, bytes), line| line.cost.map(|(s, b)| (seconds + s, bytes + b)))
}

/// Causes before consequences, each in their order.
pub fn causes_first(lines: Vec<Line>) -> Vec<Line> {
    let (causes, rest): (Vec<_>, Vec<_>) = lines.into_iter().partition(|line| line.is_cause);
    causes.into_iter().chain(rest).collect()
}

/// Changes in words; many inputs that changed alike are counted. `exact` shows the digests of what changed.
fn sentence(changes: &[Change], exact: bool) -> String {
    let mut words: Vec<(String, String, usize)> = Vec::new();
    for change in changes {
        let alike = alike(change);
        match words.iter_mut().find(|(other, ..)| *other == alike) {
            Some((.., count)) => *count += 1,
            None => words.push((alike, in_words(change, exact), 1)),
        }
    }
    let rest = words.iter().skip(SHOWN).map(|(.., count)| count).sum::<usize>();
    let mut text = String::new();
    for (n, (alike, word, count)) in words.iter().take(SHOWN).enumerate() {
        let _ = match (n, count) {
            (0, 1) => write!(text, "{word}"),
            (_, 1) => write!(text, "; {word}"),
            (0, _) => write!(text, "{count} times {alike}"),
            (_, _) => write!(text, "; {count} times {alike}"),
        };
    }
    if rest > 0 {
        let _ = write!(text, "; {rest} more changes");
    }
    text
}

/// The change with the view of its input left open.
fn alike(change: &Change) -> String {
    match change {
        Change::Input { node, .. } | Change::InputAdded { node, .. } | Change::InputRemoved { node, .. } => {
            change.to_string().replace(node.as_str(), &family(node))
        }
        other => other.to_string(),
    }
}

fn in_words(change: &Change, exact: bool) -> String {
    let short = |digest: &crate::store::Digest| digest.to_string().chars().take(LETTERS).collect::<String>();
    match change {
        Change::Input { from, to: Some(to), .. } | Change::File { from, to, .. } if exact => {
            format!("{change} ({} -> {})", short(from), short(to))
        }
        _ => change.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Digest;

    fn input(node: &str, to: Option<u8>) -> Change {
        Change::Input { port: "p".into(), node: node.into(), from: Digest([1; 32]), to: to.map(|n| Digest([n; 32])) }
    }

    fn set(name: &str) -> Change {
        Change::Parameter { name: name.into(), from: 1.into(), to: 2.into() }
    }

    #[test]
    fn alike_nodes_share_a_line_with_what_they_cost_together() {
        let cost = Some((1.5, 10));
        let lines = vec![
            Line::new("undistort/0.jpg", "may run", &[input("photo/0.jpg", None)], cost),
            Line::new("render/0.jpg", "may run", &[input("undistort/0.jpg", None)], cost),
            Line::new("undistort/1.jpg", "may run", &[input("photo/1.jpg", None)], cost),
            Line::new("render/1.jpg", "would run", &[set("x")], cost),
            Line::new("merge", "may run", &[input("render/0.jpg", None), input("render/1.jpg", None)], None),
        ];
        let lines = folded(lines);
        let shown: Vec<String> = lines.iter().map(|l| format!("{}: {}", l.name, l.why)).collect();
        assert_eq!(
            shown,
            [
                "render/0.jpg: input `undistort/0.jpg` has to be computed again",
                "undistort/* (2): input `photo/*` has to be computed again",
                "render/1.jpg: `x`: 1 -> 2",
                "merge: 2 times input `render/*` has to be computed again",
            ]
        );
        assert_eq!(lines[1].cost, Some((3.0, 20)));
        let names: Vec<String> = causes_first(lines).into_iter().map(|l| l.name).collect();
        assert_eq!(names[0], "render/1.jpg");
    }

    #[test]
    fn old_and_new_are_shown() {
        assert_eq!(sentence(&[input("merge", Some(2))], true), "input `merge` has other values (01010101 -> 02020202)");
        let many: Vec<Change> = ["a", "b", "c", "d", "e"].map(set).into();
        assert_eq!(sentence(&many, true), "`a`: 1 -> 2; `b`: 1 -> 2; `c`: 1 -> 2; 2 more changes");
    }
}
