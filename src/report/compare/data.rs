//! The results as the page's script reads them. Lists run alike: of a root, `xyz` has three numbers per point (mm, tank frame).

use super::{Page, fates, letter};
use crate::growth::same_roots::Entry;
use crate::report::page::shell::to;
use crate::roots::{Root, ink};
use serde_json::{Value, json};

/// The data of the page.
pub fn of(page: &Page<'_>) -> Value {
    let fates = fates::of_all(page);
    let tank = |n: usize| {
        let tank = &page.shown[n].tank;
        json!({
            "radius": tank.inner_radius_mm(), "floor": tank.floor_mm(), "water": tank.water_level_mm, "belts": tank.belts_mm,
        })
    };
    let results: Vec<Value> = page
        .shown
        .iter()
        .enumerate()
        .map(|(n, shown)| {
            let roots: Vec<Value> =
                shown.roots.iter().zip(&fates[n]).map(|(r, fate)| root(r, *fate as usize)).collect();
            json!({ "letter": letter(n), "name": shown.name, "tank": tank(n), "roots": roots })
        })
        .collect();
    let entries: Vec<&[Entry]> = page.others.iter().map(|other| &other.entries[..]).collect();
    json!({
        "tank": tank(0),
        "results": results,
        "entries": entries,
        "fates": fates::ALL.map(|(fate, colour, about)| json!({ "name": fate, "colour": hex(colour), "about": about })),
    })
}

fn root(root: &Root, fate: usize) -> Value {
    let xyz: Vec<f64> = root.points_mm.iter().flatten().map(|x| to(*x, 2)).collect();
    let d: Vec<f64> = root.radii_mm.iter().map(|r| to(2.0 * r, 3)).collect();
    json!({ "id": root.id, "order": root.order, "orderColour": hex(ink::by_order(root)), "fate": fate, "xyz": xyz, "d": d })
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}
