//! What the store knows of one node's result: a JSON page that people can read.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use serde_json::value::RawValue;

use super::digest::{Digest, Key};
use super::element::Dtype;
use crate::error::{Error, Result};

/// Version of the manifest and of the layout; part of the folder's name.
pub const FORMAT: u32 = 1;

/// What a member is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MemberKind {
    /// A Zarr array in a folder of the member's name.
    Array,
    /// A JSON value in `<name>.json`.
    Json,
    /// A file.
    Bytes,
    /// A folder of files.
    Folder,
}

impl MemberKind {
    /// The word used in manifests.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Array => "array",
            Self::Json => "json",
            Self::Bytes => "bytes",
            Self::Folder => "folder",
        }
    }
}

/// One named part of an artefact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Member {
    /// Its name within the artefact.
    pub name: String,
    /// What it is.
    pub kind: MemberKind,
    /// Data type, arrays only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dtype: Option<Dtype>,
    /// Shape, arrays only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shape: Vec<usize>,
    /// Digest of the decoded values.
    pub digest: Digest,
    /// Bytes on disk.
    pub bytes: u64,
}

/// Digest of an artefact: its members by name, each with kind, data type, shape and digest.
///
/// Texts and lists are preceded by their length (u64, little endian), so that no two artefacts share a
/// byte stream.
pub fn digest_of(members: &[Member]) -> Digest {
    let mut sorted: Vec<&Member> = members.iter().collect();
    sorted.sort_by(|a, b| a.name.cmp(&b.name));
    let mut hasher = blake3::Hasher::new();
    hasher.update(b"rootvox artefact 1");
    hasher.update(&(sorted.len() as u64).to_le_bytes());
    for member in sorted {
        for text in [member.name.as_str(), member.kind.as_str(), member.dtype.map_or("", |dtype| dtype.as_str())] {
            hasher.update(&(text.len() as u64).to_le_bytes());
            hasher.update(text.as_bytes());
        }
        hasher.update(&(member.shape.len() as u64).to_le_bytes());
        for &n in &member.shape {
            hasher.update(&(n as u64).to_le_bytes());
        }
        hasher.update(&member.digest.0);
    }
    Digest(hasher.finalize().into())
}

/// One upstream artefact of a node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InputRecord {
    /// Label of the upstream node in the study that ran it.
    pub node: String,
    /// Digest of its artefact.
    pub digest: Digest,
}

/// Parameters of a run. They are most of a manifest, and only a comparison reads them: until then they are text.
#[derive(Debug, Clone, Deserialize)]
#[serde(transparent)]
pub struct Params(Box<RawValue>);

impl Params {
    /// Of the value with that name for each parameter.
    ///
    /// # Errors
    /// Where it cannot be written as JSON.
    pub fn of(value: &Value) -> Result<Self> {
        let raw = serde_json::value::to_raw_value(value);
        raw.map(Self).map_err(|e| Error::failed(format!("parameters of a manifest: {e}")))
    }

    /// The value; its text was read as JSON before.
    pub fn value(&self) -> Value {
        serde_json::from_str(self.0.get()).unwrap_or_default()
    }
}

impl PartialEq for Params {
    fn eq(&self, other: &Self) -> bool {
        self.value() == other.value()
    }
}

/// As a value, so that it is laid out as the rest of the page is.
impl Serialize for Params {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.value().serialize(serializer)
    }
}

/// The record of one node's run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Format of this page.
    pub format: u32,
    /// Name of the stage.
    pub stage: String,
    /// Version of the stage.
    pub version: u32,
    /// Label of the node in the study that ran it.
    pub label: String,
    /// Parameters with their defaults written out.
    pub params: Params,
    /// For each port the upstream artefacts in order.
    pub inputs: BTreeMap<String, Vec<InputRecord>>,
    /// The node's key.
    pub key: Key,
    /// Digest of the artefact.
    pub digest: Digest,
    /// Whether the values were streamed into their consumer and are not stored here.
    #[serde(default, skip_serializing_if = "std::ops::Not::not", rename = "virtual")]
    pub is_virtual: bool,
    /// The parts of the artefact, by name.
    pub members: Vec<Member>,
    /// When the run began (RFC 3339, UTC).
    pub started: String,
    /// How long it took, in seconds.
    pub seconds: f64,
    /// The largest resident memory of the whole process while the stage ran, bytes; what ran beside it is in it.
    /// Unknown where the machine does not tell, and of values that were streamed into their consumer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resident_peak_bytes: Option<u64>,
    /// Threads the run could use.
    pub threads: usize,
    /// Machine it ran on.
    pub host: String,
    /// Version of the program.
    pub program: String,
    /// What the stage warned of.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

impl Manifest {
    /// Whether it is the record of the node `key`, and its members are those that its digest was made of.
    pub(super) fn is_sound(&self, key: Key) -> bool {
        self.format == FORMAT && self.key == key && digest_of(&self.members) == self.digest
    }

    /// Bytes on disk of all members.
    pub fn bytes(&self) -> u64 {
        self.members.iter().map(|member| member.bytes).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn parameters_are_laid_out_as_the_rest_of_the_page_and_come_back_as_they_were() {
        let value = json!({"high": 0.25, "tank": {"belts": [[0.0, 8.0]], "note": "a \"b\""}, "none": null});
        let params = Params::of(&value).unwrap();
        assert_eq!(params.value(), value);
        let page = serde_json::to_string_pretty(&json!({"params": params})).unwrap();
        assert_eq!(page, serde_json::to_string_pretty(&json!({"params": value})).unwrap());
        assert_eq!(serde_json::to_vec_pretty(&params).unwrap(), serde_json::to_vec_pretty(&value).unwrap());
        let back: Params = serde_json::from_str(&serde_json::to_string_pretty(&params).unwrap()).unwrap();
        assert_eq!((back.value(), back == params), (value, true), "its text has lines, its value has not");
        assert_ne!(params, Params::of(&json!({"high": 0.5})).unwrap());
    }
}
