//! How much a line stands out in the photographs of a day, past the roots that are known there.

use super::OFF_MM;
use crate::optics::Vec3;
use crate::roots::explain::Witness;
use crate::roots::explain::beads::Chain;
use crate::roots::explain::cover::Cover;
use crate::roots::explain::look::{Look, Looking, looks, read};
use crate::roots::explain::tubes::Tubes;
use crate::roots::{Root, TracedRoot};
use nalgebra::Vector2;
use ndarray::Array2;
use rayon::prelude::*;

/// A known root that gives a pixel more than this share hides what else there is.
const HIDDEN: f32 = 0.1;
/// How far beside a root's blurred edge its surroundings are looked at, px.
const BESIDE_PX: f32 = 1.5;
/// Fewest photographs that tell of a place.
const FEWEST: usize = 3;
/// Shortest stretch that is told from chance, mm.
const SHORTEST_MM: f64 = 3.0;
/// A photograph shows the root at a place where its contrast there is this share of the mean at least.
const SHOWS: f32 = 0.5;

/// What a line was found to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Mean contrast times the root of the number of places.
    pub stands_out: f64,
    /// Mean contrast, share of root on the line less that beside it.
    pub contrast: f64,
    /// Length from the base on, mm.
    pub length_mm: f64,
    /// Share of the photographs' looks at it that show it.
    pub shown: f64,
}

/// The photographs of a day, and where known roots hide what else there is.
pub struct Photographs<'a>(Vec<Photograph<'a>>);

struct Photograph<'a> {
    witness: Witness<'a>,
    cover: Cover,
    /// (row, column).
    hidden: Array2<bool>,
}

impl<'a> Photographs<'a> {
    /// The photographs with the known roots drawn into them.
    pub fn new(witnesses: &[Witness<'a>], known: &[TracedRoot]) -> Self {
        let chain = Chain::new(known.iter().map(|r| &r.root.points_mm[..]));
        // They may lie as far off in a photograph as those that are looked for, and their blur is no other root.
        let radius_mm: Vec<f32> =
            radii(&chain, known.iter().map(|r| &r.root)).into_iter().map(|r| r + OFF_MM as f32).collect();
        let one = |witness: &Witness<'a>| {
            let cover = Cover::new(witness.spread_px);
            let looking = Looking { witness: *witness, cover: cover.clone(), looks: looks(witness, &chain) };
            let tubes = Tubes::new(&looking, &chain, &radius_mm, |_| true);
            let (height, width, _) = witness.evidence.dim();
            let is_hidden = |(v, u): (usize, usize)| {
                let at = Vector2::new(u as f32, v as f32);
                tubes.others(at, u32::MAX).any(|(_, share)| share > HIDDEN)
            };
            Photograph { witness: *witness, cover, hidden: Array2::from_shape_fn((height, width), is_hidden) }
        };
        Self(witnesses.par_iter().map(one).collect())
    }

    /// The stretch of a line from its base on that stands out most, `least_mm` long at least; none where too little of it is seen.
    pub fn along(&self, line: &Root, least_mm: f64) -> Option<Found> {
        let chain = Chain::new(std::iter::once(&line.points_mm[..]));
        let radius_mm = radii(&chain, std::iter::once(line));
        let told: Vec<Vec<Option<(f32, f32)>>> =
            self.0.par_iter().map(|photograph| photograph.told(&chain, &radius_mm)).collect();
        let mean = |b: usize| {
            let words: Vec<(f32, f32)> = told.iter().filter_map(|of| of[b]).collect();
            let says: f32 = words.iter().map(|w| w.1).sum();
            (words.len() >= FEWEST && says > 0.0)
                .then(|| f64::from(words.iter().map(|w| w.0 * w.1).sum::<f32>() / says))
        };
        let means: Vec<Option<f64>> = (0..chain.len()).map(mean).collect();
        let arcs: Vec<f64> = chain
            .places
            .iter()
            .scan((0.0, chain.places[0]), |(arc, before), p| {
                *arc += (p - *before).norm();
                *before = *p;
                Some(*arc)
            })
            .collect();
        let whole = *arcs.last()?;
        let least_mm = least_mm.max(SHORTEST_MM).min(whole);
        let (mut sum, mut count, mut found): (f64, usize, Option<(Found, usize)>) = (0.0, 0, None);
        for (b, mean) in means.iter().enumerate() {
            let Some(mean) = mean else { continue };
            sum += mean;
            count += 1;
            // Half of what is asked of has to be seen.
            if arcs[b] + 1e-9 < least_mm || 2 * count < b + 1 {
                continue;
            }
            let stands_out = sum / (count as f64).sqrt();
            if found.is_none_or(|(f, _)| stands_out > f.stands_out) {
                let contrast = sum / count as f64;
                found = Some((Found { stands_out, contrast, length_mm: arcs[b], shown: 0.0 }, b));
            }
        }
        let (found, last) = found.filter(|(f, _)| f.stands_out > 0.0)?;
        let words = told.iter().flat_map(|of| of[..=last].iter().flatten());
        let (mut shows, mut all) = (0, 0);
        words.for_each(|w| {
            shows += usize::from(w.0 >= SHOWS * found.contrast as f32);
            all += 1;
        });
        Some(Found { shown: f64::from(shows as u32) / f64::from(all.max(1)), ..found })
    }
}

impl Photograph<'_> {
    /// What a photograph tells of each bead of a line: contrast, and how far it counts.
    fn told(&self, chain: &Chain, radius_mm: &[f32]) -> Vec<Option<(f32, f32)>> {
        let free = |at: Vector2<f32>| self.hidden.get([at.y.round() as usize, at.x.round() as usize]) == Some(&false);
        let one = |(look, radius_mm): (&Option<Look>, &f32)| {
            let look = look.filter(|look| free(look.pixel))?;
            let off = self.cover.reach_px(radius_mm * look.px_per_mm) + BESIDE_PX;
            let across = Vector2::new(-look.along.y, look.along.x) * off;
            let sides = [look.pixel - across, look.pixel + across].into_iter().filter(|at| free(*at));
            let beside: Vec<f32> = sides.filter_map(|at| Some(read(&self.witness, at)?.0)).collect();
            let mean = beside.iter().sum::<f32>() / beside.len() as f32;
            (!beside.is_empty()).then_some((look.share - mean, look.say))
        };
        looks(&self.witness, chain).iter().zip(radius_mm).map(one).collect()
    }
}

/// Of each bead the radius of its root there, mm.
fn radii<'r>(chain: &Chain, roots: impl Iterator<Item = &'r Root>) -> Vec<f32> {
    let mut all = Vec::with_capacity(chain.len());
    for (root, beads) in roots.zip(&chain.pieces) {
        let mut at = 0;
        for b in beads.clone() {
            let far = |k: usize| (Vec3::from(root.points_mm[k]) - chain.places[b]).norm_squared();
            // Beads go along the line: the nearest point is never before the last bead's.
            while at + 1 < root.points_mm.len() && far(at + 1) <= far(at) {
                at += 1;
            }
            all.push(root.radii_mm[at] as f32);
        }
    }
    all
}
