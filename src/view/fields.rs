//! The settings that the panel offers, as they describe themselves: ranges, defaults and help are those of their types.

use crate::error::{Error, Result};
use crate::roots::{HierarchyParams, TraceParams};
use crate::study::document::Resolved;
use crate::volume::hysteresis::Hysteresis;
use schemars::{JsonSchema, schema_for};
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// Settings laid over a study's, by `section.key`: numbers, truth values or words.
pub type Changes = BTreeMap<String, Value>;

/// A setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Field {
    /// `section.key`.
    pub name: String,
    /// What it means, as its documentation says it.
    pub about: String,
    /// Its least and greatest value, where it is a number that has them.
    pub range: [Option<f64>; 2],
    /// What it may be, where it is a word.
    pub choices: Vec<String>,
    /// Its value where the study file says nothing.
    pub default: Value,
}

/// The settings of extraction, tracing and hierarchy, in the order of their types.
///
/// # Errors
/// Where a default has no form in TOML.
pub fn fields() -> Result<Vec<Field>> {
    let mut all = of::<Hysteresis>("extract")?;
    all.extend(of::<TraceParams>("trace")?);
    all.extend(of::<HierarchyParams>("hierarchy")?);
    Ok(all)
}

fn of<T: JsonSchema + Default + Serialize>(section: &str) -> Result<Vec<Field>> {
    let schema = schema_for!(T).to_value();
    let wrong = |e: &dyn std::fmt::Display| Error::failed(format!("[{section}] cannot be written as TOML: {e}"));
    // By way of TOML, where a number of single precision has its shortest form.
    let text = toml::to_string(&T::default()).map_err(|e| wrong(&e))?;
    let defaults: Value = toml::from_str(&text).map_err(|e| wrong(&e))?;
    let mut fields = Vec::new();
    collect(section, &schema, schema.get("$defs"), &defaults, &mut fields);
    Ok(fields)
}

/// Adds the properties of `schema`, those of sections within it under dotted names.
fn collect(prefix: &str, schema: &Value, definitions: Option<&Value>, defaults: &Value, into: &mut Vec<Field>) {
    let none = Map::new();
    for (key, property) in schema["properties"].as_object().unwrap_or(&none) {
        let name = format!("{prefix}.{key}");
        let referred = property["$ref"].as_str().and_then(|r| definitions?.get(r.rsplit('/').next()?));
        let default = &defaults[key];
        match referred {
            Some(section) if section["properties"].is_object() => collect(&name, section, definitions, default, into),
            _ => into.push(Field {
                name,
                about: property["description"].as_str().unwrap_or_default().replace('\n', " "),
                range: [property["minimum"].as_f64(), property["maximum"].as_f64()],
                choices: referred.map(choices).unwrap_or_default(),
                default: default.clone(),
            }),
        }
    }
}

/// The words that an enumeration allows.
fn choices(schema: &Value) -> Vec<String> {
    let of = |list: &str| schema[list].as_array().into_iter().flatten().cloned().collect::<Vec<_>>();
    let words = of("oneOf").into_iter().map(|one| one["const"].clone()).chain(of("enum"));
    words.filter_map(|word| word.as_str().map(str::to_owned)).collect()
}

/// The values that a study gives the fields.
pub fn values(fields: &[Field], resolved: &Resolved) -> Changes {
    let value = |field: &Field| {
        let text = resolved.get(&field.name)?;
        let table: Value = toml::from_str(&format!("value = {text}")).ok()?;
        Some((field.name.clone(), table["value"].clone()))
    };
    fields.iter().filter_map(value).collect()
}

/// The changes as `--set` takes them.
///
/// # Errors
/// Every change that is of no field, or has a value of another kind.
pub fn overrides(fields: &[Field], changes: &Changes) -> Result<Vec<String>> {
    let (mut set, mut faults) = (Vec::new(), Vec::new());
    for (name, value) in changes {
        let Some(field) = fields.iter().find(|field| field.name == *name) else {
            faults.push(Error::usage(format!("`{name}` cannot be set here")));
            continue;
        };
        match (&field.default, value) {
            (Value::Number(_), Value::Number(_)) | (Value::Bool(_), Value::Bool(_)) => {
                set.push(format!("{name}={value}"))
            }
            (Value::String(_), Value::String(word)) if field.choices.contains(word) => {
                set.push(format!("{name}={word:?}"))
            }
            _ => faults
                .push(Error::usage(format!("{name} is {value}")).help(format!("give a value like {}", field.default))),
        }
    }
    Error::many(faults)?;
    Ok(set)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn settings_describe_themselves() {
        let all = fields().unwrap();
        let field = |name: &str| all.iter().find(|f| f.name == name).unwrap_or_else(|| panic!("no {name}"));
        let high = field("extract.high");
        assert!(high.about.starts_with("Voxels above it are root"), "{}", high.about);
        assert_eq!((high.range, &high.default), ([Some(0.0), None], &json!(1.1)));
        assert_eq!(field("extract.unit").choices, ["level", "rootness"]);
        assert_eq!(field("trace.link.reach").range, [Some(1.0), Some(5.0)]);
        assert_eq!(field("hierarchy.shown").default, json!(0.5));
        assert!(all.iter().all(|f| !f.about.is_empty() && !f.default.is_null()), "{all:?}");
    }

    #[test]
    fn ranges_are_those_that_the_help_names() {
        for field in fields().unwrap() {
            let [Some(low), Some(high)] = field.range else { continue };
            let said = format!("{low} to {high}");
            let other = format!("to {high}");
            assert!(field.about.contains(&said) || field.about.contains(&other), "{}: {}", field.name, field.about);
        }
    }

    #[test]
    fn only_fields_with_values_of_their_kind_become_settings() {
        let all = fields().unwrap();
        let set = |name: &str, value: Value| overrides(&all, &Changes::from([(name.to_owned(), value)]));
        assert_eq!(set("extract.high", json!(1.5)).unwrap(), ["extract.high=1.5"]);
        assert_eq!(set("extract.unit", json!("rootness")).unwrap(), ["extract.unit=\"rootness\""]);
        for (name, value) in [
            ("photos.dir", json!("/etc")),
            ("extract.high", json!("1\n[photos]")),
            ("extract.unit", json!("metres")),
            ("trace", json!({ "low": 1 })),
        ] {
            assert!(set(name, value).is_err(), "{name}");
        }
    }

    #[test]
    fn values_are_those_that_count() {
        let resolved =
            Resolved::from([("extract.high".into(), "1.5".into()), ("extract.unit".into(), "\"level\"".into())]);
        let values = values(&fields().unwrap(), &resolved);
        assert_eq!(
            values,
            Changes::from([("extract.high".into(), json!(1.5)), ("extract.unit".into(), json!("level"))])
        );
    }
}
