//! `corrections.toml`: what a person corrected, one `[[correction]]` after the other.
//!
//! ```toml
//! [[correction]]
//! kind = "cut"
//! at = [12.4, -3.1, 88.0]        # tank frame, mm
//! by = "Ada"                     # optional: who, when (RFC 3339), why
//! when = "2026-05-01T12:00:00Z"
//! note = "two roots touch here"
//! ```
//!
//! | kind | needs | may have |
//! |---|---|---|
//! | `remove`, `cut`, `base`, `checked` | `at` | |
//! | `remove-stretch`, `join` | `from`, `to` | |
//! | `parent` | `at`, `parent` | |
//! | `order` | `at`, `order` | |
//! | `add` | `points` or `clicks` | `diameter_mm`, `parent` or `continues` |
//!
//! `clicks` is a list of places, each a list of `{ photo, px }` that show it.

use crate::error::{Error, Excerpt, Result};
use crate::optics::Vec3;
use crate::roots::correction::{Change, Correction, Sighting, Spot, Tie};
use serde::{Deserialize, Serialize};
use toml::Spanned;

type Point = [f64; 3];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    correction: Vec<Spanned<Entry>>,
}

/// One entry as it stands in the file.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    kind: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    at: Option<Point>,
    #[serde(skip_serializing_if = "Option::is_none")]
    from: Option<Point>,
    #[serde(skip_serializing_if = "Option::is_none")]
    to: Option<Point>,
    #[serde(skip_serializing_if = "Option::is_none")]
    parent: Option<Point>,
    #[serde(skip_serializing_if = "Option::is_none")]
    continues: Option<Point>,
    #[serde(skip_serializing_if = "Option::is_none")]
    order: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    diameter_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    by: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    when: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    note: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    points: Option<Vec<Point>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    clicks: Option<Vec<Vec<Click>>>,
}

/// A place in an undistorted photograph.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Click {
    photo: String,
    px: [f64; 2],
}

/// Per kind the fields that it needs and that it may have.
const KINDS: [(&str, &[&str], &[&str]); 9] = [
    ("remove", &["at"], &[]),
    ("remove-stretch", &["from", "to"], &[]),
    ("cut", &["at"], &[]),
    ("join", &["from", "to"], &[]),
    ("parent", &["at", "parent"], &[]),
    ("order", &["at", "order"], &[]),
    ("base", &["at"], &[]),
    ("add", &[], &["points", "clicks", "diameter_mm", "parent", "continues"]),
    ("checked", &["at"], &[]),
];

/// Reads the text of a file called `name` in messages.
///
/// # Errors
/// Every correction at fault, with its line.
pub fn read(name: &str, text: &str) -> Result<Vec<Correction>> {
    let fault = |message: String, span: std::ops::Range<usize>| {
        let before = &text[..span.start.min(text.len())];
        let line = before.matches('\n').count() + 1;
        Error::usage(format!("`{name}` line {line}: {message}")).excerpt(Excerpt {
            file: name.to_owned(),
            text: text.to_owned(),
            start: span.start,
            len: span.len().max(1),
        })
    };
    let file: File = toml::from_str(text).map_err(|e| fault(e.message().to_owned(), e.span().unwrap_or(0..0)))?;
    let (mut list, mut faults) = (Vec::new(), Vec::new());
    for entry in file.correction {
        let span = entry.span();
        match entry.into_inner().check() {
            Ok(correction) => list.push(correction),
            Err(message) => faults.push(fault(message, span)),
        }
    }
    Error::many(faults)?;
    Ok(list)
}

/// The text of a file.
///
/// # Errors
/// Where a value has no form in TOML.
pub fn write(list: &[Correction]) -> Result<String> {
    #[derive(Serialize)]
    struct Out {
        correction: Vec<Entry>,
    }
    if list.is_empty() {
        return Ok(String::new());
    }
    let out = Out { correction: list.iter().map(Entry::of).collect() };
    toml::to_string(&out).map_err(|e| Error::failed(format!("corrections cannot be written as TOML: {e}")))
}

impl Entry {
    fn check(self) -> std::result::Result<Correction, String> {
        let Some((kind, needs, may)) = KINDS.iter().find(|k| k.0 == self.kind) else {
            let known: Vec<&str> = KINDS.iter().map(|k| k.0).collect();
            return Err(format!("unknown kind `{}`, expected one of {}", self.kind, known.join(", ")));
        };
        let given = [
            ("at", self.at.is_some()),
            ("from", self.from.is_some()),
            ("to", self.to.is_some()),
            ("parent", self.parent.is_some()),
            ("continues", self.continues.is_some()),
            ("order", self.order.is_some()),
            ("diameter_mm", self.diameter_mm.is_some()),
            ("points", self.points.is_some()),
            ("clicks", self.clicks.is_some()),
        ];
        for (field, is_given) in given {
            let is_needed = needs.contains(&field);
            if is_needed && !is_given {
                return Err(format!("`{kind}` needs `{field}`"));
            }
            if is_given && !is_needed && !may.contains(&field) {
                return Err(format!("`{kind}` has no use for `{field}`"));
            }
        }
        let all = [self.at, self.from, self.to, self.parent, self.continues]
            .into_iter()
            .flatten()
            .chain(self.points.iter().flatten().copied());
        let clicks = self.clicks.iter().flatten().flatten();
        if all.flatten().chain(clicks.flat_map(|c| c.px)).any(|x| !x.is_finite()) {
            return Err("a coordinate is not finite".into());
        }
        if self.diameter_mm.is_some_and(|d| !(d > 0.0 && d <= 100.0)) {
            return Err("`diameter_mm` lies between 0 and 100 mm".into());
        }
        let change = self.change()?;
        Ok(Correction { change, by: self.by, when: self.when, note: self.note })
    }

    fn change(&self) -> std::result::Result<Change, String> {
        let place = |p: Option<Point>| p.map(Vec3::from).unwrap_or_default();
        let (at, from, to) = (place(self.at), place(self.from), place(self.to));
        Ok(match self.kind.as_str() {
            "remove" => Change::Remove { at },
            "remove-stretch" => Change::RemoveStretch { from, to },
            "cut" => Change::Cut { at },
            "join" => Change::Join { from, to },
            "parent" => Change::Parent { at, parent: place(self.parent) },
            "order" => Change::Order { at, order: self.order.unwrap_or_default() },
            "base" => Change::Base { at },
            "checked" => Change::Checked { at },
            _ => Change::Add {
                through: self.through()?,
                diameter_mm: self.diameter_mm,
                tie: match (self.parent, self.continues) {
                    (None, None) => Tie::Free,
                    (Some(at), None) => Tie::Parent(Vec3::from(at)),
                    (None, Some(at)) => Tie::Continues(Vec3::from(at)),
                    _ => return Err("`add` has either `parent` or `continues`".into()),
                },
            },
        })
    }

    fn through(&self) -> std::result::Result<Vec<Spot>, String> {
        let spots: Vec<Spot> = match (&self.points, &self.clicks) {
            (Some(points), None) => points.iter().map(|p| Spot::Place(Vec3::from(*p))).collect(),
            (None, Some(places)) => {
                if places.iter().any(|seen| seen.len() < 2) {
                    return Err("each place of `clicks` needs two photographs that show it".into());
                }
                let seen = |c: &Click| Sighting { photo: c.photo.clone(), px: c.px };
                places.iter().map(|clicks| Spot::Seen(clicks.iter().map(seen).collect())).collect()
            }
            _ => return Err("`add` needs either `points` or `clicks`".into()),
        };
        if spots.len() < 2 { Err("`add` needs two places at least".into()) } else { Ok(spots) }
    }

    fn of(correction: &Correction) -> Self {
        // A hundredth of a millimetre is finer than any place is known.
        let place = |p: &Vec3| <Point>::from(p.map(|x| (x * 1e3).round() / 1e3 + 0.0));
        let mut entry = Self {
            kind: correction.change.kind().to_owned(),
            by: correction.by.clone(),
            when: correction.when.clone(),
            note: correction.note.clone(),
            ..Self::default()
        };
        match &correction.change {
            Change::Remove { at } | Change::Cut { at } | Change::Base { at } | Change::Checked { at } => {
                entry.at = Some(place(at));
            }
            Change::RemoveStretch { from, to } | Change::Join { from, to } => {
                (entry.from, entry.to) = (Some(place(from)), Some(place(to)));
            }
            Change::Parent { at, parent } => (entry.at, entry.parent) = (Some(place(at)), Some(place(parent))),
            Change::Order { at, order } => (entry.at, entry.order) = (Some(place(at)), Some(*order)),
            Change::Add { through, diameter_mm, tie } => {
                entry.diameter_mm = *diameter_mm;
                match tie {
                    Tie::Free => {}
                    Tie::Parent(at) => entry.parent = Some(place(at)),
                    Tie::Continues(at) => entry.continues = Some(place(at)),
                }
                let seen = |s: &Sighting| Click { photo: s.photo.clone(), px: s.px };
                for spot in through {
                    match spot {
                        Spot::Place(at) => entry.points.get_or_insert_default().push(place(at)),
                        Spot::Seen(list) => entry.clicks.get_or_insert_default().push(list.iter().map(seen).collect()),
                    }
                }
            }
        }
        entry
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: &str = r#"
[[correction]]
kind = "remove"
at = [1.0, 2.0, 3.0]
by = "Ada"
when = "2026-05-01T12:00:00Z"
note = "a bubble"
[[correction]]
kind = "remove-stretch"
from = [1.0, 2.0, 3.0]
to = [1.0, 2.0, 4.0]
[[correction]]
kind = "cut"
at = [1, 2, 3]
[[correction]]
kind = "join"
from = [1.0, 2.0, 3.0]
to = [1.0, 2.0, 4.0]
[[correction]]
kind = "parent"
at = [1.0, 2.0, 3.0]
parent = [1.0, 2.0, 4.0]
[[correction]]
kind = "order"
at = [1.0, 2.0, 3.0]
order = 2
[[correction]]
kind = "base"
at = [1.0, 2.0, 3.0]
[[correction]]
kind = "add"
points = [[1.0, 2.0, 3.0], [1.0, 2.0, 9.0]]
diameter_mm = 0.7
parent = [0.0, 0.0, 3.0]
[[correction]]
kind = "add"
clicks = [[{ photo = "a.jpg", px = [1.0, 2.0] }, { photo = "b.jpg", px = [3.0, 4.0] }],
          [{ photo = "a.jpg", px = [1.0, 9.0] }, { photo = "b.jpg", px = [3.0, 9.0] }]]
[[correction]]
kind = "add"
points = [[1.0, 2.0, 3.0], [1.0, 2.0, 9.0]]
continues = [1.0, 2.0, 2.5]
[[correction]]
kind = "checked"
at = [1.0, 2.0, 3.0]
"#;

    #[test]
    fn what_is_written_is_read_again() {
        let list = read("c.toml", ALL).unwrap();
        assert_eq!(list.len(), 11);
        assert_eq!((list[0].by.as_str(), list[0].note.as_str()), ("Ada", "a bubble"));
        let text = write(&list).unwrap();
        assert_eq!(read("again", &text).unwrap(), list, "{text}");
        assert!(read("empty", "").unwrap().is_empty() && write(&[]).unwrap().is_empty());
    }

    #[test]
    fn every_fault_is_told_with_its_line() {
        let text = "[[correction]]\nkind = \"cut\"\n\n[[correction]]\nkind = \"order\"\nat = [1, 2, 3]\norder = 1\nto = [1, 2, 3]\n\n\
                    [[correction]]\nkind = \"prune\"\n\n[[correction]]\nkind = \"add\"\npoints = [[1, 2, 3]]\n";
        let faults: Vec<String> = read("c.toml", text).unwrap_err().apart().into_iter().map(|e| e.message).collect();
        let wanted =
            ["line 1: `cut` needs `at`", "line 4: `order` has no use for `to`", "unknown kind `prune`", "two places"];
        assert_eq!(faults.len(), 4, "{faults:?}");
        assert!(faults.iter().zip(wanted).all(|(fault, want)| fault.contains(want)), "{faults:?}");
        for (text, want) in [
            ("[[correction]]\nkind = \"cut\"\nat = [1, 2]\n", "line 3"),
            ("[[correction]]\nkind = \"cut\"\nat = [nan, 2, 3]\n", "not finite"),
            ("[[correktion]]\nkind = \"cut\"\n", "correktion"),
            ("[[correction]]\nkind = \"add\"\nclicks = [[{ photo = \"a\", px = [1, 2] }], []]\n", "two photographs"),
        ] {
            let e = read("c.toml", text).unwrap_err();
            assert!(e.message.contains(want), "{text}: {e}");
        }
    }
}
