//! Cameras, coverage, unseen water.

use super::{CameraOrigin, Evidence, Finding, Level, level};
use crate::evaluation::{BAND_MM, Place, Sight};
use crate::optics::View;
use crate::report::page::html::{count, percent};
use std::fmt::Write;

/// Errors of cameras up to which hardly anything is lost, and from which roots fall apart, px.
const CAMERA_PX: [f64; 2] = [0.7, 1.4];
/// Photographs that are enough all round, and with which roots begin to be lost.
const VIEWS: [usize; 2] = [18, 12];
/// Gaps between neighbouring cameras, degrees: about 18 and 8 photographs all round.
const GAP_DEG: [f64; 2] = [25.0, 50.0];
/// Shares of the water that may be unseen.
const UNSEEN: [f64; 2] = [0.02, 0.10];

/// Where the cameras came from and how good they are.
pub fn cameras(e: &Evidence<'_>) -> Finding {
    let topic = "Cameras.";
    match (&e.cameras, e.camera_errors) {
        (CameraOrigin::Found(q), errors) => {
            let mut text = format!("Found in the photographs; matched points fit within {:.2} px.", q.sfm_rms_px);
            let wall_px = q.adjustment.as_ref().map(|a| a.uncertainty.wall_px);
            if let Some(px) = wall_px {
                let _ = write!(text, " Points on the tank's wall are certain to {px:.2} px.");
            }
            if let Some(errors) = errors {
                let _ = write!(text, " Against the truth of the simulation: {:.2} px.", errors.water_rms_px);
            }
            let worst = wall_px.into_iter().chain(errors.map(|e| e.water_rms_px)).fold(q.sfm_rms_px, f64::max);
            Finding::new(
                level(worst, CAMERA_PX[0], CAMERA_PX[1]),
                topic,
                text,
                "Look at calibration/ beside this page; more photographs, sharper ones, or belts at both ends help.",
            )
        }
        (CameraOrigin::Simulated, Some(errors)) => Finding::new(
            level(errors.water_rms_px, CAMERA_PX[0], CAMERA_PX[1]),
            topic,
            format!("Those of the simulated capture; they miss the true ones by {:.2} px.", errors.water_rms_px),
            "The study misjudges them on purpose: [simulate.misjudge].",
        ),
        (CameraOrigin::Simulated, None) => {
            Finding::new(Level::Good, topic, "Those of the simulated capture.".into(), "")
        }
        (CameraOrigin::File, _) => Finding::new(
            Level::Note,
            topic,
            "Taken from a file as they are; nothing here checks them.".into(),
            "Look at the photographs below: lines beside their roots, on one side in all of them, show a wrong pose or tank.",
        ),
    }
}

/// Directions of the cameras from the tank's axis, degrees, 0..360.
pub fn directions(views: &[View]) -> Vec<f64> {
    views.iter().map(|v| v.centre_in_tank()).map(|c| c.y.atan2(c.x).to_degrees().rem_euclid(360.0)).collect()
}

/// How many photographs there are, and where none was taken from.
pub fn coverage(views: &[View]) -> Option<Finding> {
    let mut sorted = directions(views);
    sorted.sort_by(f64::total_cmp);
    let (first, last) = (*sorted.first()?, *sorted.last()?);
    let gaps = sorted.windows(2).map(|w| (w[1] - w[0], w[0])).chain([(first + 360.0 - last, last)]);
    let (gap, from) = gaps.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let many = if views.len() >= VIEWS[0] {
        Level::Good
    } else if views.len() >= VIEWS[1] {
        Level::Note
    } else {
        Level::Warning
    };
    let text = format!(
        "{} from all round; the largest gap between neighbours is {gap:.0}°, from {from:.0}° to {:.0}°.",
        count(views.len(), "photograph", "photographs"),
        (from + gap).rem_euclid(360.0)
    );
    let text = if gap > 180.0 { text.replacen(" from all round", "", 1) } else { text };
    let remedy = "Take 18 photographs or more at even steps all the way round.";
    Some(Finding::new(many.min(level(gap, GAP_DEG[0], GAP_DEG[1])), "Coverage.", text, remedy))
}

fn name(place: Place) -> &'static str {
    match place {
        Place::Belt => "level with a belt",
        Place::Surface => "under the water surface",
        Place::Floor => "over the floor",
        Place::Wall => "at the wall",
        Place::Elsewhere => "elsewhere",
    }
}

/// How much of the water too few photographs see.
pub fn water(sight: &[Sight]) -> Option<Finding> {
    let (voxels, unseen) = sight.iter().fold((0, 0), |(v, u), s| (v + s.voxels, u + s.unseen));
    if voxels == 0 {
        return None;
    }
    let share = unseen as f64 / voxels as f64;
    let most = sight.iter().max_by_key(|s| s.unseen)?;
    let mut text = if unseen == 0 {
        "Enough photographs see all of the water in the grid.".to_owned()
    } else {
        format!(
            "Too few photographs see {} of the water in the grid; {} of that is {}. No root is found there, and no trait counts it.",
            percent(unseen as f64, voxels as f64),
            percent(most.unseen as f64, unseen as f64),
            name(most.place)
        )
    };
    let missed: f64 = sight.iter().filter_map(|s| s.unseen_length_mm).sum();
    if missed >= 0.5 {
        let _ = write!(text, " {missed:.0} mm of the true roots lie there.");
    }
    let remedy = match most.place {
        Place::Belt => "Narrower belts, or a camera a little over or under them, show more.",
        Place::Surface => "A camera level with the water surface or below shows more.",
        Place::Floor => "A camera level with the middle of the tank or higher shows more.",
        Place::Wall | Place::Elsewhere => "Photographs from more sides, with the whole tank in the picture, show more.",
    };
    Some(Finding::new(level(share, UNSEEN[0], UNSEEN[1]), "Unseen water.", text, remedy))
}

/// What is seen, and how right the result is, by part of the water; folded.
pub fn table(e: &Evidence<'_>, t: &mut String) {
    let water: usize = e.sight.iter().map(|s| s.voxels).sum();
    if water == 0 {
        return;
    }
    let _ = write!(
        t,
        "<details><summary>What the photographs see, by part of the water</summary>\n<p>Voxels that too few photographs see are left \
         unknown and hold no root; nothing else is left out. Bands are {BAND_MM} mm wide.</p>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" \
         aria-label=\"What the photographs see\"><table><thead><tr><th scope=\"col\">Part</th><th scope=\"col\" class=\"n\">Share of the water</th>\
         <th scope=\"col\" class=\"n\">Unseen</th>"
    );
    if !e.bands.is_empty() {
        for title in ["True roots", "Of them unseen", "Recall 1 mm", "Points", "Precision 1 mm"] {
            let _ = write!(t, "<th scope=\"col\" class=\"n\">{title}</th>");
        }
    }
    t.push_str("</tr></thead><tbody>\n");
    for s in e.sight.iter().filter(|s| s.voxels > 0) {
        let (voxels, unseen) = (s.voxels as f64, s.unseen as f64);
        let mut cells = vec![percent(voxels, water as f64), percent(unseen, voxels)];
        if let Some(band) = e.bands.iter().find(|b| b.place == s.place) {
            let share = |x: Option<f64>| x.map_or("–".to_owned(), |x| format!("{x:.3}"));
            let length = s.true_length_mm.unwrap_or(0.0);
            cells.push(format!("{length:.0} mm"));
            cells.push(percent(s.unseen_length_mm.unwrap_or(0.0), length));
            cells.extend([share(band.recall), band.points.to_string(), share(band.precision)]);
        }
        let _ = write!(t, "<tr><th scope=\"row\">{}</th>", name(s.place));
        for cell in cells {
            let _ = write!(t, "<td class=\"n\">{cell}</td>");
        }
        t.push_str("</tr>\n");
    }
    t.push_str("</tbody></table></div></details>\n");
}
