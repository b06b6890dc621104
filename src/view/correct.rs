//! A correction made on the page, added to the study's file of corrections.

use crate::error::{Error, Result};
use crate::formats::corrections_toml;
use crate::roots::correction::{Change, Correction, Spot};
use serde_json::{Map, Value};

/// The correction of an entry as [`corrections_toml`] has it; its `when` is the server's, whatever is given.
///
/// # Errors
/// What is no correction, and a click on a photograph that is none of `photos`.
pub fn read(mut given: Map<String, Value>, when: &str, photos: &[String]) -> Result<Correction> {
    given.insert("when".into(), when.into());
    let entry = Value::from_iter([("correction", vec![Value::from(given)])]);
    let entry = toml::to_string(&entry).map_err(|e| Error::usage(format!("no correction: {e}")))?;
    let list = corrections_toml::read("the correction", &entry)?;
    let correction = list.into_iter().next().ok_or_else(|| Error::usage("no correction was given"))?;
    let spots = match &correction.change {
        Change::Add { through, .. } => &through[..],
        _ => &[],
    };
    let seen = spots.iter().flat_map(|spot| match spot {
        Spot::Seen(seen) => &seen[..],
        Spot::Place(_) => &[],
    });
    if let Some(strange) = seen.map(|s| &s.photo).find(|photo| !photos.contains(photo)) {
        return Err(Error::usage(format!("there is no photograph `{strange}`")));
    }
    Ok(correction)
}

/// The text of the file `name` with one more correction at its end.
///
/// # Errors
/// Where the text holds a fault.
pub fn added(name: &str, text: &str, correction: &Correction) -> Result<String> {
    corrections_toml::read(name, text)?;
    let entry = corrections_toml::write(std::slice::from_ref(correction))?;
    let before = text.trim_end();
    Ok(if before.is_empty() { entry } else { format!("{before}\n\n{entry}") })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn made(value: Value) -> Result<Correction> {
        read(value.as_object().cloned().unwrap(), "2026-05-01T12:00:00Z", &["a.jpg".into(), "b.jpg".into()])
    }

    #[test]
    fn a_correction_comes_after_those_that_are_there() {
        let mine = "# mine\n[[correction]]\nkind = \"remove\"\nat = [1.0, 2.0, 3.0]\n";
        let cut = made(json!({ "kind": "cut", "at": [1, 2.5, 30.25], "by": "Ada", "when": "never" })).unwrap();
        let text = added("c.toml", mine, &cut).unwrap();
        assert!(text.starts_with(mine.trim_end()), "{text}");
        let list = corrections_toml::read("c.toml", &text).unwrap();
        assert_eq!((list.len(), list[1].by.as_str(), list[1].when.as_str()), (2, "Ada", "2026-05-01T12:00:00Z"));
        assert_eq!(list[1].change.place_mm().map(|p| p.z), Some(30.25));
        assert_eq!(added("c.toml", "", &cut).unwrap().matches("[[correction]]").count(), 1);
        assert!(added("c.toml", "[[correction]]\nkind = 3\n", &cut).is_err(), "a fault of the file stays one");
    }

    #[test]
    fn what_is_no_correction_is_refused() {
        let place = |photo: &str| json!([{ "photo": "a.jpg", "px": [1, 2] }, { "photo": photo, "px": [3, 4] }]);
        let add = |photo: &str| json!({ "kind": "add", "clicks": [place(photo), place(photo)] });
        assert!(made(add("b.jpg")).is_ok());
        for wrong in [
            add("../c.jpg"),
            json!({ "kind": "cut" }),
            json!({ "kind": "burn", "at": [1, 2, 3] }),
            json!({ "kind": "cut", "at": [1, 2, 3], "file": "/x" }),
            json!({ "kind": "cut", "at": [1, 2, null] }),
            json!({ "kind": "cut", "at": [1, 2, 3], "by": { "a": 1 } }),
        ] {
            assert!(made(wrong.clone()).is_err(), "{wrong}");
        }
    }
}
