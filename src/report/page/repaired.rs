//! Which stretches of the roots a repair touched.

use crate::roots::{RootSystem, repair::Kind};

/// A centreline point this near to a repair's place is coloured by it, mm; where a gap was closed, half the gap.
const REACH_MM: f64 = 1.0;

/// All kinds, in the order of the legend.
pub const KINDS: [Kind; 10] = [
    Kind::Bridged,
    Kind::Extended,
    Kind::Repaired,
    Kind::Attached,
    Kind::Inferred,
    Kind::Opened,
    Kind::Split,
    Kind::Pruned,
    Kind::Corrected,
    Kind::Uncorrected,
];

/// What a kind means, for the legend.
pub fn about(kind: Kind) -> &'static str {
    match kind {
        Kind::Bridged => "a gap between two pieces was closed",
        Kind::Extended => "a loose end was followed further from here",
        Kind::Repaired => "branches changed partners, or a root its parent",
        Kind::Attached => "tied to its parent over a stretch without a ridge",
        Kind::Inferred => "its parent was inferred without a visible tie",
        Kind::Opened => "a closed way was opened",
        Kind::Split => "a piece was cut in two",
        Kind::Pruned => "a piece was left out",
        Kind::Corrected => "a person's correction was applied",
        Kind::Uncorrected => "a person's correction did not find its place",
    }
}

/// Place of the kind in [`KINDS`].
pub fn place(kind: Kind) -> usize {
    KINDS.iter().position(|k| *k == kind).unwrap_or_default()
}

/// For every point of every root the place in [`KINDS`] of the nearest repair that reaches it, or -1. What was left out is
/// not on a root.
pub fn kinds(system: &RootSystem) -> Vec<Vec<i8>> {
    let reach = |r: &crate::roots::Repair| match r.kind {
        Kind::Bridged | Kind::Attached => REACH_MM.max(0.5 * r.length_mm),
        _ => REACH_MM,
    };
    let repairs: Vec<_> = system.repairs.iter().filter(|r| r.kind != Kind::Pruned).map(|r| (r, reach(r))).collect();
    let of = |p: &[f64; 3]| {
        let near = repairs.iter().filter_map(|(r, reach)| {
            let d = (0..3).map(|c| (r.place_mm[c] - p[c]).powi(2)).sum::<f64>().sqrt();
            (d <= *reach).then_some((d, r.kind))
        });
        near.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(-1, |(_, kind)| place(kind) as i8)
    };
    system.roots.iter().map(|r| r.root.points_mm.iter().map(of).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Vec3;
    use crate::roots::{Repair, Root, TracedRoot};

    #[test]
    fn points_take_the_nearest_repair_in_reach() {
        let points_mm: Vec<[f64; 3]> = (0..20).map(|k| [0.0, 0.0, f64::from(k)]).collect();
        let root = Root { id: 0, parent: -1, order: 0, radii_mm: vec![1.0; 20], points_mm };
        let traced = TracedRoot { root, radius_sd_mm: vec![0.0; 20], views: vec![3; 20], confidence: vec![1.0; 20] };
        let repair = |kind, z, length| Repair::new(kind, &Vec3::new(0.0, 0.0, z), length, String::new());
        let repairs =
            vec![repair(Kind::Bridged, 5.0, 6.0), repair(Kind::Split, 7.6, 0.0), repair(Kind::Pruned, 15.0, 9.0)];
        let kinds = &kinds(&RootSystem { roots: vec![traced], spread_px: None, repairs })[0];
        let (bridged, split) = (place(Kind::Bridged) as i8, place(Kind::Split) as i8);
        let wanted: Vec<i8> = (0..20)
            .map(|k| {
                if k == 7 || k == 8 {
                    split
                } else if (2..=6).contains(&k) {
                    bridged
                } else {
                    -1
                }
            })
            .collect();
        assert_eq!(*kinds, wanted);
        assert!(KINDS.iter().enumerate().all(|(n, kind)| place(*kind) == n));
    }
}
