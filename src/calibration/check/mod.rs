//! Whether a capture will do, told in seconds from the photographs alone, while they can still be taken again.
//!
//! Pictures of about 484 px width ([`glance`]) tell where the printed belts are ([`super::masks`]), how the table turned
//! ([`ring`]), whether camera and light stood still ([`still`]) and how sharp each photograph is. Lengths in px are those of the
//! photographs.

pub mod glance;
pub mod ring;
pub mod still;
mod words;

pub use glance::Glance;
pub use words::{Finding, Level};

use super::masks::{self, MaskParams};
use crate::error::{Error, Result};
use ndarray::Array2;
use ring::{Belts, Ring};
use still::Room;

/// What a photograph shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Standard deviation of its blur, px of a photograph of 968 px width; 0 to 3.
    pub blur_px: f64,
    /// Gray values of the room over those of the other photographs.
    pub gain: f64,
    /// (right, down) by which the room is moved, px of the photograph; `None` where it is too plain to tell.
    pub shift_px: Option<[f64; 2]>,
    /// Turn from the photograph before, degrees; `None` where they share no print.
    pub turn_deg: Option<f64>,
}

/// What a check found.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked {
    /// What a person should know, most serious first.
    pub findings: Vec<Finding>,
    /// What each photograph shows, in their order.
    pub looks: Vec<Look>,
}

impl Checked {
    /// Whether the capture will do: no finding is a fault.
    pub fn will_do(&self) -> bool {
        self.findings.iter().all(|finding| finding.level == Level::Note)
    }
}

/// Checks photographs in capture order; `needs_belts` where cameras are to be found in them.
///
/// # Errors
/// Where photographs differ in size.
pub fn check(glances: &[Glance], names: &[String], needs_belts: bool) -> Result<Checked> {
    let mut findings = words::number(glances.len());
    let Some(first) = glances.first() else { return Ok(Checked { findings, looks: Vec::new() }) };
    let alike = glances.iter().all(|g| g.gray.dim() == first.gray.dim() && g.factor == first.factor);
    if !alike || first.gray.is_empty() {
        let odd = glances.iter().position(|g| g.gray.dim() != first.gray.dim()).unwrap_or(0);
        return Err(Error::failed(format!("`{}` and `{}` differ in size", names[0], names[odd]))
            .help("all photographs of a study come from one camera at one size; do not crop, scale or turn them"));
    }
    let pictures: Vec<&Array2<f32>> = glances.iter().map(|g| &g.gray).collect();
    let mask = masks::belts(still::deviation(&pictures).view(), &MaskParams::default()).ok();
    let belts = mask.as_ref().and_then(Belts::of);
    let room = still::room(&pictures, belts.as_ref());
    let ring = belts.as_ref().map(|belts| ring::ring(&pictures, belts, room.shifts.as_deref()));
    let whole = Array2::from_elem(first.gray.dim(), true);
    let blurs: Vec<f64> = glances.iter().map(|g| blur_px(g, mask.as_ref().unwrap_or(&whole))).collect();
    findings.extend(words::twins(glances, names));
    match &ring {
        Some(ring) => findings.extend(words::around(ring, glances, names, needs_belts)),
        None => findings.push(words::no_belts(needs_belts)),
    }
    findings.extend(words::sharpness(&blurs, names));
    findings.extend(words::light(&room, glances, names));
    findings.extend(words::standing(&room, first.factor, names, needs_belts));
    findings.sort_by_key(|finding| finding.level);
    let looks = (0..glances.len()).map(|k| look(k, &room, ring.as_ref(), &blurs, first.factor)).collect();
    Ok(Checked { findings, looks })
}

fn look(k: usize, room: &Room, ring: Option<&Ring>, blurs: &[f64], factor: usize) -> Look {
    let before = |ring: &Ring| {
        let at = ring.order.iter().position(|view| *view == k)?;
        ring.steps_deg[(at + ring.order.len() - 1) % ring.order.len()]
    };
    Look {
        blur_px: blurs[k],
        gain: room.gains[k],
        shift_px: room.shifts.as_ref().map(|shifts| shifts[k].map(|s| s * factor as f64)),
        turn_deg: ring.and_then(before),
    }
}

/// Blur by the ratio of slopes: 0.25 at last, 0.7 without any, as (ratio - 0.25) falls with the square of blur. The
/// constants are those of random prints of some px per cell, photographed through water tanks: 0.51 at 0.7 px, 0.44 at 1,
/// 0.37 at 1.5, 0.32 at 2.
fn blur_px(glance: &Glance, mask: &Array2<bool>) -> f64 {
    let (mut fine, mut coarse) = (0.0, 1e-9);
    for ((mask, f), c) in mask.iter().zip(&glance.fine).zip(&glance.coarse) {
        if *mask {
            fine += f64::from(*f);
            coarse += f64::from(*c);
        }
    }
    const TABLE: [[f64; 2]; 8] =
        [[0.29, 3.0], [0.323, 2.0], [0.365, 1.5], [0.44, 1.0], [0.512, 0.7], [0.57, 0.5], [0.62, 0.3], [0.68, 0.0]];
    let ratio = (fine / coarse).clamp(TABLE[0][0], TABLE[7][0]);
    let at = TABLE.partition_point(|[r, _]| *r <= ratio).clamp(1, 7);
    let ([r0, b0], [r1, b1]) = (TABLE[at - 1], TABLE[at]);
    b0 + (b1 - b0) * (ratio - r0) / (r1 - r0)
}
