//! From ridge points to pieces of roots.
//!
//! Link ([`super::link`]), take doubles away, follow loose ends ([`super::extend`]), pair the ways through crossings
//! ([`super::crossing`]), bridge gaps ([`super::bridge`]), take doubles away again, part what arches over the crown
//! ([`super::crown`]); then note how the pieces may hang together: ties from ends onto other pieces ([`super::tie`]), and ends
//! that run out of sight. Which of these hold is decided once thicknesses are known ([`super::hierarchy`]). Every change against
//! the bare ridge is in the log.

use super::bridge::{BridgeParams, Workshop, bridge, drop_doubles};
use super::crossing::{CrossingParams, resolve};
use super::crown;
use super::extend::{ExtendParams, extend};
use super::link::{LinkParams, link};
use super::repair::Repair;
use super::ridge::{Field, RidgePoint};
use super::strand::{End, Strand};
use super::system::TracedRoot;
use super::tie::{Tie, TieParams, ties};
use super::{Root, curve};
use crate::error::{Error, Result};
use crate::optics::Vec3;
use crate::volume::hysteresis::{Hysteresis, Unit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the tracing decides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TraceParams {
    /// Ridges above it, in multiples of the volume's own level, may be traced: weaker ones than count as root voxels
    /// (`extract.low`), since the photographs then judge each traced piece (`hierarchy.shown`). Where diameters are not
    /// measured nothing judges: give those of `[extract]`.
    #[schemars(range(min = 0.0))]
    pub low: f32,
    /// Ridges above it are traced, with all that is linked to them above `low`.
    #[schemars(range(min = 0.0))]
    pub high: f32,
    /// Ridges whose bounding box has a shorter diagonal are not traced, mm.
    #[schemars(range(min = 0.0))]
    pub min_length_mm: f32,
    /// Spacing of the centreline's points, mm, 0.1 to 5.
    #[schemars(range(min = 0.1, max = 5.0))]
    pub step_mm: f64,
    /// Waves of the ridge shorter than this are noise, mm, 1 to 30; a few times the thickest lateral.
    #[schemars(range(min = 1.0, max = 30.0))]
    pub smooth_mm: f64,
    /// Neighbouring ridge points.
    pub link: LinkParams,
    /// Loose ends.
    pub extend: ExtendParams,
    /// Ways through crossings.
    pub crossing: CrossingParams,
    /// Pieces of one root.
    pub bridge: BridgeParams,
    /// Laterals on their parents.
    pub tie: TieParams,
    /// A piece that runs closer to a longer one than this is its double, in voxels, 0 to 5.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub double: f64,
}

impl Default for TraceParams {
    fn default() -> Self {
        Self {
            low: 0.35,
            high: 0.5,
            min_length_mm: 3.0,
            step_mm: 0.5,
            smooth_mm: 6.0,
            link: LinkParams::default(),
            extend: ExtendParams::default(),
            crossing: CrossingParams::default(),
            bridge: BridgeParams::default(),
            tie: TieParams::default(),
            double: 1.5,
        }
    }
}

impl TraceParams {
    /// Which ridges are traced.
    pub fn hysteresis(&self) -> Hysteresis {
        Hysteresis { low: self.low, high: self.high, unit: Unit::Level, min_length_mm: self.min_length_mm }
    }
}

/// An end that runs out of sight upwards or downwards.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OutOfSight {
    /// Index of the piece.
    pub piece: usize,
    /// Its end.
    pub end: End,
    /// Straight way to the hidden zone, mm.
    pub way_mm: f64,
    /// Whether that is below what is seen.
    pub below: bool,
}

/// Looks of photographs at the measured points of a root.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Looks {
    /// Those that nothing hinders: through a regular ray, not end on, and past all other roots.
    pub unhindered: u32,
    /// Those of them that show a root.
    pub showing: u32,
}

impl Looks {
    /// The share of the unhindered looks that show a root; none where there was no such look.
    pub fn share(&self) -> Option<f64> {
        (self.unhindered > 0).then(|| f64::from(self.showing) / f64::from(self.unhindered))
    }
}

impl std::iter::Sum for Looks {
    fn sum<I: Iterator<Item = Self>>(looks: I) -> Self {
        looks.fold(Self::default(), |a, b| Self {
            unhindered: a.unhindered + b.unhindered,
            showing: a.showing + b.showing,
        })
    }
}

/// Pieces of roots and how they may hang together.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Pieces {
    /// Spacing of the centrelines' points, mm.
    pub step_mm: f64,
    /// Waves shorter than this are noise, mm.
    pub smooth_mm: f64,
    /// Longest link between neighbouring ridge points, mm: what is closer touches.
    pub link_mm: f64,
    /// Whether the photographs need each of them ([`super::explain`]).
    pub explained: bool,
    /// What the photographs say of each piece; empty where none was asked.
    pub looks: Vec<Looks>,
    /// The photographs' point spread, px, where diameters were measured in them.
    pub spread_px: Option<f64>,
    /// The mean rootness of each piece.
    pub strengths: Vec<f64>,
    /// The pieces; numbers, parents and orders are not given yet.
    pub pieces: Vec<TracedRoot>,
    /// Where ends may spring from other pieces.
    pub ties: Vec<Tie>,
    /// Ends that run out of sight.
    pub out_of_sight: Vec<OutOfSight>,
    /// Every change against the bare ridge.
    pub repairs: Vec<Repair>,
}

/// Traces the pieces. Points that are not strong are those along which loose ends may be followed.
///
/// # Errors
/// Where the field's shape is not its grid's, or a length of the parameters is not positive.
pub fn trace(points: &[RidgePoint], field: &Field<'_>, params: &TraceParams) -> Result<Pieces> {
    if field.rootness.shape() != field.grid.shape {
        return Err(Error::failed(format!(
            "tracing: rootness of shape {:?} on a grid of shape {:?}",
            field.rootness.shape(),
            field.grid.shape
        )));
    }
    for (name, value) in [
        ("trace.step_mm", params.step_mm),
        ("trace.smooth_mm", params.smooth_mm),
        ("trace.crossing.bend_deg", params.crossing.bend_deg),
        ("trace.crossing.alone", params.crossing.alone),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return Err(Error::usage(format!("{name} is {value}")).help("give a positive number"));
        }
    }
    let spacing = field.grid.spacing_mm;
    // Strong points first: what is linked are numbers below `weak`.
    let mut all: Vec<RidgePoint> = points.iter().filter(|p| p.strong).copied().collect();
    let weak = all.len();
    all.extend(points.iter().filter(|p| !p.strong));
    let workshop = Workshop {
        points: &all,
        // Seen through a shorter borrow: an array view does not shorten by itself.
        field: Field { grid: field.grid, rootness: field.rootness.view() },
        step_mm: params.step_mm,
        wavelength_mm: params.smooth_mm,
        link_mm: params.link.reach * spacing,
    };
    let mut repairs = Vec::new();
    let strands: Vec<Strand> = link(&all[..weak], spacing, &params.link)
        .into_iter()
        .filter(|chain| chain.len() > 2)
        .map(|chain| workshop.strand(chain))
        .filter(|s| s.knots.len() > 1)
        .collect();
    let strands = drop_doubles(strands, &workshop, params.double * spacing, &mut repairs);
    let strands = extend(strands, weak, &workshop, &params.link, &params.extend, &mut repairs);
    let strands = resolve(strands, &workshop, &params.crossing, &mut repairs);
    let strands = bridge(strands, &workshop, &params.bridge, &mut repairs);
    let strands = drop_doubles(strands, &workshop, params.double * spacing, &mut repairs);
    let strands = crown::part(strands, params.smooth_mm, &workshop, &mut repairs);
    let out_of_sight = |(piece, strand): (usize, &Strand)| runs_out_of_sight(piece, strand, &workshop, &params.tie);
    Ok(Pieces {
        step_mm: params.step_mm,
        smooth_mm: params.smooth_mm,
        link_mm: workshop.link_mm,
        explained: false,
        looks: Vec::new(),
        spread_px: None,
        strengths: strands.iter().map(|s| s.mean(3)).collect(),
        pieces: pieces(&strands),
        ties: ties(&strands, &workshop, &params.tie),
        out_of_sight: strands.iter().enumerate().flat_map(out_of_sight).collect(),
        repairs,
    })
}

/// The strands as pieces with the radii of their scales.
fn pieces(strands: &[Strand]) -> Vec<TracedRoot> {
    let mut typical: Vec<f64> = strands.iter().flat_map(|s| s.knots.iter().map(|k| k[3])).collect();
    typical.sort_by(f64::total_cmp);
    let typical = typical.get(typical.len() / 2).copied().unwrap_or(1.0).max(1e-12);
    let piece = |(n, strand): (usize, &Strand)| {
        let radii_mm: Vec<f64> = (0..strand.knots.len()).map(|k| strand.radius_mm(k)).collect();
        TracedRoot {
            // The response is flat about its best scale: half the radius is what it leaves open.
            radius_sd_mm: radii_mm.iter().map(|r| 0.5 * r).collect(),
            views: vec![0; radii_mm.len()],
            confidence: strand.knots.iter().map(|k| (k[3] / typical).clamp(0.0, 1.0)).collect(),
            root: Root {
                id: n as i64,
                parent: -1,
                order: 0,
                points_mm: strand.knots.iter().map(|k| curve::position(k).into()).collect(),
                radii_mm,
            },
        }
    };
    strands.iter().enumerate().map(piece).collect()
}

/// The ends that leave the seen water upwards or downwards.
fn runs_out_of_sight(piece: usize, strand: &Strand, workshop: &Workshop<'_>, params: &TieParams) -> Vec<OutOfSight> {
    let field = workshop.field;
    let step = 0.5 * field.grid.spacing_mm;
    let (nz, ny, nx) = field.rootness.dim();
    let low = field.grid.point_mm(0.0, 0.0, 0.0);
    let high = field.grid.point_mm(nz as f64 - 1.0, ny as f64 - 1.0, nx as f64 - 1.0);
    let middle = 0.5 * (low + high);
    // Near the wall a root leaves the seen water sideways: that says nothing of the crown.
    let reach = 0.5 * (high.x - low.x) - params.baseline_mm;
    let mut found = Vec::new();
    for end in End::BOTH {
        let from = strand.at(strand.end(end));
        let outward = strand.outward(end, params.baseline_mm);
        let below = from.z > middle.z;
        let leaves =
            if below { outward.z >= -0.3 } else { outward.z <= 0.3 && strand.at(strand.end(end.other())).z >= from.z };
        if !leaves {
            continue;
        }
        for k in 0..=(params.gap_mm / step) as usize {
            let way = k as f64 * step;
            let p: Vec3 = from + outward * way;
            if (p.x - middle.x).hypot(p.y - middle.y) > reach {
                break;
            }
            if field.at(&p).is_nan() {
                found.push(OutOfSight { piece, end, way_mm: way, below });
                break;
            }
        }
    }
    found
}
