//! Convex hulls in the plane and in space, the smallest circle.

use crate::optics::Vec3;

/// Corners of the planar hull, counter-clockwise, collinear ones left out (Andrew's chain).
pub fn planar(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted: Vec<[f64; 2]> = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut hull: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while hull.len() >= 2 && turn(hull[hull.len() - 2], hull[hull.len() - 1], p) <= 0.0 {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
        hull
    };
    let mut hull = chain(&mut sorted.iter().copied());
    hull.extend(chain(&mut sorted.iter().rev().copied()));
    hull
}

/// Twice the signed area of a triangle.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Area of a convex polygon.
pub fn area(hull: &[[f64; 2]]) -> f64 {
    (2..hull.len()).map(|k| 0.5 * turn(hull[0], hull[k - 1], hull[k])).sum()
}

/// Smallest distance of two parallel lines that hold a convex polygon between them.
pub fn least_width(hull: &[[f64; 2]]) -> f64 {
    let n = hull.len();
    if n < 3 {
        return 0.0;
    }
    let width = |k: usize| {
        let (a, b) = (hull[k], hull[(k + 1) % n]);
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        hull.iter().map(|p| turn(a, b, *p) / length).fold(0.0, f64::max)
    };
    (0..n).map(width).fold(f64::INFINITY, f64::min)
}

/// Centre and radius of the smallest circle about all points (incremental; meant for a hull's few corners).
pub fn circle(points: &[[f64; 2]]) -> ([f64; 2], f64) {
    let Some(&first) = points.first() else { return ([0.0; 2], 0.0) };
    let outside = |c: &([f64; 2], f64), p: [f64; 2]| (p[0] - c.0[0]).hypot(p[1] - c.0[1]) > c.1 * (1.0 + 1e-12) + 1e-12;
    let two =
        |a: [f64; 2], b: [f64; 2]| ([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])], 0.5 * (a[0] - b[0]).hypot(a[1] - b[1]));
    let mut best = (first, 0.0);
    for i in 1..points.len() {
        if !outside(&best, points[i]) {
            continue;
        }
        best = (points[i], 0.0);
        for j in 0..i {
            if !outside(&best, points[j]) {
                continue;
            }
            best = two(points[i], points[j]);
            for k in 0..j {
                if outside(&best, points[k]) {
                    best = through(points[i], points[j], points[k]).unwrap_or(best);
                }
            }
        }
    }
    best
}

/// The circle through three points; none where they lie on a line.
fn through(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Option<([f64; 2], f64)> {
    let d = 2.0 * turn(a, b, c);
    if d.abs() < 1e-12 {
        return None;
    }
    let (bx, by, cx, cy) = (b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]);
    let (b2, c2) = (bx * bx + by * by, cx * cx + cy * cy);
    let (ux, uy) = ((cy * b2 - by * c2) / d, (bx * c2 - cx * b2) / d);
    Some(([a[0] + ux, a[1] + uy], ux.hypot(uy)))
}

/// A convex hull in space.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Hull {
    /// Corners, mm.
    pub corners: Vec<Vec3>,
    /// Volume, mm³.
    pub volume: f64,
}

/// Shifts of the points, parts of their extent, tried in turn until the hull closes.
const JOGGLES: [f64; 4] = [0.0, 1e-8, 1e-7, 1e-6];

/// The hull of points in space; of flat sets the volume is 0 and the corners are all points.
///
/// Along a nearly straight stretch faces are slivers, and rounding decides from which side they are seen: where the surface
/// would not stay closed, the points are shifted a little (at most a millionth of their extent) and taken again.
pub fn spatial(points: &[Vec3]) -> Hull {
    let extent = points.iter().map(|p| (p - points[0]).norm()).fold(0.0, f64::max);
    let hull = JOGGLES.iter().find_map(|part| {
        let shifted: Vec<Vec3> = points.iter().enumerate().map(|(k, p)| p + part * extent * scatter(k)).collect();
        let Some(first) = tetrahedron(&shifted) else { return Some((Vec::new(), 0.0)) };
        // Shifted points lie in no common plane that a tolerance would have to keep.
        let faces = closed(&shifted, first, if *part == 0.0 { 1e-9 * extent } else { 0.0 })?;
        let volume = enclosed(&shifted, &faces);
        Some((faces, volume))
    });
    // Points that no shift brings into general position have no volume that could be told.
    let (faces, volume) = hull.unwrap_or((Vec::new(), f64::NAN));
    if faces.is_empty() {
        return Hull { corners: points.to_vec(), volume };
    }
    let mut used: Vec<usize> = faces.into_iter().flatten().collect();
    used.sort_unstable();
    used.dedup();
    Hull { corners: used.into_iter().map(|k| points[k]).collect(), volume }
}

/// A direction of its own for every point, each part within ±1 (the fractions of an irrational's multiples).
fn scatter(k: usize) -> Vec3 {
    let part = |irrational: f64| 2.0 * ((k + 1) as f64 * irrational).fract() - 1.0;
    Vec3::new(part(0.754_877_666_246_693), part(0.569_840_290_998_053), part(0.618_033_988_749_895))
}

/// The faces of the hull, grown from a tetrahedron's point by point; none where the surface does not stay closed.
fn closed(points: &[Vec3], mut faces: Vec<[usize; 3]>, tolerance: f64) -> Option<Vec<[usize; 3]>> {
    let height = |f: &[usize; 3], p: &Vec3| {
        let normal = (points[f[1]] - points[f[0]]).cross(&(points[f[2]] - points[f[0]]));
        normal.dot(&(p - points[f[0]])) / normal.norm().max(1e-300)
    };
    for (p, point) in points.iter().enumerate() {
        let (seen, rest): (Vec<[usize; 3]>, Vec<[usize; 3]>) =
            faces.iter().partition(|f| !f.contains(&p) && height(f, point) > tolerance);
        if seen.is_empty() {
            continue;
        }
        let edges: Vec<(usize, usize)> = seen.iter().flat_map(|f| [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])]).collect();
        // The rim: edges of seen faces whose other side is not seen.
        let rim: Vec<(usize, usize)> = edges.iter().filter(|(a, b)| !edges.contains(&(*b, *a))).copied().collect();
        let mut corners: Vec<usize> = seen.iter().flatten().copied().collect();
        corners.sort_unstable();
        corners.dedup();
        // What is seen of a convex body is a disc: faces = rim + 2 inner corners - 2 (Euler).
        if seen.len() + rim.len() + 2 != 2 * corners.len() {
            return None;
        }
        faces = rest;
        faces.extend(rim.iter().map(|&(a, b)| [a, b, p]));
    }
    Some(faces)
}

/// The volume within a closed surface.
fn enclosed(points: &[Vec3], faces: &[[usize; 3]]) -> f64 {
    let Some(first) = faces.first() else { return 0.0 };
    let inside = points[first[0]];
    let part =
        |f: &[usize; 3]| (points[f[0]] - inside).dot(&(points[f[1]] - inside).cross(&(points[f[2]] - inside))) / 6.0;
    faces.iter().map(part).sum()
}

/// Four faces about four far points, normals outwards; none for a flat set.
fn tetrahedron(points: &[Vec3]) -> Option<Vec<[usize; 3]>> {
    let furthest = |score: &dyn Fn(&Vec3) -> f64| {
        (0..points.len()).max_by(|&a, &b| score(&points[a]).total_cmp(&score(&points[b])))
    };
    let a = furthest(&|p| -p.x)?;
    let b = furthest(&|p| (p - points[a]).norm())?;
    let extent = (points[b] - points[a]).norm();
    let along = (points[b] - points[a]).try_normalize(1e-12)?;
    let c = furthest(&|p| (p - points[a]).cross(&along).norm())?;
    let normal = (points[b] - points[a]).cross(&(points[c] - points[a])).try_normalize(1e-9 * extent * extent)?;
    let d = furthest(&|p| (p - points[a]).dot(&normal).abs())?;
    let height = (points[d] - points[a]).dot(&normal);
    if height.abs() < 1e-9 * extent {
        return None;
    }
    // Seen from d, a-b-c turns clockwise when d lies above: then it faces away as it must.
    let (b, c) = if height > 0.0 { (c, b) } else { (b, c) };
    Some(vec![[a, b, c], [a, c, d], [c, b, d], [b, a, d]])
}
