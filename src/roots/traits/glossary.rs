//! What the columns of the trait tables mean, in words for people: a label, the unit, a definition.
//!
//! Every trait of [`traits`](super::traits) and every column of [`PerRoot`](super::per_root::PerRoot) has an entry.

/// What a number means.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Meaning {
    /// Heading under which it stands: one of [`GROUPS`]; empty for a column of `per_root.csv`.
    pub group: &'static str,
    /// Short name without the unit.
    pub label: String,
    /// Unit as printed; empty for counts and ratios.
    pub unit: &'static str,
    /// One sentence.
    pub definition: String,
}

/// Headings of the traits of a plant, in the order of the table.
pub const GROUPS: [&str; 5] = ["Size", "Diameter classes", "Branching", "Depth", "Shape"];

/// Name (without unit), group, label, definition.
const TRAITS: &[(&str, usize, &str, &str)] = &[
    ("total_root_length", 0, "Total root length", "Sum of the lengths of all centrelines."),
    (
        "root_volume",
        0,
        "Root volume",
        "Sum of truncated cones along the centrelines, from the diameters measured there.",
    ),
    ("surface_area", 0, "Surface area", "Sum of π · diameter · length along the centrelines."),
    ("mean_diameter", 0, "Mean diameter", "Mean over the centrelines, weighted by length."),
    ("median_diameter", 0, "Median diameter", "Half of the root length is thinner."),
    ("max_diameter", 0, "Greatest diameter", "The thickest step of any centreline."),
    ("specific_root_length", 0, "Specific root length", "Root length over root volume."),
    ("root_count", 2, "Roots", "Number of traced roots."),
    ("root_tip_count", 2, "Root tips", "Last points of roots."),
    ("branch_point_count", 2, "Branch points", "Roots that spring from another root."),
    ("branching_frequency", 2, "Branching frequency", "Branch points over total root length."),
    ("lateral_density_order_1", 2, "Lateral density, order 1", "Roots of order 1 over the length of order 0."),
    ("lateral_density_order_2", 2, "Lateral density, order 2", "Roots of order 2 over the length of order 1."),
    (
        "altitude",
        2,
        "Altitude",
        "Fitter's topology: links (stretches between branch points) from the base to the farthest tip.",
    ),
    (
        "external_path_length",
        2,
        "External path length",
        "Fitter's topology: links from the base to each tip, summed over all tips.",
    ),
    ("depth_max", 3, "Greatest depth", "Deepest point under the water surface."),
    ("height", 3, "Vertical extent", "From the highest to the deepest point."),
    ("depth_d50", 3, "Depth D50", "Depth above which 50 % of the root length lie."),
    ("depth_d95", 3, "Depth D95", "Depth above which 95 % of the root length lie."),
    ("depth_mean", 3, "Mean depth", "Mean depth, weighted by length."),
    ("root_distribution_index", 3, "Root distribution index", "Mean depth of the centrelines' points."),
    ("centroid_depth", 3, "Centroid depth", "Mean depth, weighted by volume."),
    (
        "length_share_lower_two_thirds",
        3,
        "Length in the lower two thirds",
        "Share of the length below the upper third of the vertical extent.",
    ),
    (
        "volume_share_lower_two_thirds",
        3,
        "Volume in the lower two thirds",
        "Share of the volume below the upper third of the vertical extent.",
    ),
    ("median_roots", 3, "Median number of roots", "Roots that cross a horizontal plane, planes 1 mm apart: median."),
    (
        "max_roots_84",
        3,
        "Number of roots, 84 %",
        "Roots that cross a horizontal plane, planes 1 mm apart: 84 % quantile.",
    ),
    ("max_roots", 3, "Greatest number of roots", "Roots that cross a horizontal plane, planes 1 mm apart: maximum."),
    ("bushiness", 3, "Bushiness", "84 % quantile over median of the roots that cross a horizontal plane."),
    ("width_max", 4, "Greatest width", "Diameter of the smallest circle about the plan view."),
    ("width_min", 4, "Least width", "Smallest distance of two parallels about the plan view."),
    ("hull_area_xy", 4, "Hull area from above", "Convex hull of the projection along z."),
    ("hull_area_xz", 4, "Hull area from the side, x z", "Convex hull of the projection along y."),
    ("hull_area_yz", 4, "Hull area from the side, y z", "Convex hull of the projection along x."),
    ("convex_hull_volume", 4, "Convex hull volume", "Volume of the convex hull in space."),
    ("convex_hull_slicewise", 4, "Slice-wise hull volume", "Sum of the convex hulls of slices 1 mm thick."),
    ("solidity", 4, "Solidity", "Root volume over convex hull volume."),
    ("ellipsoid_axis_long", 4, "Ellipsoid, long axis", "Longest full axis of the smallest enclosing ellipsoid."),
    ("ellipsoid_axis_middle", 4, "Ellipsoid, middle axis", "Middle full axis of the smallest enclosing ellipsoid."),
    ("ellipsoid_axis_short", 4, "Ellipsoid, short axis", "Shortest full axis of the smallest enclosing ellipsoid."),
    (
        "ellipsoid_aspect_ratio",
        4,
        "Ellipsoid, aspect ratio",
        "Shortest over longest axis of the smallest enclosing ellipsoid.",
    ),
];

/// Name (without unit), label, definition.
const COLUMNS: &[(&str, &str, &str)] = &[
    ("root_id", "Root", "Number of the root."),
    ("parent_id", "Parent", "Number of the root that it springs from; −1 for none."),
    ("order", "Order", "0 for the taproot or the crown roots, 1 for their laterals, and so on."),
    ("length", "Length", "Arc length of the centreline."),
    ("tortuosity", "Tortuosity", "Path over chord of base and tip, 1 or more."),
    ("mean_diameter", "Mean diameter", "Mean over the centreline, weighted by length."),
    ("base_diameter", "Base diameter", "At the first point."),
    ("tip_diameter", "Tip diameter", "At the last point."),
    ("volume", "Volume", "Sum of truncated cones along the centreline."),
    ("surface_area", "Surface area", "Sum of π · diameter · length along the centreline."),
    ("insertion", "Insertion", "Where it springs from its parent: arc position from the parent's base."),
    (
        "insertion_angle",
        "Insertion angle",
        "Between its first stretch and the parent's direction towards its tip there.",
    ),
    ("emergence_angle", "Emergence angle", "Between its first stretch and straight down."),
    ("midpoint_angle", "Midpoint angle", "Between its middle stretch and straight down."),
    ("tip_angle", "Tip angle", "Between its last stretch and straight down."),
    ("laterals", "Laterals", "Roots that spring from it."),
    ("lateral_density", "Lateral density", "Laterals over length."),
    ("tip_depth", "Tip depth", "Depth of its last point under the water surface."),
];

/// Endings of names, longest first, and the units that they stand for.
const UNITS: [(&str, &str); 7] = [
    ("_mm_per_mm3", "mm/mm³"),
    ("_per_mm", "1/mm"),
    ("_links", "links"),
    ("_mm3", "mm³"),
    ("_mm2", "mm²"),
    ("_deg", "°"),
    ("_mm", "mm"),
];

fn without_unit(name: &str) -> (&str, &'static str) {
    UNITS.iter().find_map(|(end, unit)| Some((name.strip_suffix(end)?, *unit))).unwrap_or((name, ""))
}

/// What the trait of that name in `traits.csv` means.
pub fn of_trait(name: &str) -> Option<Meaning> {
    let (bare, unit) = without_unit(name);
    if let Some(&(_, group, label, definition)) = TRAITS.iter().find(|t| t.0 == bare) {
        return Some(Meaning { group: GROUPS[group], label: label.into(), unit, definition: definition.into() });
    }
    if let Some((what, range)) = bare.split_once("_diameter_") {
        let range = match (range.split_once("_to_"), range.strip_prefix("over_")) {
            (Some((from, to)), _) => format!("{from} to {to} mm"),
            (None, Some(from)) => format!("over {from} mm"),
            _ => return None,
        };
        let what = ["length", "area", "volume"].into_iter().find(|w| *w == what)?;
        let (label, definition) =
            (format!("{}, {range}", capital(what)), format!("Root {what} in steps with a diameter of {range}."));
        return Some(Meaning { group: GROUPS[1], label, unit, definition });
    }
    let (what, order) = bare.split_once("_order_")?;
    let order = order.replace('_', " ");
    let (label, definition) = match what {
        "count" => ("Roots", "Number of roots"),
        "length" => ("Length", "Sum of the lengths of roots"),
        "mean_length" => ("Mean length", "Mean length of roots"),
        _ => return None,
    };
    let (label, definition) = (format!("{label}, order {order}"), format!("{definition} of order {order}."));
    Some(Meaning { group: GROUPS[2], label, unit, definition })
}

/// What the column of that name in `per_root.csv` means.
pub fn of_column(name: &str) -> Option<Meaning> {
    let (bare, unit) = without_unit(name);
    let &(_, label, definition) = COLUMNS.iter().find(|c| c.0 == bare)?;
    Some(Meaning { group: "", label: label.into(), unit, definition: definition.into() })
}

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::roots::Root;
    use crate::roots::traits::{TraitParams, traits};

    #[test]
    fn every_trait_has_a_meaning() {
        let root =
            Root { id: 0, parent: -1, order: 0, points_mm: vec![[0.0; 3], [0.0, 0.0, 9.0]], radii_mm: vec![0.5; 2] };
        for t in traits(&[root], 0.0, &TraitParams::default()) {
            let meaning = of_trait(&t.name).unwrap_or_else(|| panic!("{} has no meaning", t.name));
            assert!(GROUPS.contains(&meaning.group) && meaning.definition.ends_with('.'), "{meaning:?}");
            assert_eq!(t.name.ends_with("_mm"), ["mm", "1/mm"].contains(&meaning.unit), "{meaning:?}");
        }
        let class = of_trait("area_diameter_0.5_to_1_mm2").unwrap();
        assert_eq!((class.label.as_str(), class.unit), ("Area, 0.5 to 1 mm", "mm²"));
        assert_eq!(of_trait("length_order_3_and_more_mm").unwrap().label, "Length, order 3 and more");
        assert_eq!(of_trait("nothing_mm"), None);
    }

    #[test]
    fn every_column_has_a_meaning() {
        let header = crate::roots::traits::per_root::COLUMNS;
        for column in header {
            assert!(of_column(column).is_some(), "{column} has no meaning");
        }
        assert_eq!(header.len(), COLUMNS.len());
        assert_eq!(of_column("lateral_density_per_mm").unwrap().unit, "1/mm");
        assert_eq!(of_column("surface_area_mm2").unwrap().unit, "mm²");
    }
}
