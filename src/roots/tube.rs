//! Surfaces of roots: rings of vertices about the centreline, closed at both ends.
//!
//! The rings turn with the centreline without twisting about it (each frame is the one before, turned by
//! the smallest rotation between the tangents). A ring has `sides` vertices on the circle whose polygon has the
//! circle's area, so that the volume of a straight tube is that of the cylinder.

use super::Root;
use crate::optics::Vec3;

/// A mesh of triangles.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Vertices, tank frame, mm.
    pub vertices_mm: Vec<[f32; 3]>,
    /// Outward unit normals, one per vertex.
    pub normals: Vec<[f32; 3]>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// The tube of `root` with `sides` (3 or more) vertices per ring; empty for fewer than two points.
pub fn tube(root: &Root, sides: usize) -> Mesh {
    let points: Vec<Vec3> = root.points_mm.iter().map(|p| Vec3::from(*p)).collect();
    let n = points.len();
    let mut mesh = Mesh::default();
    if n < 2 || sides < 3 {
        return mesh;
    }
    let turn = std::f64::consts::TAU / sides as f64;
    let swell = (turn / turn.sin()).sqrt();
    let mut last = Vec3::zeros();
    let mut across = Vec3::zeros();
    for k in 0..n {
        let (a, b) = (points[k.saturating_sub(1)], points[(k + 1).min(n - 1)]);
        let tangent = (b - a).try_normalize(1e-12).unwrap_or(if k == 0 { Vec3::z() } else { last });
        across = if k == 0 {
            tangent.cross(&if tangent.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() }).normalize()
        } else {
            (across - tangent * across.dot(&tangent))
                .try_normalize(1e-9)
                .unwrap_or_else(|| tangent.cross(&last).try_normalize(1e-9).unwrap_or(across))
        };
        last = tangent;
        let third = tangent.cross(&across);
        for side in 0..sides {
            let (sin, cos) = (turn * side as f64).sin_cos();
            let normal = across * cos + third * sin;
            let p = points[k] + normal * (root.radii_mm[k] * swell);
            mesh.vertices_mm.push([p.x as f32, p.y as f32, p.z as f32]);
            mesh.normals.push([normal.x as f32, normal.y as f32, normal.z as f32]);
        }
    }
    let ring = |k: usize, side: usize| (k * sides + side % sides) as u32;
    for k in 0..n - 1 {
        for side in 0..sides {
            let (a, b, c, d) = (ring(k, side), ring(k, side + 1), ring(k + 1, side), ring(k + 1, side + 1));
            mesh.triangles.push([a, b, d]);
            mesh.triangles.push([a, d, c]);
        }
    }
    for side in 1..sides - 1 {
        mesh.triangles.push([ring(0, 0), ring(0, side + 1), ring(0, side)]);
        mesh.triangles.push([ring(n - 1, 0), ring(n - 1, side), ring(n - 1, side + 1)]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume enclosed by a mesh (divergence theorem), mm³.
    fn volume(mesh: &Mesh) -> f64 {
        let v = |k: u32| Vec3::from(mesh.vertices_mm[k as usize].map(f64::from));
        mesh.triangles.iter().map(|t| v(t[0]).dot(&v(t[1]).cross(&v(t[2]))) / 6.0).sum()
    }

    #[test]
    fn a_tube_is_closed_and_has_the_cylinders_volume() {
        let root = Root {
            id: 0,
            parent: -1,
            order: 0,
            points_mm: (0..20).map(|k| [1.0, 0.1 * f64::from(k), 0.5 * f64::from(k)]).collect(),
            radii_mm: vec![0.7; 20],
        };
        let mesh = tube(&root, 8);
        let length = 19.0 * 0.1f64.hypot(0.5);
        let truth = std::f64::consts::PI * 0.49 * length;
        assert!((volume(&mesh) / truth - 1.0).abs() < 1e-4, "{} against {truth}", volume(&mesh));
        let mut edges = std::collections::BTreeMap::new();
        for t in &mesh.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                *edges.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|&sum| sum == 0), "every edge is used once each way");
        assert!(tube(&Root { points_mm: vec![[0.0; 3]], radii_mm: vec![1.0], ..root }, 8).vertices_mm.is_empty());
    }
}
