//! `ro-crate-metadata.json`: what the results folder is and where it comes from, as repositories read it.
//!
//! RO-Crate 1.1: the root data set, its files, and the action that made them: the program (instrument), the inputs with
//! their digests (object) and the results (result). See <https://www.researchobject.org/ro-crate/>.

use super::lock::Lock;
use crate::error::{Error, Result};
use serde_json::{Value, json};

/// Files and folders of results, with their form and what they are.
const KNOWN: &[(&str, &str, &str)] = &[
    ("root_voxels.csv", "text/csv", "Root voxels: place (mm, tank frame) and rootness"),
    ("roots.csv", "text/csv", "Centrelines: one row per point, a root's rows in order"),
    ("roots.rsml", "application/xml", "Root system, RSML"),
    ("roots.ply", "model/ply", "Roots as a mesh"),
    ("traits.csv", "text/csv", "Traits of the root system"),
    ("depth_profile.csv", "text/csv", "Length, volume and tips by layers of depth"),
    ("repairs.csv", "text/csv", "What the tracing changed against the bare ridge, and why"),
    ("centrelines.ply", "model/ply", "Centrelines as lines"),
    ("roots.glb", "model/gltf-binary", "Roots as a coloured mesh"),
    ("roots.swc", "text/plain", "Roots as SWC"),
    ("slices", "image/png", "A horizontal slice of the volumes"),
    ("per_root.csv", "text/csv", "Traits of each root"),
    ("cameras.json", "application/json", "Lens and pose of every photograph"),
    ("score.json", "application/json", "Precision, recall and F1 against the truth"),
    ("roots_score.json", "application/json", "The traced roots against the truth: where they are right, traits"),
    ("camera_errors.json", "application/json", "Cameras and tank against those of the simulated capture"),
    ("volume.ome.zarr", "application/vnd+zarr", "Merged colours, rootness and labels, OME-Zarr 0.5"),
    ("overlays", "image/jpeg", "The roots on every photograph"),
    ("report.html", "text/html", "The result on one page"),
    ("sweep.csv", "text/csv", "One row per point of the sweep: values, scores, digest"),
    ("curves.svg", "image/svg+xml", "Scores against the swept parameter"),
    ("curves.csv", "text/csv", "Scores against the swept parameter: mean, least, greatest"),
    ("contact.svg", "image/svg+xml", "The roots of every point side by side"),
    ("points", "text/csv", "The numbers of every point, a folder each"),
    ("study.lock", "application/json", "Every parameter, version and digest; `rootvox rerun` repeats it"),
];

/// Name of the file.
pub const NAME: &str = "ro-crate-metadata.json";

/// The files and folders that a page of metadata names; `None` where it is no such page.
pub fn parts(page: &[u8]) -> Option<Vec<String>> {
    let page: Value = serde_json::from_slice(page).ok()?;
    let root = page["@graph"].as_array()?.iter().find(|entity| entity["@id"] == "./")?;
    let parts = root["hasPart"].as_array()?.iter();
    parts.map(|part| Some(part["@id"].as_str()?.to_owned())).collect()
}

/// The metadata of a results folder that holds `entries`; `made` is when its main node was computed (RFC 3339).
///
/// # Errors
/// Where it cannot be written as JSON.
pub fn text(lock: &Lock, entries: &[(String, bool)], made: &str) -> Result<String> {
    let part = |(name, is_folder): &(String, bool)| {
        let known = KNOWN.iter().find(|(known, ..)| known == name);
        let (form, about) = known.map_or(("application/octet-stream", ""), |(_, form, about)| (form, about));
        let (id, kind) = if *is_folder { (format!("{name}/"), "Dataset") } else { (name.clone(), "File") };
        json!({ "@id": id, "@type": kind, "name": name, "description": about, "encodingFormat": form })
    };
    let parts: Vec<Value> = entries.iter().map(part).collect();
    let ids = |values: &[Value]| values.iter().map(|v| json!({ "@id": v["@id"] })).collect::<Vec<_>>();
    let inputs: Vec<Value> = lock
        .nodes
        .iter()
        .filter_map(|node| {
            let digest = node.digest.filter(|_| node.work.is_none())?;
            Some(json!({ "@id": format!("#{}", node.node), "@type": "CreativeWork", "name": node.node,
                "identifier": format!("blake3:{digest}") }))
        })
        .collect();
    let mut graph = vec![
        json!({ "@id": NAME, "@type": "CreativeWork", "about": { "@id": "./" },
            "conformsTo": { "@id": "https://w3id.org/ro/crate/1.1" } }),
        json!({ "@id": "./", "@type": "Dataset", "name": format!("Root system `{}`", lock.study),
            "description": "3D root system reconstructed from photographs of a plant in a water-filled cylinder",
            "datePublished": made, "hasPart": ids(&parts), "mentions": { "@id": "#run" } }),
        json!({ "@id": "#rootvox", "@type": "SoftwareApplication", "name": "rootvox", "version": lock.rootvox }),
        json!({ "@id": "#run", "@type": "CreateAction", "name": format!("rootvox run of `{}`", lock.study),
            "endTime": made, "instrument": { "@id": "#rootvox" }, "object": ids(&inputs), "result": ids(&parts) }),
    ];
    graph.extend(parts);
    graph.extend(inputs);
    let page = json!({ "@context": "https://w3id.org/ro/crate/1.1/context", "@graph": graph });
    serde_json::to_string_pretty(&page).map(|t| t + "\n").map_err(|e| Error::failed(format!("RO-Crate: {e}")))
}
