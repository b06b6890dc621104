//! How the roots spread over depth.

use super::{Step, TraitParams, weighted_quantile};
use crate::optics::Vec3;
use crate::roots::Root;

/// Planes at which crossing roots are counted lie this far apart, mm.
const PLANE_MM: f64 = 1.0;

/// A layer of the depth profile.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Layer {
    /// Upper border, mm under the water surface.
    pub depth_from_mm: f64,
    /// Lower border, mm under the water surface.
    pub depth_to_mm: f64,
    /// Root length within, mm.
    pub length_mm: f64,
    /// Root volume within, mm³.
    pub volume_mm3: f64,
    /// Root tips within.
    pub tips: usize,
    /// Diameter of the smallest circle about the centreline points within, mm.
    pub width_mm: f64,
}

/// The depth profile; a step counts in the layer of its middle.
pub fn profile(roots: &[Root], water_level_mm: f64, params: &TraitParams) -> Vec<Layer> {
    let steps = super::steps(roots);
    let deepest = steps.iter().map(|s| s.z() - water_level_mm).fold(f64::NEG_INFINITY, f64::max);
    if !deepest.is_finite() || params.layer_mm <= 0.0 {
        return Vec::new();
    }
    let n = (deepest.max(0.0) / params.layer_mm) as usize + 1;
    let layer = |z: f64| (((z - water_level_mm).max(0.0) / params.layer_mm) as usize).min(n - 1);
    let mut layers: Vec<Layer> = (0..n)
        .map(|k| Layer {
            depth_from_mm: k as f64 * params.layer_mm,
            depth_to_mm: (k + 1) as f64 * params.layer_mm,
            length_mm: 0.0,
            volume_mm3: 0.0,
            tips: 0,
            width_mm: 0.0,
        })
        .collect();
    let mut points: Vec<Vec<[f64; 2]>> = vec![Vec::new(); n];
    for step in &steps {
        let k = layer(step.z());
        layers[k].length_mm += step.length();
        layers[k].volume_mm3 += step.volume();
        points[k].extend(step.ends.map(|p| [p.x, p.y]));
    }
    for tip in roots.iter().filter_map(|r| r.points_mm.last()) {
        layers[layer(tip[2])].tips += 1;
    }
    for (layer, points) in layers.iter_mut().zip(&points) {
        layer.width_mm = 2.0 * super::hull::circle(&super::hull::planar(points)).1;
    }
    layers
}

/// Depth, its quantiles, crossings of horizontal planes, shares above and below.
pub(super) fn traits(steps: &[Step], roots: &[Root], water_level_mm: f64, put: &mut impl FnMut(&str, f64)) {
    let points = || roots.iter().flat_map(|r| &r.points_mm).map(|p| Vec3::from(*p));
    let top = points().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let bottom = points().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    let mut by_depth: Vec<(f64, f64)> = steps.iter().map(|s| (s.z() - water_level_mm, s.length())).collect();
    let length: f64 = by_depth.iter().map(|d| d.1).sum();
    let volume: f64 = steps.iter().map(Step::volume).sum();
    let n = points().count() as f64;
    put("depth_max_mm", bottom - water_level_mm);
    put("height_mm", bottom - top);
    put("depth_d50_mm", weighted_quantile(&mut by_depth, 0.5));
    put("depth_d95_mm", weighted_quantile(&mut by_depth, 0.95));
    put("depth_mean_mm", by_depth.iter().map(|d| d.0 * d.1).sum::<f64>() / length);
    put("root_distribution_index_mm", points().map(|p| p.z - water_level_mm).sum::<f64>() / n);
    let centroid: f64 = steps.iter().map(|s| (s.z() - water_level_mm) * s.volume()).sum();
    put("centroid_depth_mm", centroid / volume);
    let third = top + (bottom - top) / 3.0;
    let below = |of: fn(&Step) -> f64| steps.iter().filter(|s| s.z() > third).map(of).sum::<f64>();
    put("length_share_lower_two_thirds", below(Step::length) / length);
    put("volume_share_lower_two_thirds", below(Step::volume) / volume);
    let planes = ((bottom - top) / PLANE_MM).floor().max(0.0) as usize;
    let mut crossings: Vec<f64> = (0..if planes > 0 { planes } else { 0 })
        .map(|k| top + (k as f64 + 0.5) * PLANE_MM)
        .map(|z| steps.iter().filter(|s| (s.ends[0].z < z) != (s.ends[1].z < z)).count() as f64)
        .collect();
    crossings.sort_by(f64::total_cmp);
    let quantile = |share: f64| {
        let at = (share * crossings.len() as f64).ceil() as usize;
        crossings.get(at.max(1) - 1).copied().unwrap_or(f64::NAN)
    };
    put("median_roots", quantile(0.5));
    put("max_roots_84", quantile(0.84));
    put("max_roots", quantile(1.0));
    put("bushiness", quantile(0.84) / quantile(0.5));
}
