//! glTF 2.0, binary (GLB): one mesh per root, coloured, y up and in metres as the format asks.
//!
//! The tank frame's (x, y, z down) in mm becomes (x, -z, y) in m: right-handed, y up, no mirror. Each root is a
//! node named `root-<id>` that carries id, parent and order as extras; all share one buffer. [`write_days`] is of a plant over days.

use crate::error::{Error, Result};
use crate::roots::Root;
use crate::roots::tube::tube;
use serde_json::{Value, json};

/// The bytes of a GLB file with the tubes of all roots.
///
/// # Errors
/// Where the file would exceed 4 GB.
pub fn write(roots: &[Root], sides: usize, colour: impl Fn(&Root) -> [u8; 3]) -> Result<Vec<u8>> {
    let mut file = File::default();
    let nodes = roots.iter().filter_map(|root| file.tube(root, sides, colour(root), "")).collect();
    file.finish(nodes)
}

/// A plant over days: a node per day, named `day-<n>` from 1 with its time in days as extra, over the nodes of its roots. The
/// animation `growth` shows one after the other, a second each; players that know no animations show all days in each other.
/// A day that is not to be seen is scaled to nothing, as the format advises (glTF 2.0, 3.11).
///
/// # Errors
/// As [`write()`].
pub fn write_days(days: &[(f64, Vec<Root>)], sides: usize, colour: impl Fn(&Root) -> [u8; 3]) -> Result<Vec<u8>> {
    let mut file = File::default();
    let mut of_days = Vec::new();
    for (n, (time, roots)) in days.iter().enumerate() {
        let prefix = format!("day-{}/", n + 1);
        let nodes: Vec<usize> = roots.iter().filter_map(|root| file.tube(root, sides, colour(root), &prefix)).collect();
        let mut day = json!({"name": format!("day-{}", n + 1), "extras": {"day": time}});
        if !nodes.is_empty() {
            day["children"] = json!(nodes);
        }
        of_days.push(file.nodes.len());
        file.nodes.push(day);
    }
    if of_days.len() > 1 {
        file.show_in_turn(&of_days);
    }
    file.finish(of_days)
}

/// A file as it grows.
#[derive(Default)]
struct File {
    buffer: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    nodes: Vec<Value>,
    animations: Vec<Value>,
}

impl File {
    /// Adds numbers, and returns the place of their accessor.
    fn put(&mut self, bytes: Vec<u8>, target: Option<u32>, mut accessor: Value) -> usize {
        accessor["bufferView"] = json!(self.views.len());
        let mut view = json!({"buffer": 0, "byteOffset": self.buffer.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.views.push(view);
        self.buffer.extend(bytes);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds a root and returns the place of its node; none where nothing of it can be drawn.
    fn tube(&mut self, root: &Root, sides: usize, colour: [u8; 3], prefix: &str) -> Option<usize> {
        let mesh = tube(root, sides);
        if mesh.triangles.is_empty() {
            return None;
        }
        let turned = |[x, y, z]: [f32; 3], scale: f32| [x * scale, -z * scale, y * scale];
        let places: Vec<[f32; 3]> = mesh.vertices_mm.iter().map(|&p| turned(p, 1e-3)).collect();
        let normals: Vec<[f32; 3]> = mesh.normals.iter().map(|&n| turned(n, 1.0)).collect();
        let bound = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..3).map(|d| places.iter().map(|p| p[d]).reduce(pick).unwrap_or(0.0)).collect()
        };
        let count = places.len();
        let position = self.put(
            floats(places.iter().flatten()),
            Some(34962),
            json!({"componentType": 5126, "count": count, "type": "VEC3", "min": bound(f32::min), "max": bound(f32::max)}),
        );
        let normal = json!({"componentType": 5126, "count": count, "type": "VEC3"});
        let normal = self.put(floats(normals.iter().flatten()), Some(34962), normal);
        let indices: Vec<u8> = mesh.triangles.iter().flatten().flat_map(|k| k.to_le_bytes()).collect();
        let corners = json!({"componentType": 5125, "count": 3 * mesh.triangles.len(), "type": "SCALAR"});
        let corners = self.put(indices, Some(34963), corners);
        // Base colours are linear light.
        let rgb = colour.map(|c| crate::photo::colour::linear_of_srgb(f32::from(c) / 255.0));
        let pbr =
            json!({"baseColorFactor": [rgb[0], rgb[1], rgb[2], 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8});
        self.meshes.push(json!({"primitives": [{
            "attributes": {"POSITION": position, "NORMAL": normal},
            "indices": corners,
            "material": self.materials.len(),
        }]}));
        self.materials.push(json!({"pbrMetallicRoughness": pbr}));
        self.nodes.push(json!({
            "name": format!("{prefix}root-{}", root.id),
            "mesh": self.meshes.len() - 1,
            "extras": {"root_id": root.id, "parent_id": root.parent, "order": root.order},
        }));
        Some(self.nodes.len() - 1)
    }

    /// The animation that shows one of these nodes after the other, and the last to the end.
    fn show_in_turn(&mut self, nodes: &[usize]) {
        let count = nodes.len() + 1;
        let times: Vec<f32> = (0..count).map(|n| n as f32).collect();
        let input = json!({"componentType": 5126, "count": count, "type": "SCALAR", "min": [0.0], "max": [count - 1]});
        let input = self.put(floats(times.iter()), None, input);
        let (mut samplers, mut channels) = (Vec::new(), Vec::new());
        for (k, node) in nodes.iter().enumerate() {
            let scales = (0..count).flat_map(|n| [f32::from(u8::from(n.min(nodes.len() - 1) == k)); 3]);
            let scales: Vec<f32> = scales.collect();
            let output = json!({"componentType": 5126, "count": count, "type": "VEC3"});
            let output = self.put(floats(scales.iter()), None, output);
            channels.push(json!({"sampler": samplers.len(), "target": {"node": node, "path": "scale"}}));
            samplers.push(json!({"input": input, "output": output, "interpolation": "STEP"}));
        }
        self.animations.push(json!({"name": "growth", "samplers": samplers, "channels": channels}));
    }

    /// The bytes, with these nodes at the top of the scene.
    fn finish(self, top: Vec<usize>) -> Result<Vec<u8>> {
        let mut document = json!({
            "asset": {"version": "2.0", "generator": concat!("rootvox ", env!("CARGO_PKG_VERSION"))},
            "scene": 0,
        });
        // Empty lists are not valid glTF.
        document["scenes"] = if top.is_empty() { json!([{}]) } else { json!([{"nodes": top}]) };
        if !self.buffer.is_empty() {
            document["buffers"] = json!([{"byteLength": self.buffer.len()}]);
        }
        for (key, list) in [
            ("bufferViews", self.views),
            ("accessors", self.accessors),
            ("meshes", self.meshes),
            ("materials", self.materials),
            ("nodes", self.nodes),
            ("animations", self.animations),
        ] {
            if !list.is_empty() {
                document[key] = Value::Array(list);
            }
        }
        packed(document.to_string().into_bytes(), &self.buffer)
    }
}

fn floats<'a>(values: impl Iterator<Item = &'a f32>) -> Vec<u8> {
    values.flat_map(|x| x.to_le_bytes()).collect()
}

/// The two chunks of a GLB file.
fn packed(mut text: Vec<u8>, buffer: &[u8]) -> Result<Vec<u8>> {
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

    fn vertical() -> Root {
        Root {
            id: 2,
            parent: -1,
            order: 0,
            points_mm: vec![[0.0, 0.0, 100.0], [0.0, 0.0, 200.0]],
            radii_mm: vec![1.0; 2],
        }
    }

    #[test]
    fn chunks_and_bounds() {
        let bytes = write(&[vertical()], 6, |_| [255, 0, 0]).unwrap();
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
        let days = write_days(&[(0.0, vec![]), (2.5, vec![vertical()])], 6, |_| [0; 3]).unwrap();
        let length = u32::from_le_bytes(days[12..16].try_into().unwrap()) as usize;
        let text: Value = serde_json::from_slice(&days[20..20 + length]).unwrap();
        assert_eq!(text["scenes"][0]["nodes"], json!([0, 2]));
        let day = &text["nodes"][2];
        assert_eq!((&day["extras"]["day"], &day["children"]), (&json!(2.5), &json!([1])));
        assert_eq!(text["nodes"][1]["name"], "day-2/root-2");
        // Second 0 shows day 1, from second 1 on day 2: three moments, one scale each, the last output of all.
        assert_eq!(text["animations"][0]["channels"][1]["target"], json!({"node": 2, "path": "scale"}));
        let scales: Vec<f32> =
            days[days.len() - 36..].chunks(12).map(|b| f32::from_le_bytes(b[..4].try_into().unwrap())).collect();
        assert_eq!(scales, [0.0, 1.0, 1.0]);
        let empty = write(&[], 6, |_| [0; 3]).unwrap();
        assert_eq!(u32::from_le_bytes(empty[8..12].try_into().unwrap()) as usize, empty.len());
    }
}
