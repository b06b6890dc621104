//! Traits of a reconstruction against those of the truth.
//!
//! Both sides are cut to the scored region first (of a root, its longest run of points inside), so that what belts and
//! water surface hide counts on neither side.

use super::points::Region;
use super::score::{ScoreParams, turned};
use crate::error::Result;
use crate::optics::Tank;
use crate::roots::Root;
use crate::roots::traits::{TraitParams, traits};
use serde::{Deserialize, Serialize};

/// A trait on both sides; numbers that are not defined (no roots, a flat hull) are none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TraitError {
    /// Name with unit.
    pub name: String,
    /// Value of the true roots.
    pub truth: Option<f64>,
    /// Value of the found roots.
    pub found: Option<f64>,
    /// Found over true value, less 1; none where the true value is 0 or one is none.
    pub error: Option<f64>,
}

/// Measures both sides; `turned_deg` is the turn that [`Score`](super::Score) reports.
///
/// # Errors
/// Where the region or a tolerance is unusable.
pub fn trait_errors(
    truth: &[Root],
    tank: &Tank,
    found: &[Root],
    params: &ScoreParams,
    turned_deg: Option<f64>,
) -> Result<Vec<TraitError>> {
    let region = params.region(tank)?;
    let measure = |roots: &[Root], turn: f64| {
        let roots: Vec<Root> = cut(roots, turn, &region);
        traits(&roots, tank.water_level_mm, &TraitParams::default())
    };
    let defined = |x: f64| x.is_finite().then_some(x);
    let pairs = measure(truth, 0.0).into_iter().zip(measure(found, turned_deg.unwrap_or(0.0)));
    Ok(pairs
        .map(|(t, f)| {
            let (truth, found) = (defined(t.value), defined(f.value));
            let error = truth.filter(|t| *t != 0.0).zip(found).map(|(t, f)| f / t - 1.0);
            TraitError { name: t.name, truth, found, error }
        })
        .collect())
}

/// The roots turned about the axis, each cut to its longest run of points inside; a lateral whose parent is gone springs
/// from none.
fn cut(roots: &[Root], turn: f64, region: &Region) -> Vec<Root> {
    let mut kept: Vec<Root> = roots
        .iter()
        .filter_map(|root| {
            let points = turned(&root.points_mm, turn);
            let (mut best, mut start) = (0..0, 0);
            for end in 0..=points.len() {
                if end == points.len() || !region.holds(&points[end]) {
                    if end - start > best.len() {
                        best = start..end;
                    }
                    start = end + 1;
                }
            }
            let run = (points.get(best.clone())?.to_vec(), root.radii_mm.get(best)?.to_vec());
            (run.0.len() > 1).then(|| Root { points_mm: run.0, radii_mm: run.1, ..root.clone() })
        })
        .collect();
    let ids: std::collections::BTreeSet<i64> = kept.iter().map(|root| root.id).collect();
    for root in &mut kept {
        if !ids.contains(&root.parent) {
            root.parent = -1;
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;
    use crate::simulation::{GrowthParams, grow};

    fn tank() -> Tank {
        Tank {
            radius_mm: 60.0,
            height_mm: 200.0,
            wall_mm: 4.0,
            water_level_mm: 10.0,
            index: Index::default(),
            belts_mm: vec![],
        }
    }

    #[test]
    fn the_truth_has_no_errors_and_thicker_roots_show() {
        let truth = grow(&GrowthParams::default(), &tank(), 1).unwrap();
        let errors = |found: &[Root]| trait_errors(&truth, &tank(), found, &ScoreParams::default(), None).unwrap();
        let own = errors(&truth);
        assert!(own.len() > 20 && own.iter().all(|t| t.error.is_none_or(|e| e == 0.0)), "{own:?}");
        let thick: Vec<Root> = truth
            .iter()
            .map(|r| Root { radii_mm: r.radii_mm.iter().map(|x| 1.1 * x).collect(), ..r.clone() })
            .collect();
        let of = |name: &str| errors(&thick).into_iter().find(|t| t.name == name).unwrap().error.unwrap();
        assert!((of("mean_diameter_mm") - 0.1).abs() < 1e-9 && (of("root_volume_mm3") - 0.21).abs() < 1e-9);
        assert_eq!(of("total_root_length_mm"), 0.0);
        assert!(errors(&[]).iter().all(|t| t.name != "total_root_length_mm" || t.error == Some(-1.0)));
    }

    #[test]
    fn what_lies_outside_counts_on_neither_side() {
        let line = |x: f64, id: i64, parent: i64| Root {
            id,
            parent,
            order: u32::from(parent >= 0),
            points_mm: (0..150).map(|k| [x, 0.0, f64::from(k)]).collect(),
            radii_mm: vec![0.5; 150],
        };
        // The parent lies in the wall: its child stands alone.
        let roots = [line(59.0, 0, -1), line(3.0, 1, 0)];
        let region =
            ScoreParams { z_min_mm: Some(20.5), z_max_mm: 99.5, ..Default::default() }.region(&tank()).unwrap();
        let kept = cut(&roots, 0.0, &region);
        assert_eq!(kept.len(), 1);
        assert_eq!((kept[0].parent, kept[0].points_mm.len(), kept[0].points_mm[0][2]), (-1, 79, 21.0));
    }
}
