//! `ro-crate-metadata.json`: what the results folder is and where it comes from, as repositories read it.
//!
//! RO-Crate 1.1: the root data set, its files, and the action that made them: the program (instrument), the inputs with
//! their digests (object), the results (result), and the memory it took (resourceUsage, a term of the Workflow Run
//! profile). See <https://www.researchobject.org/ro-crate/>.

use super::batch::{Batch, Study};
use super::lock::Lock;
use crate::error::{Error, Result};
use crate::flow::Report;
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
    ("trait_spread.csv", "text/csv", "Spread of every trait over halves of the photographs"),
    ("calibration", "image/png", "How cameras and tank were found: mask, outlines, ring of cameras, uncertainties"),
    ("evidence", "image/png", "Per photograph: what is behind the roots, the share of root, how sure it is"),
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
    ("compare.html", "text/html", "The roots of every point side by side in space, and what differs"),
    ("study", "application/toml", "The study file"),
    ("input", "image/jpeg", "What the study reads: photographs, cameras, tank"),
    ("results", "application/json", "The results of each study, a folder each"),
    ("nodes", "application/x-tar", "Nodes of the store, packed"),
    ("points", "text/csv", "The numbers of every point, a folder each"),
    ("quality.csv", "text/csv", "How well each capture of the trial went"),
    ("effects.csv", "text/csv", "How much groups of plants differ in each trait"),
    ("growth.csv", "text/csv", "What each root did between two days"),
    (
        "days",
        "application/xml",
        "The roots of each day in one frame and under common numbers: RSML per day, glTF per plant",
    ),
    ("analysis.R", "text/x-r", "Reads the tables of the trial"),
    ("study.lock", "application/json", "Every parameter, version and digest; `rootvox rerun` repeats it"),
];

/// Name of the file.
pub const NAME: &str = "ro-crate-metadata.json";

/// The names of all files and folders that results may have.
pub fn known() -> Vec<String> {
    KNOWN.iter().map(|(name, ..)| (*name).to_owned()).collect()
}

/// The files and folders that a page of metadata names; `None` where it is no such page.
pub fn parts(page: &[u8]) -> Option<Vec<String>> {
    let page: Value = serde_json::from_slice(page).ok()?;
    let root = page["@graph"].as_array()?.iter().find(|entity| entity["@id"] == "./")?;
    let parts = root["hasPart"].as_array()?.iter();
    parts.map(|part| Some(part["@id"].as_str()?.to_owned())).collect()
}

/// What is known of the run that made a result.
#[derive(Debug, Default)]
pub struct Made {
    /// When the roots were extracted, the latest of all points (RFC 3339); empty where none were.
    pub time: String,
    /// The machine that did it.
    pub host: String,
    /// The largest resident memory of the program while a node of the study ran, bytes.
    pub resident_peak_bytes: Option<u64>,
}

impl Made {
    /// What the nodes of the study say.
    pub fn of(batch: &Batch, study: &Study, report: &Report) -> Self {
        let extracts =
            study.points.iter().filter_map(|point| point.planned.as_ref().ok().map(|(_, nodes)| nodes.extract));
        let latest = extracts.filter_map(|node| report.manifest(node)).max_by(|a, b| a.started.cmp(&b.started));
        let reached = batch.graph.walk().upstream(&study.targets());
        Self {
            time: latest.map(|m| m.started.clone()).unwrap_or_default(),
            host: latest.map(|m| m.host.clone()).unwrap_or_default(),
            resident_peak_bytes: reached.iter().filter_map(|n| report.manifest(*n)?.resident_peak_bytes).max(),
        }
    }
}

/// What a page of metadata says of the run that made a result; nothing where it is no such page.
pub fn made(page: &[u8]) -> Made {
    let page: Value = serde_json::from_slice(page).unwrap_or_default();
    let entity = |id: &str| page["@graph"].as_array()?.iter().find(|entity| entity["@id"] == id);
    let text = |id: &str, name: &str| entity(id)?[name].as_str().map(str::to_owned);
    let host = text("#run", "description").and_then(|d| Some(d.split('`').nth(1)?.to_owned()));
    Made {
        time: text("#run", "endTime").unwrap_or_default(),
        host: host.unwrap_or_default(),
        resident_peak_bytes: text("#resident-peak", "value").and_then(|bytes| bytes.parse().ok()),
    }
}

/// The licence as the metadata names it: the address of an SPDX name, an address as it is, or that none is given.
fn license(lock: &Lock) -> Value {
    let given = lock.settings.get("study.license").map(|toml| toml.trim_matches(['"', '\'']).to_owned());
    let is_name = |name: &str| name.chars().all(|c| c.is_ascii_alphanumeric() || ".+-".contains(c));
    let named = |id: String, name: String| json!({ "@id": id, "@type": "CreativeWork", "name": name });
    match given.filter(|given| !given.trim().is_empty()) {
        Some(url) if url.contains("://") && !url.contains(char::is_whitespace) => named(url.clone(), url),
        Some(name) if is_name(&name) => named(format!("https://spdx.org/licenses/{name}"), name),
        Some(words) => named("#license".into(), words),
        None => json!({ "@id": "#license", "@type": "CreativeWork", "name": "No licence given",
            "description": "The study does not say under what licence its results are: ask those who made them" }),
    }
}

/// The metadata of a results folder that holds `entries`.
///
/// # Errors
/// Where it cannot be written as JSON.
pub fn text(lock: &Lock, entries: &[(String, bool)], made: &Made) -> Result<String> {
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
    let license = license(lock);
    let usage: Vec<Value> = made
        .resident_peak_bytes
        .map(|bytes| {
            json!({ "@id": "#resident-peak", "@type": "PropertyValue", "name": "Largest resident memory",
                "value": bytes.to_string(), "unitText": "bytes" })
        })
        .into_iter()
        .collect();
    let mut graph = vec![
        json!({ "@id": NAME, "@type": "CreativeWork", "about": { "@id": "./" },
            "conformsTo": { "@id": "https://w3id.org/ro/crate/1.1" } }),
        json!({ "@id": "./", "@type": "Dataset", "name": format!("Root system `{}`", lock.study),
            "description": "3D root system reconstructed from photographs of a plant in a water-filled cylinder",
            "datePublished": made.time, "license": { "@id": license["@id"] }, "hasPart": ids(&parts),
            "mentions": { "@id": "#run" } }),
        json!({ "@id": "#rootvox", "@type": "SoftwareApplication", "name": "rootvox", "version": lock.rootvox }),
        json!({ "@id": "#run", "@type": "CreateAction", "name": format!("rootvox run of `{}`", lock.study),
            "description": format!("Computed on `{}`", made.host), "endTime": made.time,
            "instrument": { "@id": "#rootvox" }, "object": ids(&inputs), "result": ids(&parts),
            "resourceUsage": ids(&usage) }),
        license,
    ];
    graph.extend(usage);
    graph.extend(parts);
    graph.extend(inputs);
    let context = ["https://w3id.org/ro/crate/1.1/context", "https://w3id.org/ro/terms/workflow-run/context"];
    let page = json!({ "@context": context, "@graph": graph });
    serde_json::to_string_pretty(&page).map(|t| t + "\n").map_err(|e| Error::failed(format!("RO-Crate: {e}")))
}
