//! How well the roots are supported, measured and tied.

use super::{Finding, Level, level};
use crate::report::page::html::{count, percent};
use crate::roots::repair::Kind;
use crate::roots::traits::Trait;
use crate::roots::{RootSystem, TracedRoot};

/// A point that fewer of the photographs show is weak.
const WEAK: f64 = 0.5;
/// Shares of the length that may be weak.
const WEAK_SHARE: [f64; 2] = [0.10, 0.30];
/// Shares of the length whose diameter may be a neighbour's.
const UNMEASURED: [f64; 2] = [0.20, 0.50];
/// Shares of the length that may be gaps closed.
const CLOSED: [f64; 2] = [0.02, 0.10];

/// Length of the steps whose two points fulfil `is`, and of all, mm.
fn lengths(roots: &[TracedRoot], is: impl Fn(&TracedRoot, usize) -> bool) -> (f64, f64) {
    let (mut some, mut all) = (0.0, 0.0);
    for root in roots {
        for (k, step) in root.root.points_mm.windows(2).enumerate() {
            let length = (0..3).map(|c| (step[1][c] - step[0][c]).powi(2)).sum::<f64>().sqrt();
            all += length;
            some += if is(root, k) && is(root, k + 1) { length } else { 0.0 };
        }
    }
    (some, all)
}

/// All that is said of the roots.
pub fn all(system: &RootSystem, traits: &[Trait]) -> Vec<Finding> {
    let length = traits.iter().find(|t| t.name == "total_root_length_mm").map_or(0.0, |t| t.value);
    if system.roots.is_empty() || length.is_nan() || length <= 0.0 {
        let remedy =
            "Look at the overlays; lower trace.high and trace.low, or set rootness.sigma nearer to the roots' radius.";
        return vec![Finding::new(Level::Warning, "Roots.", "No root was traced.".into(), remedy)];
    }
    vec![support(system), diameters(system), repairs(system, length)]
}

fn support(system: &RootSystem) -> Finding {
    let (weak, all) = lengths(&system.roots, |r, k| r.confidence[k] < WEAK);
    let text = format!(
        "{} of the length shows in fewer than half of the photographs that look at it unhindered.",
        percent(weak, all)
    );
    let remedy = "Colour the 3D view by confidence to see where. Roots that swayed, hide each other or stand out little are weak.";
    Finding::new(level(weak / all, WEAK_SHARE[0], WEAK_SHARE[1]), "Support.", text, remedy)
}

fn diameters(system: &RootSystem) -> Finding {
    let topic = "Diameters.";
    let Some(spread_px) = system.spread_px else {
        let text = "Not measured in the photographs: they stand on the scale of the ridge alone.".to_owned();
        return Finding::new(Level::Note, topic, text, "Set diameters.enabled = true.");
    };
    let (taken, all) = lengths(&system.roots, |r, k| r.views[k] == 0);
    let text = format!(
        "Measured in the photographs, with a point spread of {spread_px:.2} px (standard deviation); along {} of the length they are the neighbours'.",
        percent(taken, all)
    );
    let remedy = "Where no photograph sees a root past the others its diameter is taken from beside; volume and surface are less certain.";
    Finding::new(level(taken / all, UNMEASURED[0], UNMEASURED[1]), topic, text, remedy)
}

fn repairs(system: &RootSystem, length: f64) -> Finding {
    let of = |kind: Kind| system.repairs.iter().filter(move |r| r.kind == kind);
    let closed: f64 = of(Kind::Bridged).chain(of(Kind::Attached)).map(|r| r.length_mm).sum();
    let guessed = of(Kind::Inferred).count();
    let text = format!(
        "{} closed, {} of the length; {} followed further; {} without a visible tie.",
        count(of(Kind::Bridged).count() + of(Kind::Attached).count(), "gap was", "gaps were"),
        percent(closed, length),
        count(of(Kind::Extended).count(), "end was", "ends were"),
        count(guessed, "parent was inferred", "parents were inferred"),
    );
    let share = guessed as f64 / system.roots.len() as f64;
    let level = level(closed / length, CLOSED[0], CLOSED[1]).min(level(share, 0.10, 0.30));
    Finding::new(
        level,
        "Repairs.",
        text,
        "Colour the 3D view by what was repaired; orders and counts depend on these most.",
    )
}
