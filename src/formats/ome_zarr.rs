//! The attributes that make a Zarr group an OME-Zarr 0.5 image with labels.
//!
//! One image with axes (c, z, y, x), millimetres, a pyramid whose level l has voxels 2ˡ times as
//! large; `translation` says where the centre of voxel (0, 0, 0) of each level lies.

use crate::volume::Grid;
use serde_json::{Value, json};

const VERSION: &str = "0.5";

/// One channel of the image.
#[derive(Debug, Clone, Copy)]
pub struct Channel {
    /// Name shown by viewers.
    pub label: &'static str,
    /// Display colour, RRGGBB.
    pub colour: &'static str,
    /// Values shown as black and as full colour.
    pub window: [f64; 2],
}

/// Attributes of the image group: multiscales and display hints.
pub fn image(name: &str, grid: &Grid, levels: usize, channels: &[Channel]) -> Value {
    let mut axes = vec![json!({"name": "c", "type": "channel"})];
    axes.extend(space_axes());
    json!({ "ome": {
        "version": VERSION,
        "multiscales": [{ "name": name, "axes": axes, "datasets": datasets(grid, levels, true), "type": "mean" }],
        "omero": { "channels": channels.iter().map(|c| json!({
            "label": c.label,
            "color": c.colour,
            "active": true,
            "window": { "min": c.window[0], "max": c.window[1], "start": c.window[0], "end": c.window[1] },
        })).collect::<Vec<_>>() },
    }})
}

/// Attributes of the `labels` group.
pub fn labels(names: &[&str]) -> Value {
    json!({ "ome": { "version": VERSION, "labels": names } })
}

/// Attributes of one label image (z, y, x).
pub fn label_image(name: &str, grid: &Grid, levels: usize) -> Value {
    json!({ "ome": {
        "version": VERSION,
        "multiscales": [{ "name": name, "axes": space_axes(), "datasets": datasets(grid, levels, false), "type": "max" }],
        "image-label": { "source": { "image": "../../" } },
    }})
}

fn space_axes() -> Vec<Value> {
    ["z", "y", "x"].iter().map(|n| json!({"name": n, "type": "space", "unit": "millimeter"})).collect()
}

fn datasets(grid: &Grid, levels: usize, with_channel: bool) -> Vec<Value> {
    (0..levels)
        .map(|level| {
            let times = (1_u64 << level) as f64;
            let voxel = grid.spacing_mm * times;
            let shift = grid.spacing_mm * (times - 1.0) / 2.0;
            let [x, y, z] = grid.origin_mm;
            let mut scale = vec![voxel; 3];
            let mut translation = vec![z + shift, y + shift, x + shift];
            if with_channel {
                scale.insert(0, 1.0);
                translation.insert(0, 0.0);
            }
            json!({
                "path": level.to_string(),
                "coordinateTransformations": [
                    { "type": "scale", "scale": scale },
                    { "type": "translation", "translation": translation },
                ],
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_keep_the_place_of_the_corner() {
        let grid = Grid { origin_mm: [-5.0, -5.0, 0.0], spacing_mm: 0.5, shape: [8, 21, 21] };
        let value = label_image("roots", &grid, 2);
        let sets = &value["ome"]["multiscales"][0]["datasets"];
        assert_eq!(sets[1]["coordinateTransformations"][0]["scale"], json!([1.0, 1.0, 1.0]));
        // The first coarse voxel covers fine voxels 0 and 1: its centre lies half a fine voxel further.
        assert_eq!(sets[1]["coordinateTransformations"][1]["translation"], json!([0.25, -4.75, -4.75]));
    }
}
