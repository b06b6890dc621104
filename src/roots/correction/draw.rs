//! Adds a root through places, or through places that photographs show, along the evidence.

use super::tree::Tree;
use super::{Done, Sighting, Spot, Tie, World};
use crate::error::Result;
use crate::optics::{Mat3, Vec3, WaterRay};
use crate::roots::{Root, TracedRoot, curve};

/// An added root along which one runs already over more than this share is none.
const ALREADY: f64 = 0.5;

/// Adds a root.
///
/// # Errors
/// Where a sighting names a photograph that is not there.
pub(super) fn add(
    tree: &mut Tree,
    through: &[Spot],
    diameter_mm: Option<f64>,
    tie: &Tie,
    world: &World<'_>,
) -> Result<Done> {
    let within = world.params.within_mm;
    let mut places = Vec::with_capacity(through.len());
    let mut widest_mm = 0.0_f64;
    for (n, spot) in through.iter().enumerate() {
        let at = match spot {
            Spot::Place(at) => *at,
            Spot::Seen(sightings) => {
                let rays = rays(sightings, world)?;
                match meeting(&rays) {
                    Some((at, apart_mm)) if apart_mm <= within => {
                        widest_mm = widest_mm.max(apart_mm);
                        at
                    }
                    Some((at, apart_mm)) => {
                        let why = format!("the rays of its place {} pass {apart_mm:.1} mm beside each other", n + 1);
                        return Ok(Err((Some(at), why)));
                    }
                    None => {
                        let why = format!("fewer than two rays of its place {} go through the water", n + 1);
                        return Ok(Err((None, why)));
                    }
                }
            }
        };
        places.push([at.x, at.y, at.z]);
    }
    let start = Vec3::from(places[0]);
    let line = curve::resample(&places, tree.step_mm);
    if line.len() < 2 {
        return Ok(Err((Some(start), "its places are one".into())));
    }
    let snapped = world.evidence.as_ref().filter(|_| world.params.snap_mm > 0.0);
    let snapped = snapped.map(|evidence| evidence.snapped(&line, tree.step_mm, world.params.snap_mm));
    let (line, on_evidence) = snapped.map_or((line, None), |(line, share)| (line, Some(share)));
    let taken = line.iter().filter(|p| tree.on_any(&Vec3::from(**p), within)).count();
    if taken as f64 > ALREADY * line.len() as f64 {
        return Ok(Err((Some(start), format!("a root already runs along {} of its {} points", taken, line.len()))));
    }
    let onto = match tie {
        Tie::Free => Ok(None),
        Tie::Parent(at) => tree.on(at, within).map(Some),
        Tie::Continues(at) => tree.end_at(at, within).map(|end| Some(end.0)),
    };
    let onto = match onto {
        Ok(onto) => onto.map(|spot| (tree.roots[spot.root].root.id, tree.roots[spot.root].root.order)),
        Err(why) => return Ok(Err(why)),
    };
    let order = match (tie, onto) {
        (Tie::Parent(_), Some((_, order))) => order + 1,
        (_, onto) => onto.map_or(1, |(_, order)| order),
    };
    let radius_mm = diameter_mm.map_or_else(|| tree.typical_radius_mm(order), |d| 0.5 * d);
    let (id, n) = (tree.fresh_id(), line.len());
    tree.roots.push(TracedRoot {
        root: Root { id, parent: -1, order, points_mm: line, radii_mm: vec![radius_mm; n] },
        radius_sd_mm: vec![0.0; n],
        views: vec![0; n],
        confidence: vec![0.0; n],
    });
    let own = tree.roots.len() - 1;
    let mm = tree.length_mm(own);
    let hung = match (tie, onto.and_then(|(id, _)| tree.index(id))) {
        (Tie::Parent(place), Some(onto)) => tree.adopt(own, onto, place).map_err(|why| (Some(start), why)),
        (Tie::Continues(end), Some(_)) => {
            let first = Vec3::from(tree.roots[own].root.points_mm[0]);
            tree.join(end, &first, within).map(|_| ())
        }
        _ => Ok(()),
    };
    if let Err(why) = hung {
        tree.roots.pop();
        return Ok(Err(why));
    }
    let mut found = format!("{mm:.1} mm added");
    if let Some(share) = on_evidence {
        found.push_str(&format!(", {:.0} % of it along evidence", 100.0 * share));
    }
    if widest_mm > 0.0 {
        found.push_str(&format!("; rays meet within {widest_mm:.2} mm"));
    }
    Ok(Ok((start, found)))
}

impl Tree {
    /// Whether any root runs through a place.
    fn on_any(&self, at: &Vec3, within_mm: f64) -> bool {
        self.roots.iter().any(|r| super::nearest::nearest(&r.root.points_mm, at).1 <= within_mm)
    }

    /// Median radius of the roots of an order, or of all, mm.
    fn typical_radius_mm(&self, order: u32) -> f64 {
        let of = |is: &dyn Fn(u32) -> bool| {
            let roots = self.roots.iter().filter(|r| is(r.root.order));
            let mut radii: Vec<f64> = roots.flat_map(|r| r.root.radii_mm.iter().copied()).collect();
            radii.sort_by(f64::total_cmp);
            radii.get(radii.len() / 2).copied()
        };
        of(&|o| o == order).or_else(|| of(&|_| true)).unwrap_or(self.step_mm)
    }
}

fn rays(sightings: &[Sighting], world: &World<'_>) -> Result<Vec<WaterRay>> {
    let rays = sightings.iter().map(|s| (world.ray)(s)).collect::<Result<Vec<_>>>()?;
    Ok(rays.into_iter().flatten().collect())
}

/// The point nearest to all rays in the least squares sense, and how far the farthest ray passes it, mm.
fn meeting(rays: &[WaterRay]) -> Option<(Vec3, f64)> {
    let (mut a, mut b) = (Mat3::zeros(), Vec3::zeros());
    for ray in rays {
        let across = Mat3::identity() - ray.v2 * ray.v2.transpose();
        a += across;
        b += across * ray.p2_mm;
    }
    let at = (rays.len() > 1).then(|| a.lu().solve(&b)).flatten()?;
    let miss = |ray: &WaterRay| (at - ray.p2_mm).cross(&ray.v2).norm();
    at.iter().all(|x| x.is_finite()).then(|| (at, rays.iter().map(miss).fold(0.0, f64::max)))
}
