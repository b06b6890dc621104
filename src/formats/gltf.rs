//! glTF 2.0, binary (GLB): one mesh per root, coloured, y up and in metres as the format asks.
//!
//! The tank frame's (x, y, z down) in mm becomes (x, -z, y) in m: right-handed, y up, no mirror. Each root is a
//! node named `root-<id>` that carries id, parent and order as extras; all share one buffer.

use crate::error::{Error, Result};
use crate::roots::Root;
use crate::roots::tube::tube;
use serde_json::{Value, json};

/// The bytes of a GLB file with the tubes of all roots.
///
/// # Errors
/// Where the file would exceed 4 GB.
pub fn write(roots: &[Root], sides: usize, colour: impl Fn(&Root) -> [u8; 3]) -> Result<Vec<u8>> {
    let mut buffer: Vec<u8> = Vec::new();
    let (mut views, mut accessors, mut meshes, mut nodes, mut materials) = (vec![], vec![], vec![], vec![], vec![]);
    for root in roots {
        let mesh = tube(root, sides);
        if mesh.triangles.is_empty() {
            continue;
        }
        let turned = |[x, y, z]: [f32; 3], scale: f32| [x * scale, -z * scale, y * scale];
        let places: Vec<[f32; 3]> = mesh.vertices_mm.iter().map(|&p| turned(p, 1e-3)).collect();
        let normals: Vec<[f32; 3]> = mesh.normals.iter().map(|&n| turned(n, 1.0)).collect();
        let bound = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..3).map(|d| places.iter().map(|p| p[d]).reduce(pick).unwrap_or(0.0)).collect()
        };
        let first = accessors.len();
        let count = places.len();
        let mut put = |bytes: Vec<u8>, target: u32, accessor: Value| {
            let mut accessor = accessor;
            accessor["bufferView"] = json!(views.len());
            views.push(json!({"buffer": 0, "byteOffset": buffer.len(), "byteLength": bytes.len(), "target": target}));
            buffer.extend(bytes);
            accessors.push(accessor);
        };
        let floats = |rows: &[[f32; 3]]| rows.iter().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        put(
            floats(&places),
            34962,
            json!({"componentType": 5126, "count": count, "type": "VEC3", "min": bound(f32::min), "max": bound(f32::max)}),
        );
        put(floats(&normals), 34962, json!({"componentType": 5126, "count": count, "type": "VEC3"}));
        let indices: Vec<u8> = mesh.triangles.iter().flatten().flat_map(|k| k.to_le_bytes()).collect();
        let corners = 3 * mesh.triangles.len();
        put(indices, 34963, json!({"componentType": 5125, "count": corners, "type": "SCALAR"}));
        // Base colours are linear light.
        let rgb = colour(root).map(|c| crate::photo::colour::linear_of_srgb(f32::from(c) / 255.0));
        let pbr =
            json!({"baseColorFactor": [rgb[0], rgb[1], rgb[2], 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8});
        meshes.push(json!({"primitives": [{
            "attributes": {"POSITION": first, "NORMAL": first + 1},
            "indices": first + 2,
            "material": materials.len(),
        }]}));
        materials.push(json!({"pbrMetallicRoughness": pbr}));
        nodes.push(json!({
            "name": format!("root-{}", root.id),
            "mesh": meshes.len() - 1,
            "extras": {"root_id": root.id, "parent_id": root.parent, "order": root.order},
        }));
    }
    let mut document = json!({
        "asset": {"version": "2.0", "generator": concat!("rootvox ", env!("CARGO_PKG_VERSION"))},
        "scene": 0,
    });
    // Empty lists are not valid glTF.
    document["scenes"] =
        if nodes.is_empty() { json!([{}]) } else { json!([{"nodes": (0..nodes.len()).collect::<Vec<_>>()}]) };
    if !nodes.is_empty() {
        document["buffers"] = json!([{"byteLength": buffer.len()}]);
        for (key, list) in [
            ("bufferViews", views),
            ("accessors", accessors),
            ("meshes", meshes),
            ("materials", materials),
            ("nodes", nodes),
        ] {
            document[key] = Value::Array(list);
        }
    }
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let body = if buffer.is_empty() { 0 } else { buffer.len() + 8 };
    let total = u32::try_from(12 + 8 + text.len() + body)
        .map_err(|_| Error::failed("GLB: the roots need more than 4 GB").help("write fewer sides per tube"))?;
    let mut out = Vec::with_capacity(total as usize);
    out.extend(b"glTF");
    out.extend(2u32.to_le_bytes());
    out.extend(total.to_le_bytes());
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(text);
    if !buffer.is_empty() {
        out.extend((buffer.len() as u32).to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(buffer);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_and_bounds() {
        let root = Root {
            id: 2,
            parent: -1,
            order: 0,
            points_mm: vec![[0.0, 0.0, 100.0], [0.0, 0.0, 200.0]],
            radii_mm: vec![1.0; 2],
        };
        let bytes = write(&[root], 6, |_| [255, 0, 0]).unwrap();
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
        let text: Value = serde_json::from_slice(&bytes[20..20 + word(12)]).unwrap();
        assert_eq!(word(20 + word(12)), text["buffers"][0]["byteLength"].as_u64().unwrap() as usize);
        let bounds = &text["accessors"][0];
        assert!(
            (bounds["max"][1].as_f64().unwrap() + 0.1).abs() < 1e-6
                && (bounds["min"][1].as_f64().unwrap() + 0.2).abs() < 1e-6
        );
        assert_eq!(text["nodes"][0]["extras"]["root_id"], 2);
        let empty = write(&[], 6, |_| [0; 3]).unwrap();
        assert_eq!(u32::from_le_bytes(empty[8..12].try_into().unwrap()) as usize, empty.len());
    }
}
