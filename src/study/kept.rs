//! What a study file says against what was understood of it: numbers that are none, and values that would be dropped.
//!
//! Reading a section as its type refuses unknown keys and wrong types. It lets three slips through, which are caught
//! here: NaN and infinity, numbers that the type can only hold as infinity, and lists longer than the type takes.

use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A slip: what is wrong, and where.
pub(super) type Slip = (String, Range<usize>);

/// NaN and infinities anywhere in a value.
pub(super) fn not_finite(given: &Spanned<DeValue<'_>>) -> Vec<Slip> {
    match given.get_ref() {
        DeValue::Float(x) if !x.as_str().replace('_', "").parse::<f64>().is_ok_and(f64::is_finite) => {
            vec![(format!("`{x}` is not a finite number"), given.span())]
        }
        DeValue::Array(items) => items.iter().flat_map(not_finite).collect(),
        DeValue::Table(table) => table.iter().flat_map(|(_, value)| not_finite(value)).collect(),
        _ => Vec::new(),
    }
}

/// Values of `given` that `written`, the section as it was understood, does not hold in full.
pub(super) fn dropped(given: &DeTable<'_>, written: &toml::Table) -> Vec<Slip> {
    let both = given.iter().filter_map(|(key, value)| Some((value, written.get(key.get_ref().as_ref())?)));
    both.flat_map(|(value, kept)| dropped_value(value, kept)).collect()
}

fn dropped_value(given: &Spanned<DeValue<'_>>, written: &toml::Value) -> Vec<Slip> {
    match (given.get_ref(), written) {
        (DeValue::Table(given), toml::Value::Table(written)) => dropped(given, written),
        (DeValue::Array(items), toml::Value::Array(kept)) if items.len() != kept.len() => {
            vec![(format!("expected {} values, found {}", kept.len(), items.len()), given.span())]
        }
        (DeValue::Array(items), toml::Value::Array(kept)) => {
            items.iter().zip(kept.iter()).flat_map(|(item, kept)| dropped_value(item, kept)).collect()
        }
        (DeValue::Float(_) | DeValue::Integer(_), toml::Value::Float(kept)) if !kept.is_finite() => {
            vec![("the number is too large".to_owned(), given.span())]
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slips(given: &str, written: &str) -> Vec<String> {
        let given = DeTable::parse(given).unwrap();
        let value = Spanned::new(given.span(), DeValue::Table(given.get_ref().clone()));
        let all = not_finite(&value).into_iter().chain(dropped(given.get_ref(), &written.parse().unwrap()));
        all.map(|(what, at)| format!("{what} at {}", at.start)).collect()
    }

    #[test]
    fn what_would_be_lost_is_found_at_its_place() {
        assert_eq!(slips("a = [1.0, nan]", "a = [1.0, 2.0]"), ["`nan` is not a finite number at 10"]);
        assert_eq!(slips("a = { b = -inf }", ""), ["`-inf` is not a finite number at 10"]);
        assert_eq!(slips("a = [[1, 2, 3]]", "a = [[1.0, 2.0]]"), ["expected 2 values, found 3 at 5"]);
        assert_eq!(slips("a = 1e300", "a = inf"), ["the number is too large at 4"]);
        assert_eq!(slips("a = [1_0.5, 2]\nb = \"x\"\nc = 3", "a = [10.5, 2.0]\nb = \"x\""), Vec::<String>::new());
    }
}
