//! SWC: one line per point, `id type x y z radius parent`, the neuron tracers' tree format.
//!
//! x, y, z and radius in mm (the format says µm; the header tells). Type 2 (axon) for every root of order 0, 3 for laterals.
//! A lateral's first point has the parent's nearest point as parent; a root without parent starts a tree (-1).

use crate::error::{Error, Result};
use crate::roots::Root;
use std::fmt::Write;

/// The content of an SWC file; parents must stand before their laterals, as the tracing orders them.
///
/// # Errors
/// Where a root has another number of radii than of points, or its parent does not stand before it.
pub fn write(roots: &[Root]) -> Result<String> {
    let mut out = String::from("# roots, mm, tank frame (z down)\n# id type x y z radius parent\n");
    let mut first = Vec::with_capacity(roots.len());
    let mut id = 1;
    for (k, root) in roots.iter().enumerate() {
        if root.points_mm.len() != root.radii_mm.len() {
            return Err(Error::failed(format!("SWC: root {} has another number of radii than of points", root.id)));
        }
        let mut parent = -1;
        if let (true, Some(start)) = (root.parent >= 0, root.points_mm.first()) {
            let Some(at) = roots[..k].iter().position(|r| r.id == root.parent) else {
                return Err(Error::failed(format!("SWC: the parent of root {} does not stand before it", root.id)));
            };
            let distance = |q: &[f64; 3]| (0..3).map(|d| (q[d] - start[d]).powi(2)).sum::<f64>();
            let points = &roots[at].points_mm;
            let near = (0..points.len()).min_by(|&a, &b| distance(&points[a]).total_cmp(&distance(&points[b])));
            parent = near.map_or(-1, |n| first[at] + n as i64);
        }
        first.push(id);
        let kind = if root.order == 0 { 2 } else { 3 };
        for (p, r) in root.points_mm.iter().zip(&root.radii_mm) {
            // Writing to a String cannot fail.
            let _ = writeln!(out, "{id} {kind} {:.4} {:.4} {:.4} {r:.4} {parent}", p[0], p[1], p[2]);
            parent = id;
            id += 1;
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lateral_hangs_on_its_parents_nearest_point() {
        let root = |id, parent, order, points: &[[f64; 3]]| Root {
            id,
            parent,
            order,
            points_mm: points.to_vec(),
            radii_mm: vec![0.5; points.len()],
        };
        let taproot = root(0, -1, 0, &[[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 2.0]]);
        let lateral = root(1, 0, 1, &[[0.1, 0.0, 1.1], [1.0, 0.0, 1.2]]);
        let text = write(&[taproot.clone(), lateral.clone()]).unwrap();
        let rows: Vec<&str> = text.lines().skip(2).collect();
        assert_eq!(rows[3], "4 3 0.1000 0.0000 1.1000 0.5000 2");
        assert_eq!(rows[4], "5 3 1.0000 0.0000 1.2000 0.5000 4");
        assert!(write(&[lateral, taproot]).is_err());
    }
}
