//! The rules of the official schema (RootSystemML/RSMLValidator, rsml.xsd), told once more as code: which
//! elements may stand where, how often, in which order, with which attributes and which kinds of text.

use quick_xml::events::Event;
use quick_xml::reader::Reader;

#[derive(Debug, Default)]
struct Element {
    name: String,
    attributes: Vec<(String, String)>,
    text: String,
    children: Vec<Element>,
}

fn parse(text: &str) -> Element {
    let mut reader = Reader::from_str(text);
    let mut stack = vec![Element::default()];
    loop {
        let event = reader.read_event().unwrap();
        match event {
            Event::Start(ref tag) | Event::Empty(ref tag) => {
                let element = Element {
                    name: tag.name().as_ref().to_string(),
                    attributes: tag
                        .attributes()
                        .map(|a| {
                            let a = a.unwrap();
                            (a.key.as_ref().to_string(), a.value.to_string())
                        })
                        .collect(),
                    ..Element::default()
                };
                stack.push(element);
                if matches!(event, Event::Empty(_)) {
                    let done = stack.pop().unwrap();
                    stack.last_mut().unwrap().children.push(done);
                }
            }
            Event::Text(part) => stack.last_mut().unwrap().text.push_str(&part),
            Event::End(_) => {
                let done = stack.pop().unwrap();
                stack.last_mut().unwrap().children.push(done);
            }
            Event::Eof => break,
            _ => {}
        }
    }
    assert_eq!(stack.len(), 1, "every element is closed");
    stack.pop().unwrap().children.pop().expect("a root element")
}

/// xs:decimal: digits with at most one point and a sign, no exponent.
fn is_decimal(text: &str) -> bool {
    let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
    digits.chars().any(|c| c.is_ascii_digit())
        && digits.chars().all(|c| c.is_ascii_digit() || c == '.')
        && digits.matches('.').count() <= 1
}

/// xs:dateTime, as far as its form goes.
fn is_date_time(text: &str) -> bool {
    let pattern = "dddd-dd-ddTdd:dd:dd";
    text.len() >= pattern.len()
        && text.chars().zip(pattern.chars()).all(|(c, p)| if p == 'd' { c.is_ascii_digit() } else { c == p })
}

/// `min..=max` times each, in this order when `ordered`, nothing else.
fn children(faults: &mut Vec<String>, e: &Element, ordered: bool, allowed: &[(&str, usize, usize)]) {
    let mut last = 0;
    for child in &e.children {
        match allowed.iter().position(|a| a.0 == child.name) {
            None => faults.push(format!("<{}> within <{}>", child.name, e.name)),
            Some(at) if ordered && at < last => faults.push(format!("<{}> too late within <{}>", child.name, e.name)),
            Some(at) => last = at,
        }
    }
    for (name, least, most) in allowed {
        let n = e.children.iter().filter(|c| c.name == *name).count();
        if n < *least || n > *most {
            faults.push(format!("{n} <{name}> within <{}>", e.name));
        }
    }
}

fn attributes(faults: &mut Vec<String>, e: &Element, required: &[&str], optional: &[&str]) {
    for (key, _) in &e.attributes {
        if !required.contains(&key.as_str()) && !optional.contains(&key.as_str()) {
            faults.push(format!("attribute `{key}` of <{}>", e.name));
        }
    }
    for key in required {
        if !e.attributes.iter().any(|(k, _)| k == key) {
            faults.push(format!("<{}> without `{key}`", e.name));
        }
    }
}

fn decimals(faults: &mut Vec<String>, e: &Element) {
    for (key, value) in e.attributes.iter().filter(|(_, v)| !is_decimal(v)) {
        faults.push(format!("{key}=\"{value}\" of <{}> is no decimal", e.name));
    }
}

const MANY: usize = usize::MAX;

fn root(faults: &mut Vec<String>, e: &Element) {
    let order =
        [("properties", 0, 1), ("geometry", 1, 1), ("functions", 0, 1), ("annotations", 0, 1), ("root", 0, MANY)];
    children(faults, e, true, &order);
    attributes(faults, e, &[], &["id", "label", "accession"]);
    for child in &e.children {
        match child.name.as_str() {
            "geometry" => {
                if child.children.first().is_none_or(|c| c.name != "polyline") {
                    faults.push("<geometry> does not start with <polyline>".into());
                }
                for line in child.children.iter().filter(|c| c.name == "polyline") {
                    children(faults, line, true, &[("point", 2, MANY)]);
                    for point in &line.children {
                        attributes(faults, point, &["x", "y"], &["z"]);
                        decimals(faults, point);
                    }
                }
            }
            "functions" => {
                children(faults, child, true, &[("function", 0, MANY)]);
                for function in &child.children {
                    attributes(faults, function, &["name", "domain"], &["origin"]);
                    children(faults, function, true, &[("sample", 1, MANY)]);
                    for sample in &function.children {
                        attributes(faults, sample, &["value"], &["position"]);
                        decimals(faults, sample);
                    }
                }
            }
            "root" => root(faults, child),
            _ => {}
        }
    }
}

/// What the schema has against a file; empty for a valid one.
pub(super) fn faults(text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let e = parse(text);
    if e.name != "rsml" {
        return vec![format!("<{}> instead of <rsml>", e.name)];
    }
    children(&mut faults, &e, false, &[("metadata", 1, 1), ("scene", 1, 1)]);
    for part in &e.children {
        if part.name == "metadata" {
            let once = ["version", "unit", "resolution", "last-modified", "software", "user", "file-key"];
            let mut allowed: Vec<_> = once.map(|n| (n, 1, 1)).to_vec();
            allowed.extend(["property-definitions", "time-sequence", "image"].map(|n| (n, 0, 1)));
            children(&mut faults, part, false, &allowed);
            for item in &part.children {
                match item.name.as_str() {
                    "resolution" if !is_decimal(item.text.trim()) => faults.push("resolution is no decimal".into()),
                    "last-modified" if !is_date_time(item.text.trim()) => {
                        faults.push("last-modified is no date".into())
                    }
                    "property-definitions" => {
                        children(&mut faults, item, true, &[("property-definition", 0, MANY)]);
                        for definition in &item.children {
                            let allowed = [("label", 1, 1), ("type", 1, 1), ("unit", 0, 1), ("default", 0, 1)];
                            children(&mut faults, definition, false, &allowed);
                        }
                    }
                    "image" => {
                        children(&mut faults, item, false, &[("name", 0, 1), ("sha256", 0, 1), ("captured", 0, 1)]);
                    }
                    _ => {}
                }
            }
        } else {
            children(&mut faults, part, true, &[("properties", 0, 1), ("plant", 1, MANY), ("annotations", 0, 1)]);
            for plant in part.children.iter().filter(|c| c.name == "plant") {
                children(&mut faults, plant, true, &[("properties", 0, 1), ("root", 1, MANY), ("annotations", 0, 1)]);
                attributes(&mut faults, plant, &[], &["id", "label"]);
                plant.children.iter().filter(|c| c.name == "root").for_each(|c| root(&mut faults, c));
            }
        }
    }
    faults
}
