//! Scores as tables for people.

use crate::evaluation::{CameraErrors, Class, Detail, Matched, Score, TraitError};
use std::fmt::Write;

/// The score as lines of text.
pub fn table(score: &Score) -> String {
    let mut text = String::from("tolerance  precision  recall     F1\n");
    for a in &score.at {
        let _ = writeln!(text, "{:6.1} mm  {:9.3}  {:6.3}  {:5.3}", a.tolerance_mm, a.precision, a.recall, a.f1);
    }
    let _ = write!(text, "{} points, {:.0} mm of true roots", score.points, score.true_length_mm);
    if let Some(rms) = score.rms_mm {
        let _ = write!(text, ", rms {rms:.3} mm");
    }
    if let Some(bias) = score.length_bias {
        let _ = write!(text, ", length {:+.1} %", bias * 100.0);
    }
    if let Some(turn) = score.turned_deg {
        let _ = write!(text, ", turned by {turn:.2}°");
    }
    text
}

/// Where a reconstruction is right: by diameter, depth and distance to the wall, at its ends, at its worst.
pub fn detail_table(detail: &Detail) -> String {
    let mut text = String::new();
    let kinds = [
        ("by true diameter", &detail.by_diameter),
        ("by depth", &detail.by_depth),
        ("by distance to the wall", &detail.by_wall_distance),
    ];
    for (title, classes) in kinds {
        let _ = writeln!(text, "{title:<24} true length  recall  precision  diameter");
        for class in classes.iter().filter(|c| c.recall.is_some() || c.precision.is_some()) {
            let _ = writeln!(text, "{}", class_line(class));
        }
    }
    for (name, matched) in [("tips", detail.tips), ("branch points", detail.branch_points)] {
        if let Some(m @ Matched { truth, found, matched }) = matched {
            let _ = writeln!(
                text,
                "{name}: {matched} of {truth} found within 2 mm, {found} reported (recall {:.2}, precision {:.2})",
                m.recall(),
                m.precision()
            );
        }
    }
    if let Some(d) = detail.hausdorff95_mm {
        let _ = writeln!(text, "95 % of all distances are within {d:.2} mm");
    }
    text.trim_end().to_owned()
}

fn class_line(class: &Class) -> String {
    let share = |x: Option<f64>| x.map_or("-".into(), |x| format!("{x:.3}"));
    let to = class.to_mm.map_or("".into(), |to| to.to_string());
    format!(
        "{:>10} to {to:<7} mm  {:>8.0} mm  {:>6}  {:>9}  {:>8}",
        class.from_mm,
        class.true_length_mm,
        share(class.recall),
        share(class.precision),
        class.diameter_bias.map_or("-".into(), |x| format!("{:+.1} %", x * 100.0))
    )
}

/// Traits beside the true ones.
pub fn traits_table(traits: &[TraitError]) -> String {
    let number = |x: Option<f64>| x.map_or("-".into(), |x| format!("{x:.2}"));
    let mut text = format!("{:<34}{:>14}{:>14}{:>10}", "trait", "true", "found", "error");
    for t in traits.iter().filter(|t| t.truth.is_some() || t.found.is_some()) {
        let error = t.error.map_or("-".into(), |e| format!("{:+.1} %", e * 100.0));
        let _ = write!(text, "\n{:<34}{:>14}{:>14}{error:>10}", t.name, number(t.truth), number(t.found));
    }
    text
}

/// Errors of the cameras in a line.
pub fn cameras_line(c: &CameraErrors) -> String {
    format!(
        "cameras: {} views; axis tilted by {:.3}°, off by {:.3} mm; height {:+.3} mm; scale {:+.4} %; points in the \
         water {:.3} px rms",
        c.views,
        c.axis_tilt_deg,
        c.axis_offset_mm,
        c.height_mm,
        c.scale * 100.0,
        c.water_rms_px
    )
}
