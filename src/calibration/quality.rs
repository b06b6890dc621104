//! How well the photographs bear a registration out, in numbers and in words.

use super::adjust::{Adjusted, Network, Turning, Uncertainty};
use crate::math::robust::median;
use serde::{Deserialize, Serialize};

/// How well the photographs bear the registration out.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Quality {
    /// Reprojection of structure from motion, root mean square px.
    pub sfm_rms_px: f64,
    /// Height of the tank by the photographs, given its radius, mm; `None` where rim or floor is not seen.
    pub seen_height_mm: Option<f64>,
    /// The joint adjustment, where it was made.
    pub adjustment: Option<Adjustment>,
    /// Median distance of the tank region's contour from the silhouette, px, where silhouettes were registered.
    pub contour_median_px: Option<f64>,
}

/// Numbers of the joint adjustment.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Adjustment {
    /// Belt points.
    pub belt_points: usize,
    /// Sightings of belt points.
    pub sightings: usize,
    /// Robust standard deviation of a sighting seen from the front, per coordinate, px.
    pub belt_sigma_px: f64,
    /// Root mean square of all sightings' residuals, px.
    pub belt_rms_px: f64,
    /// Robust standard deviation of the rings' edges about their common shifts, px; 0 without any.
    pub outline_sigma_px: f64,
    /// By how much the printed surface's radius exceeds the tank's and the print's together, mm.
    pub thicker_mm: f64,
    /// Common shift of each contour's edge that was seen against the adjusted tank, px, with the contour's name.
    pub edge_offsets_px: Vec<(String, f64)>,
    /// Median residual of each view's belt points, px.
    pub view_residuals_px: Vec<f64>,
    /// How the table turned.
    pub turning: Turning,
    /// Standard deviations.
    pub uncertainty: Uncertainty,
}

impl Adjustment {
    pub(super) fn of(network: &Network, adjusted: &Adjusted) -> Self {
        Self {
            belt_points: network.tracks.len(),
            sightings: network.tracks.iter().map(Vec::len).sum(),
            belt_sigma_px: adjusted.belt_sigma_px,
            belt_rms_px: adjusted.belt_rms_px,
            outline_sigma_px: if network.outline.is_empty() { 0.0 } else { adjusted.outline_sigma_px },
            thicker_mm: adjusted.thicker_mm,
            edge_offsets_px: (0..network.contours.len())
                .filter(|&contour| network.seen(contour) > 0)
                .map(|contour| (network.contours[contour].name.clone(), adjusted.edge_offsets_px[contour]))
                .collect(),
            view_residuals_px: adjusted.view_residuals_px.clone(),
            turning: adjusted.turning.clone(),
            uncertainty: adjusted.uncertainty.clone(),
        }
    }
}

/// Says what the user should know.
pub(super) fn warn(network: &Network, quality: &Adjustment, names: &[&str], warnings: &mut Vec<String>) {
    let photos = names.len();
    // Sides show where the room is not as bright as the print only: they are a help, no need.
    let rings: Vec<usize> = (0..network.contours.len()).filter(|&k| !network.contours[k].is_side()).collect();
    for &ring in rings.iter().filter(|&&ring| network.seen(ring) < photos) {
        let (name, places) = (&network.contours[ring].name, network.seen(ring));
        warnings.push(format!("the {name} was seen at {places} places in {photos} photographs only"));
    }
    if !rings.iter().any(|&ring| network.seen(ring) >= photos) {
        warnings.push(
            "neither rim nor floor is seen: the cameras' height against the tank rests on the middle of the belts"
                .into(),
        );
    }
    for (name, offset) in &quality.edge_offsets_px {
        if offset.abs() > 0.5 {
            warnings.push(format!(
                "the {name} is seen {:.1} px {} of where the tank's size puts it: check tank.radius, tank.height and the belts' thickness",
                offset.abs(),
                if *offset > 0.0 { "outwards" } else { "inwards" }
            ));
        }
    }
    if quality.belt_rms_px > 1.0 {
        warnings.push(format!("belt points miss their places by {:.2} px (root mean square)", quality.belt_rms_px));
    }
    let typical = median(&mut quality.view_residuals_px.clone());
    for (k, r) in quality.view_residuals_px.iter().enumerate().filter(|(_, r)| **r > (5.0 * typical).max(0.2)) {
        let name = names[k];
        warnings.push(format!("`{name}` misses its belt points by {r:.2} px, the others by {typical:.2} px"));
    }
    turned(&quality.turning, names, warnings);
    let (thicker, sigma) = (quality.thicker_mm, quality.uncertainty.radius_mm);
    if thicker.abs() > THICKER_MM.max(3.0 * sigma) {
        warnings.push(format!(
            "the print lies at a radius {:.2} mm {} than tank.radius and pose.print_thickness_mm say (standard deviation {sigma:.2} \
             mm): the tank is {0:.2} mm {1} in radius, or the print is not as thick; the cameras go by what was seen, the water and its \
             wall by tank.radius: give it that much {1} if the print's thickness is right",
            thicker.abs(),
            if thicker > 0.0 { "larger" } else { "smaller" }
        ));
    }
    if quality.uncertainty.wall_px > 0.5 {
        warnings.push(format!(
            "points on the tank's wall are uncertain by {:.2} px: more views or belts at both ends would help",
            quality.uncertainty.wall_px
        ));
    }
}

/// From so much on the printed surface's radius is told of, mm: what a tape measure and paper may be off.
const THICKER_MM: f64 = 0.15;
/// A table that wobbles, or has play, by less is as good as can be had: degrees, mm.
const WOBBLE: (f64, f64) = (0.05, 0.3);

/// A camera that was moved, or a table that wobbles, and what was done about it.
fn turned(turning: &Turning, names: &[&str], warnings: &mut Vec<String>) {
    if let Some(bump) = &turning.bump {
        warnings.push(format!(
            "the camera was moved before `{}`: the table's axis lies {:.2} mm and {:.2} degrees elsewhere in its picture from then on; \
             the poses follow, and the one axis holds them together less",
            names[bump.view], bump.moved_mm, bump.turned_deg
        ));
    } else if turning.wobble_deg > WOBBLE.0 || turning.play_mm > WOBBLE.1 {
        warnings.push(format!(
            "the table does not turn about one axis: half of the photographs are off by over {:.2} degrees or {:.2} mm; the poses \
             follow it. Is the tank fixed on the table, and the camera on its tripod?",
            turning.wobble_deg, turning.play_mm
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::super::adjust::Bump;
    use super::*;

    #[test]
    fn what_moved_is_told_with_its_photograph() {
        let of = |turning: &Turning| {
            let mut warnings = Vec::new();
            turned(turning, &["a.jpg", "b.jpg"], &mut warnings);
            warnings
        };
        let still = Turning { tilt_deg: 1.0, offset_mm: 2.0, wobble_deg: 0.01, play_mm: 0.02, bump: None };
        assert!(of(&still).is_empty());
        let wobbling = Turning { play_mm: 0.5, ..still.clone() };
        assert!(of(&wobbling)[0].contains("0.50 mm"));
        let bump = Some(Bump { view: 1, moved_mm: 1.8, turned_deg: 0.5 });
        let told = of(&Turning { bump, ..wobbling });
        assert!(
            told.len() == 1 && told[0].contains("`b.jpg`: the table's axis lies 1.80 mm and 0.50 degrees"),
            "{told:?}"
        );
    }
}
