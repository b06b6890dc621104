//! The result as the page's script reads it.
//!
//! Lists run alike: of a root, `xyz` has three numbers per point (mm, tank frame), the others one. Lengths are written to a
//! hundredth, diameters to a thousandth of a millimetre.

use super::shell::to;
use super::{Page, Photograph, repaired};
use crate::formats::tables::Table;
use crate::roots::traits::glossary;
use crate::roots::{TracedRoot, ink};
use serde_json::{Value, json};

/// The data of the page.
pub fn of(page: &Page<'_>) -> Value {
    let tank = page.tank;
    let kinds = repaired::kinds(page.system);
    let roots: Vec<Value> = page.system.roots.iter().zip(&kinds).map(|(traced, kinds)| root(traced, kinds)).collect();
    let repairs: Vec<Value> = page
        .system
        .repairs
        .iter()
        .map(|r| {
            let at = r.place_mm.map(|x| to(x, 2));
            json!({ "kind": repaired::place(r.kind), "at": at, "mm": to(r.length_mm, 2), "why": r.reason })
        })
        .collect();
    json!({
        "name": page.name,
        "tank": {
            "radius": tank.inner_radius_mm(), "floor": tank.floor_mm(), "water": tank.water_level_mm, "belts": tank.belts_mm,
        },
        "roots": roots,
        "kinds": repaired::KINDS.map(|kind| json!({ "name": kind.name(), "about": repaired::about(kind) })),
        "repairs": repairs,
        "perRoot": table(page.per_root),
        "profile": page.profile,
        "views": views(page.photographs),
    })
}

/// The photographs with the roots on them.
pub fn views(photographs: &[Photograph]) -> Vec<Value> {
    let view = |p: &Photograph| {
        let lines: Vec<Value> = p.lines.iter().map(|l| json!([l.id, l.clear_px, l.strokes])).collect();
        json!({ "name": p.name, "size": p.size_px, "from": p.whole_degrees(), "lines": lines })
    };
    photographs.iter().map(view).collect()
}

fn root(traced: &TracedRoot, kinds: &[i8]) -> Value {
    let root = &traced.root;
    let list =
        |values: &[f64], factor: f64, digits: i32| values.iter().map(|x| to(x * factor, digits)).collect::<Vec<_>>();
    let xyz: Vec<f64> = root.points_mm.iter().flatten().map(|x| to(*x, 2)).collect();
    let hex = |[r, g, b]: [u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
    json!({
        "id": root.id, "parent": root.parent, "order": root.order,
        "colour": hex(ink::by_root(root)), "orderColour": hex(ink::by_order(root)),
        "xyz": xyz, "d": list(&root.radii_mm, 2.0, 3), "sd": list(&traced.radius_sd_mm, 2.0, 3),
        "views": traced.views, "confidence": list(&traced.confidence, 1.0, 3), "repair": kinds,
    })
}

/// The table with what its columns mean.
fn table(table: &Table) -> Value {
    let columns: Vec<Value> = table
        .columns
        .iter()
        .map(|name| match glossary::of_column(name) {
            Some(m) => json!({ "name": name, "label": m.label, "unit": m.unit, "about": m.definition }),
            None => json!({ "name": name, "label": name, "unit": "", "about": "" }),
        })
        .collect();
    json!({ "columns": columns, "rows": table.rows })
}
