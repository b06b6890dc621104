//! Finds the root that a place means, or says why it cannot be told.

use super::nearest::nearest;
use super::tree::Tree;
use crate::optics::Vec3;
use crate::roots::strand::End;

/// Another root counts as about as near up to this factor, and within this distance, mm.
const AS_NEAR: f64 = 2.0;
const AS_NEAR_MM: f64 = 0.1;

/// A point of a root near a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Place of the root in the list.
    pub root: usize,
    /// Number of its point.
    pub point: usize,
    /// Distance from the place to the root's line, mm.
    pub distance_mm: f64,
}

type Found<T> = std::result::Result<T, (Option<Vec3>, String)>;

impl Tree {
    /// The root that runs through a place.
    ///
    /// # Errors
    /// Where none does, or two are about as near.
    pub fn on(&self, at: &Vec3, within_mm: f64) -> Found<Spot> {
        self.on_other(at, within_mm, None)
    }

    /// The root through a place that is not `but`.
    ///
    /// # Errors
    /// As [`Tree::on`].
    pub fn on_other(&self, at: &Vec3, within_mm: f64, but: Option<usize>) -> Found<Spot> {
        let spots = self.roots.iter().enumerate().filter(|&(n, _)| Some(n) != but).map(|(root, r)| {
            let (point, distance_mm) = nearest(&r.root.points_mm, at);
            Spot { root, point, distance_mm }
        });
        let near = pick(spots.collect(), at, within_mm, "root")?;
        match near[..] {
            [only] => Ok(only),
            _ => Err((
                Some(*at),
                format!(
                    "two roots are {:.2} and {:.2} mm from ({:.1}, {:.1}, {:.1}); name a place where the root runs alone",
                    near[0].distance_mm, near[1].distance_mm, at.x, at.y, at.z
                ),
            )),
        }
    }

    /// The end of a root at a place, and which it is. Of ends that are about as near, the one that alone hangs on no other root.
    ///
    /// # Errors
    /// As [`Tree::on`].
    pub fn end_at(&self, at: &Vec3, within_mm: f64) -> Found<(Spot, End)> {
        let mut ends = Vec::new();
        for (root, r) in self.roots.iter().enumerate() {
            for point in [0, r.root.points_mm.len() - 1] {
                ends.push(Spot { root, point, distance_mm: (Vec3::from(r.root.points_mm[point]) - at).norm() });
            }
        }
        let near = pick(ends, at, within_mm, "end of a root")?;
        let free: Vec<Spot> =
            near.iter().copied().filter(|spot| spot.point > 0 || self.roots[spot.root].root.parent < 0).collect();
        let spot = match (&near[..], &free[..]) {
            ([only], _) | (_, [only]) => *only,
            _ => {
                let text = format!(
                    "two ends of roots are {:.2} and {:.2} mm from ({:.1}, {:.1}, {:.1})",
                    near[0].distance_mm, near[1].distance_mm, at.x, at.y, at.z
                );
                return Err((Some(*at), text));
            }
        };
        Ok((spot, if spot.point == 0 { End::First } else { End::Last }))
    }

    /// A root in words.
    pub fn told(&self, spot: &Spot) -> String {
        let root = &self.roots[spot.root].root;
        format!(
            "root of order {}, {:.1} mm long, {:.2} mm from the place",
            root.order,
            self.length_mm(spot.root),
            spot.distance_mm
        )
    }
}

/// The nearest, and those that are about as near.
fn pick(mut all: Vec<Spot>, at: &Vec3, within_mm: f64, what: &str) -> Found<Vec<Spot>> {
    all.sort_by(|a, b| a.distance_mm.total_cmp(&b.distance_mm));
    let near = all.first().copied().filter(|spot| spot.distance_mm <= within_mm);
    let Some(spot) = near else {
        let text = match all.first() {
            Some(spot) => format!(
                "no {what} within {within_mm} mm of ({:.1}, {:.1}, {:.1}); the nearest is {:.1} mm away",
                at.x, at.y, at.z, spot.distance_mm
            ),
            None => "there is no root at all".to_owned(),
        };
        return Err((Some(*at), text));
    };
    all.retain(|other| other.distance_mm <= (AS_NEAR * spot.distance_mm).max(AS_NEAR_MM) || other == &spot);
    Ok(all)
}
