//! What a check says, and from where on.

use super::Glance;
use super::ring::Ring;
use super::still::Room;
use crate::math::robust::median;

/// How serious a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Take photographs again.
    Fault,
    /// Good to know.
    Note,
}

/// Something that a person should know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// How serious it is.
    pub level: Level,
    /// What it is, with the photographs' names.
    pub text: String,
    /// What to do.
    pub remedy: String,
    /// The photographs that it is about.
    pub photos: Vec<usize>,
}

/// Photographs that a text names.
const MOST_NAMED: usize = 6;
/// Fewer photographs are a fault, a note.
const FEW: [usize; 2] = [12, 18];
/// A larger step of the table is a fault, a note; degrees.
const GAPS_DEG: [f64; 2] = [50.0, 25.0];
/// A larger blur is a fault, px of a photograph of 968 px width.
const BLURRED_PX: f64 = 1.0;
/// So is one that exceeds that of most others by more.
const BLURRED_BESIDE_PX: f64 = 0.3;
/// A gain that differs by more is a fault, a note.
const GAINS: [f64; 2] = [0.3, 0.1];
/// A share of clipped pixels over which a photograph is overexposed.
const CLIPPED: f64 = 0.25;
/// A camera's picture that moves by more from one photograph to the next, px of a photograph of 968 px width.
const MOVED_PX: f64 = 0.5;
/// Less of the room that stands still is none.
const STILL: f64 = 0.3;

fn finding(level: Level, text: String, remedy: &str, photos: &[usize]) -> Finding {
    Finding { level, text, remedy: remedy.into(), photos: photos.to_vec() }
}

fn named(photos: &[usize], names: &[String]) -> String {
    let listed: Vec<String> = photos.iter().take(MOST_NAMED).map(|k| format!("`{}`", names[*k])).collect();
    let more = photos.len().saturating_sub(MOST_NAMED);
    if more > 0 { format!("{} and {more} more", listed.join(", ")) } else { listed.join(", ") }
}

/// Too few photographs.
pub(super) fn number(n: usize) -> Vec<Finding> {
    let level = if n < FEW[0] { Level::Fault } else { Level::Note };
    let few = finding(
        level,
        format!("{n} photograph{} only", if n == 1 { "" } else { "s" }),
        "turn the table by 10 to 20 degrees from one to the next: 18 to 36 in all",
        &[],
    );
    if n < FEW[1] { vec![few] } else { Vec::new() }
}

/// Photographs with equal pixels.
pub(super) fn twins(glances: &[Glance], names: &[String]) -> Vec<Finding> {
    let mut all = Vec::new();
    for (k, glance) in glances.iter().enumerate() {
        if let Some(first) = glances[..k].iter().position(|g| g.pixels == glance.pixels) {
            let text = format!("{} and {} are one photograph", named(&[first], names), named(&[k], names));
            all.push(finding(Level::Fault, text, "leave one of them out", &[first, k]));
        }
    }
    all
}

/// No belts.
pub(super) fn no_belts(needs_belts: bool) -> Finding {
    let (level, remedy) = if needs_belts {
        (Level::Fault, "print some with `rootvox belt`, or give cameras from elsewhere; the camera must stand still")
    } else {
        (Level::Note, "without them the order of the photographs and gaps between them are not checked")
    };
    finding(level, "no printed belts are seen".into(), remedy, &[])
}

/// The ring of photographs: its order, its gaps, photographs of one place.
pub(super) fn around(ring: &Ring, glances: &[Glance], names: &[String], needs_belts: bool) -> Vec<Finding> {
    let mut all = Vec::new();
    let belts = if needs_belts { Level::Fault } else { Level::Note };
    if ring.order.len() < 3 {
        let text = "the belts' print cannot be read: no photographs share any".to_owned();
        return vec![finding(
            belts,
            text,
            "a random print of high contrast, sharp and evenly lit, steps under 30 degrees",
            &[],
        )];
    }
    if !ring.alone.is_empty() {
        let text = format!("{} share no print of the belts with any other", named(&ring.alone, names));
        all.push(finding(belts, text, "are they of this tank, sharp, and with belts that nothing hides?", &ring.alone));
    }
    for &(a, b) in ring.alike.iter().filter(|(a, b)| glances[*a].pixels != glances[*b].pixels) {
        let text = format!("{} and {} show the tank from the same side", named(&[a], names), named(&[b], names));
        all.push(finding(Level::Note, text, "one of them adds nothing; was the table turned?", &[a, b]));
    }
    for (k, before, after) in out_of_place(&ring.order) {
        let text = format!(
            "{} is out of order: by its belts it was taken between {} and {}",
            named(&[k], names),
            named(&[before], names),
            named(&[after], names)
        );
        all.push(finding(Level::Fault, text, "name the photographs in the order in which the table turned", &[k]));
    }
    let known: f64 = ring.steps_deg.iter().flatten().sum();
    let unknown = ring.steps_deg.iter().filter(|step| step.is_none()).count();
    for (at, step) in ring.steps_deg.iter().enumerate() {
        let (from, to) = (ring.order[at], ring.order[(at + 1) % ring.order.len()]);
        let between = format!("between {} and {}", named(&[from], names), named(&[to], names));
        let (deg, text) = match step {
            Some(step) => (*step, format!("the table was turned by {step:.0} degrees {between}")),
            None if unknown == 1 => {
                let rest = (360.0 - known).max(0.0);
                (rest, format!("about {rest:.0} degrees of the ring are missing {between}"))
            }
            None => (360.0, format!("a part of the ring is missing {between}: they share no print")),
        };
        if deg > GAPS_DEG[1] {
            let level = if deg > GAPS_DEG[0] { Level::Fault } else { Level::Note };
            all.push(finding(
                level,
                text,
                "photograph what is between: steps of 10 to 20 degrees, all the way round",
                &[from, to],
            ));
        }
    }
    all
}

/// Photographs that a run in order leaves out, each with those before and after it; `order` begins with the first.
fn out_of_place(order: &[usize]) -> Vec<(usize, usize, usize)> {
    let n = order.len();
    // The longest increasing run through the order, by its last place.
    let (mut length, mut from) = (vec![1_usize; n], vec![None; n]);
    for at in 0..n {
        for before in (0..at).filter(|&b| order[b] < order[at]) {
            if length[before] + 1 > length[at] {
                (length[at], from[at]) = (length[before] + 1, Some(before));
            }
        }
    }
    let mut in_place = vec![false; n];
    let mut at = (0..n).max_by_key(|&at| length[at]);
    while let Some(place) = at {
        in_place[place] = true;
        at = from[place];
    }
    let odd = (0..n).filter(|&at| !in_place[at]);
    odd.map(|at| (order[at], order[(at + n - 1) % n], order[(at + 1) % n])).collect()
}

/// Blur.
pub(super) fn sharpness(blurs: &[f64], names: &[String]) -> Vec<Finding> {
    let usual = median(&mut blurs.to_vec());
    let limit = BLURRED_PX.min(usual + BLURRED_BESIDE_PX).max(0.5);
    let blurred: Vec<usize> = (0..blurs.len()).filter(|k| blurs[*k] >= limit).collect();
    if blurred.is_empty() {
        return Vec::new();
    }
    let (text, remedy) = if 2 * blurred.len() > blurs.len() {
        (
            format!("the photographs are blurred, by {usual:.1} px of a picture of 968 px width"),
            "focus by hand on the front of the tank's middle, close the aperture",
        )
    } else {
        (
            format!("{} blurred more than the others", is_or_are(&blurred, names)),
            "take them again: autofocus off, wait until the water is calm, use a remote release",
        )
    };
    vec![finding(Level::Fault, text, remedy, &blurred)]
}

fn is_or_are(photos: &[usize], names: &[String]) -> String {
    format!("{} {}", named(photos, names), if photos.len() == 1 { "is" } else { "are" })
}

/// Exposure.
pub(super) fn light(room: &Room, glances: &[Glance], names: &[String]) -> Vec<Finding> {
    let mut all = Vec::new();
    let usual = median(&mut room.gains.clone()).max(1e-6);
    let off = |k: &usize| (room.gains[*k] / usual - 1.0).abs();
    let odd: Vec<usize> = (0..room.gains.len()).filter(|k| off(k) > GAINS[1]).collect();
    if let Some(most) = odd.iter().copied().max_by(|a, b| off(a).total_cmp(&off(b))) {
        let level = if off(&most) > GAINS[0] { Level::Fault } else { Level::Note };
        let text = format!(
            "the light changes: {} of another brightness than most, {} by {:.0} %",
            is_or_are(&odd, names),
            named(&[most], names),
            100.0 * (room.gains[most] / usual - 1.0)
        );
        all.push(finding(
            level,
            text,
            "exposure, aperture and white balance by hand; curtains and lamps as they are",
            &odd,
        ));
    }
    let white: Vec<usize> = (0..glances.len()).filter(|k| glances[*k].clipped > CLIPPED).collect();
    if !white.is_empty() {
        let text = format!("{} overexposed: over a quarter of it is white", is_or_are(&white, names));
        all.push(finding(Level::Note, text, "expose less, so that roots and belts keep their shades", &white));
    }
    all
}

/// Whether the camera stood still.
pub(super) fn standing(room: &Room, factor: usize, names: &[String], needs_belts: bool) -> Vec<Finding> {
    let level = if needs_belts { Level::Fault } else { Level::Note };
    if room.still < STILL {
        let text = format!("only {:.0} % of what is beside the tank stands still", 100.0 * room.still);
        let remedy = "the camera stands on a tripod while the table turns, and nothing else in the room changes";
        return vec![finding(level, text, remedy, &[])];
    }
    let Some(shifts) = &room.shifts else { return Vec::new() };
    // Half a pixel of the pictures is one of a photograph of 968 px width.
    let limit = 0.5 * MOVED_PX;
    let step = |k: &usize| (shifts[*k][0] - shifts[*k - 1][0]).hypot(shifts[*k][1] - shifts[*k - 1][1]);
    let moved: Vec<usize> = (1..shifts.len()).filter(|k| step(k) > limit).collect();
    let Some(most) = moved.iter().copied().max_by(|a, b| step(a).total_cmp(&step(b))) else { return Vec::new() };
    let text = if 3 * moved.len() > shifts.len() {
        format!("the camera moves all the time, by up to {:.1} px", factor as f64 * step(&most))
    } else {
        format!("the camera was moved before {}, by {:.1} px", named(&moved, names), factor as f64 * step(&most))
    };
    vec![finding(Level::Fault, text, "fasten tripod and camera, and take all photographs again from one place", &moved)]
}
