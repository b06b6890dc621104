//! From ridge points to roots.
//!
//! Link ([`super::link`]), take doubles away, bridge gaps ([`super::bridge`]), leave out specks, place
//! ([`super::hierarchy`]), prune spurs, give out numbers. Every change against the bare ridge is in the log.

use super::bridge::{BridgeParams, Workshop, bridge, cubic, drop_doubles};
use super::hierarchy::{Place, place};
use super::link::{LinkParams, link};
use super::repair::{Kind, Repair};
use super::ridge::{Field, RidgePoint};
use super::strand::{End, Knot, Strand};
use super::tie::TieParams;
use super::{Root, curve};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// How the tracing decides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TraceParams {
    /// Spacing of the centreline's points, mm, 0.1 to 5.
    pub step_mm: f64,
    /// Waves of the ridge shorter than this are noise, mm, 1 to 30; a few times the thickest lateral.
    pub smooth_mm: f64,
    /// Neighbouring ridge points.
    pub link: LinkParams,
    /// Pieces of one root.
    pub bridge: BridgeParams,
    /// Laterals on their parents.
    pub tie: TieParams,
    /// A piece that runs closer to a longer one than this is its double, in voxels, 0 to 5.
    pub double: f64,
    /// Shortest piece that hangs on nothing, mm.
    pub speck_mm: f64,
    /// Shortest lateral beyond its parent's surface, in radii of the parent, 0 to 20.
    pub spur_radii: f64,
}

impl Default for TraceParams {
    fn default() -> Self {
        Self {
            step_mm: 0.5,
            smooth_mm: 6.0,
            link: LinkParams::default(),
            bridge: BridgeParams::default(),
            tie: TieParams::default(),
            double: 1.5,
            speck_mm: 6.0,
            spur_radii: 3.0,
        }
    }
}

/// A root with what is known of its points beyond place and radius.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TracedRoot {
    /// The root.
    pub root: Root,
    /// Standard deviation of each radius, mm.
    pub radius_sd_mm: Vec<f64>,
    /// Photographs that each radius was measured in; 0 where it stands on the scale of the ridge alone.
    pub views: Vec<u32>,
    /// How well each point is supported, 0 to 1: its rootness against the median of the system's.
    pub confidence: Vec<f64>,
}

/// A root system and how it came about.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RootSystem {
    /// The roots; a parent stands before its laterals.
    pub roots: Vec<TracedRoot>,
    /// Every change against the bare ridge.
    pub repairs: Vec<Repair>,
}

impl RootSystem {
    /// The roots alone.
    pub fn plain(&self) -> Vec<Root> {
        self.roots.iter().map(|r| r.root.clone()).collect()
    }
}

/// Traces the roots.
///
/// # Errors
/// Where the field's shape is not its grid's, or a length of the parameters is not positive.
pub fn trace(points: &[RidgePoint], field: &Field<'_>, params: &TraceParams) -> Result<RootSystem> {
    if field.rootness.shape() != field.grid.shape {
        return Err(Error::failed(format!(
            "tracing: rootness of shape {:?} on a grid of shape {:?}",
            field.rootness.shape(),
            field.grid.shape
        )));
    }
    for (name, value) in [("trace.step_mm", params.step_mm), ("trace.smooth_mm", params.smooth_mm)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(Error::usage(format!("{name} is {value}")).help("give a positive length in mm"));
        }
    }
    let spacing = field.grid.spacing_mm;
    let strong: Vec<RidgePoint> = points.iter().filter(|p| p.strong).copied().collect();
    let workshop = Workshop {
        points: &strong,
        // Seen through a shorter borrow: an array view does not shorten by itself.
        field: Field { grid: field.grid, rootness: field.rootness.view() },
        step_mm: params.step_mm,
        wavelength_mm: params.smooth_mm,
        link_mm: params.link.reach * spacing,
    };
    let mut log = Vec::new();
    let strands: Vec<Strand> = link(&strong, spacing, &params.link)
        .into_iter()
        .filter(|chain| chain.len() > 2)
        .map(|chain| workshop.strand(chain))
        .filter(|s| s.knots.len() > 1)
        .collect();
    let strands = drop_doubles(strands, &workshop, params.double * spacing, &mut log);
    let strands = bridge(strands, &workshop, &params.bridge, &mut log);
    let strands = drop_doubles(strands, &workshop, params.double * spacing, &mut log);
    let (strands, places) = place(strands, &workshop, &params.tie, &mut log);
    let keep = prune(&strands, &places, params, &mut log);
    Ok(RootSystem { roots: number(&strands, &places, &keep, field, params), repairs: log })
}

/// Which strands stay: no specks, no spurs.
fn prune(strands: &[Strand], places: &[Option<Place>], params: &TraceParams, log: &mut Vec<Repair>) -> Vec<bool> {
    let mut keep = vec![true; strands.len()];
    let mut out = |s: usize, reason: String| {
        keep[s] = false;
        let strand = &strands[s];
        log.push(Repair::new(Kind::Pruned, &strand.at(strand.knots.len() / 2), strand.length_mm(), reason));
    };
    for (s, strand) in strands.iter().enumerate() {
        let length = strand.length_mm();
        match places[s] {
            None if length < params.speck_mm => {
                out(s, format!("hangs on nothing and is shorter than {} mm", params.speck_mm));
            }
            Some(Place { parent: Some((parent, knot)), base, tied: true, .. }) => {
                let radius = strands[parent].radius_mm(knot);
                let tip = strand.at(strand.end(base.other()));
                let beyond = (length.min(strands[parent].nearest(&tip).1) - radius).max(0.0);
                let carries = places.iter().flatten().any(|p| p.parent.is_some_and(|(o, _)| o == s));
                if beyond < params.spur_radii * radius && !carries {
                    out(
                        s,
                        format!(
                            "a spur: {beyond:.1} mm beyond its parent's surface, under {} radii of {radius:.2} mm",
                            params.spur_radii
                        ),
                    );
                }
            }
            _ => {}
        }
    }
    keep
}

/// Orients the strands, draws their ties and gives them numbers: by order, parents first, then from the
/// parent's base to its tip.
fn number(
    strands: &[Strand],
    places: &[Option<Place>],
    keep: &[bool],
    field: &Field<'_>,
    params: &TraceParams,
) -> Vec<TracedRoot> {
    let from_base = |s: usize, knot: usize| match places[s] {
        Some(Place { base: End::Last, .. }) => strands[s].knots.len() - 1 - knot,
        _ => knot,
    };
    let mut typical: Vec<f64> =
        (0..strands.len()).filter(|&s| keep[s]).flat_map(|s| strands[s].knots.iter().map(|k| k[3])).collect();
    typical.sort_by(f64::total_cmp);
    let typical = typical.get(typical.len() / 2).copied().unwrap_or(1.0).max(1e-12);
    let mut order: Vec<usize> = (0..strands.len()).filter(|&s| keep[s]).collect();
    let mut ids = vec![-1_i64; strands.len()];
    let mut roots = Vec::new();
    let depth = |s: usize| places[s].map_or(u32::MAX, |p| p.order);
    // Parents get their numbers before their laterals ask for them, order by order.
    order.sort_by_key(|&s| (depth(s), s));
    let mut from = 0;
    while from < order.len() {
        let rank = depth(order[from]);
        let to = from + order[from..].iter().take_while(|&&s| depth(s) == rank).count();
        let ids_now = ids.clone();
        order[from..to].sort_by_key(|&s| {
            let parent = places[s].and_then(|p| p.parent);
            (parent.map_or(-1, |(p, _)| ids_now[p]), parent.map_or(0, |(p, k)| from_base(p, k)), s)
        });
        for &s in &order[from..to] {
            ids[s] = roots.len() as i64;
            let parent = places[s].and_then(|p| p.parent).map_or(-1, |(p, _)| ids[p]);
            let knots = drawn(s, strands, places, field, params);
            roots.push(TracedRoot {
                root: Root {
                    id: ids[s],
                    parent,
                    order: places[s].map_or(1, |p| p.order),
                    points_mm: knots.iter().map(|k| [k[0], k[1], k[2]]).collect(),
                    radii_mm: knots.iter().map(|k| std::f64::consts::SQRT_2 * k[4]).collect(),
                },
                // The response is flat about its best scale: half the radius is what it leaves open.
                radius_sd_mm: knots.iter().map(|k| 0.5 * std::f64::consts::SQRT_2 * k[4]).collect(),
                views: vec![0; knots.len()],
                confidence: knots.iter().map(|k| (k[3] / typical).clamp(0.0, 1.0)).collect(),
            });
        }
        from = to;
    }
    roots
}

/// The knots from base to tip, led on to the parent's centreline where the tie is visible.
fn drawn(s: usize, strands: &[Strand], places: &[Option<Place>], field: &Field<'_>, params: &TraceParams) -> Vec<Knot> {
    let mut knots = strands[s].knots.clone();
    let Some(place) = places[s] else { return knots };
    if place.base == End::Last {
        knots.reverse();
    }
    if let (Some((parent, knot)), true) = (place.parent, place.tied) {
        let (from, to) = (strands[parent].at(knot), curve::position(&knots[0]));
        let gap = (to - from).norm();
        let inward = -strands[s].outward(place.base, params.tie.baseline_mm);
        let n = (gap / params.step_mm).round().max(1.0) as usize;
        let sigma = knots[0][4];
        let lead = (0..n).map(|k| {
            let straight = to - from;
            let p = cubic(&from, &straight, &to, &(inward * gap), k as f64 / n as f64);
            let rootness = field.at(&p);
            [p.x, p.y, p.z, if rootness.is_finite() { rootness } else { 0.0 }, sigma]
        });
        knots = lead.chain(knots.iter().copied()).collect();
    }
    knots
}
