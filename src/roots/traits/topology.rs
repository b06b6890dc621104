//! Counts, orders, branching, Fitter's topology.

use crate::optics::Vec3;
use crate::roots::{Root, curve};

/// Arc position on its parent at which a root springs, mm: that of the parent's point nearest to its first one.
pub fn insertion_mm(root: &Root, parent: &Root) -> f64 {
    let Some(first) = root.points_mm.first().map(|p| Vec3::from(*p)) else { return f64::NAN };
    let arc = curve::chord_lengths(&parent.points_mm);
    (0..arc.len())
        .min_by(|&a, &b| {
            let distance = |k: usize| (Vec3::from(parent.points_mm[k]) - first).norm_squared();
            distance(a).total_cmp(&distance(b))
        })
        .map_or(f64::NAN, |k| arc[k])
}

/// Length of a root's centreline, mm.
pub fn length_mm(root: &Root) -> f64 {
    curve::chord_lengths(&root.points_mm).last().copied().unwrap_or(0.0)
}

/// Links (stretches between branching points) from the base of the system to the tip of each root.
fn links_to_tip(roots: &[Root]) -> Vec<usize> {
    let at = |id: i64| roots.iter().position(|r| r.id == id);
    let insertions: Vec<Option<(usize, f64)>> =
        roots.iter().map(|r| at(r.parent).map(|p| (p, insertion_mm(r, &roots[p])))).collect();
    let before = |parent: usize, limit: f64| {
        let mut places: Vec<f64> =
            insertions.iter().flatten().filter(|(p, s)| *p == parent && *s < limit).map(|i| i.1).collect();
        places.sort_by(f64::total_cmp);
        places.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        places.len()
    };
    (0..roots.len())
        .map(|r| {
            let mut links = before(r, f64::INFINITY) + 1;
            let mut child = r;
            // A system is no deeper than it has roots.
            for _ in 0..roots.len() {
                let Some((parent, s)) = insertions[child] else { break };
                links += before(parent, s - 1e-6) + 1;
                child = parent;
            }
            links
        })
        .collect()
}

pub(super) fn traits(roots: &[Root], length: f64, put: &mut impl FnMut(&str, f64)) {
    let laterals = roots.iter().filter(|r| r.parent >= 0).count() as f64;
    put("root_count", roots.len() as f64);
    put("root_tip_count", roots.len() as f64);
    put("branch_point_count", laterals);
    put("branching_frequency_per_mm", laterals / length);
    // Orders over 3 are rare: their sum keeps the table's columns the same for every plant.
    for (name, orders) in [("0", 0..=0), ("1", 1..=1), ("2", 2..=2), ("3_and_more", 3..=u32::MAX)] {
        let of: Vec<f64> = roots.iter().filter(|r| orders.contains(&r.order)).map(length_mm).collect();
        let sum: f64 = of.iter().sum();
        put(&format!("count_order_{name}"), of.len() as f64);
        put(&format!("length_order_{name}_mm"), sum);
        put(&format!("mean_length_order_{name}_mm"), sum / of.len() as f64);
    }
    let order = |n: u32| roots.iter().filter(move |r| r.order == n);
    put("lateral_density_order_1_per_mm", order(1).count() as f64 / order(0).map(length_mm).sum::<f64>());
    put("lateral_density_order_2_per_mm", order(2).count() as f64 / order(1).map(length_mm).sum::<f64>());
    let links = links_to_tip(roots);
    put("altitude_links", links.iter().max().map_or(f64::NAN, |m| *m as f64));
    put("external_path_length_links", links.iter().sum::<usize>() as f64);
}
