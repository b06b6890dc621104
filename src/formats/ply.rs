//! PLY 1.0, binary little-endian: tubes as a mesh, centrelines as vertices and edges. Lengths in mm, tank frame.

use crate::roots::Root;
use crate::roots::tube::tube;

/// The tubes of all roots as one mesh; each vertex with its root's number, order and colour.
pub fn tubes(roots: &[Root], sides: usize, colour: impl Fn(&Root) -> [u8; 3]) -> Vec<u8> {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    let (mut count, mut triangles) = (0u32, 0u32);
    for root in roots {
        let mesh = tube(root, sides);
        let rgb = colour(root);
        for (p, n) in mesh.vertices_mm.iter().zip(&mesh.normals) {
            p.iter().chain(n).for_each(|x| vertices.extend(x.to_le_bytes()));
            vertices.extend(rgb);
            vertices.extend((root.id as i32).to_le_bytes());
            vertices.push(root.order.min(255) as u8);
        }
        for t in &mesh.triangles {
            faces.push(3);
            t.iter().for_each(|k| faces.extend((k + count).to_le_bytes()));
        }
        count += mesh.vertices_mm.len() as u32;
        triangles += mesh.triangles.len() as u32;
    }
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\ncomment roots as tubes, mm, tank frame\nelement vertex {count}\n\
         property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int root_id\nproperty uchar order\n\
         element face {triangles}\nproperty list uchar uint vertex_indices\nend_header\n"
    )
    .into_bytes();
    out.append(&mut vertices);
    out.append(&mut faces);
    out
}

/// The centrelines: a vertex per point with its diameter, an edge per step; a root's points in order.
pub fn centrelines(roots: &[Root], colour: impl Fn(&Root) -> [u8; 3]) -> Vec<u8> {
    let (mut vertices, mut edges) = (Vec::new(), Vec::new());
    let (mut count, mut steps) = (0u32, 0u32);
    for root in roots {
        let rgb = colour(root);
        for (k, (p, r)) in root.points_mm.iter().zip(&root.radii_mm).enumerate() {
            p.iter().chain(&[2.0 * r]).for_each(|x| vertices.extend((*x as f32).to_le_bytes()));
            vertices.extend(rgb);
            vertices.extend((root.id as i32).to_le_bytes());
            vertices.push(root.order.min(255) as u8);
            if k > 0 {
                edges.extend((count - 1).to_le_bytes());
                edges.extend(count.to_le_bytes());
                steps += 1;
            }
            count += 1;
        }
    }
    let mut out = format!(
        "ply\nformat binary_little_endian 1.0\ncomment root centrelines, mm, tank frame\nelement vertex {count}\n\
         property float x\nproperty float y\nproperty float z\nproperty float diameter_mm\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int root_id\nproperty uchar order\n\
         element edge {steps}\nproperty int vertex1\nproperty int vertex2\nend_header\n"
    )
    .into_bytes();
    out.append(&mut vertices);
    out.append(&mut edges);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_match_the_header() {
        let root = Root {
            id: 3,
            parent: -1,
            order: 1,
            points_mm: vec![[0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.5, 2.0]],
            radii_mm: vec![0.5; 3],
        };
        for (bytes, body) in [
            (tubes(std::slice::from_ref(&root), 6, |_| [1, 2, 3]), 18 * 32 + (2 * 12 + 8) * 13),
            (centrelines(&[root], |_| [1, 2, 3]), 3 * 24 + 2 * 8),
        ] {
            let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
            assert!(bytes.starts_with(b"ply\nformat binary_little_endian 1.0\n"));
            assert_eq!(bytes.len() - end, body);
        }
    }
}
