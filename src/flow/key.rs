//! The key of a node: what decides its result, and nothing else.
//!
//! BLAKE3 over the stage's name and version, the canonical form of its parameters, and for each port, by name,
//! the digests of the upstream artefacts in order. Paths, times, hosts, thread counts, labels stay out.

use crate::store::{Digest, Key, canonical_json};

/// The key of a stage with these parameters and inputs; `ports` sorted by name.
pub(super) fn key(stage: &str, version: u32, params: &serde_json::Value, ports: &[(&str, Vec<Digest>)]) -> Key {
    let mut bytes = b"rootvox key 1".to_vec();
    text(stage, &mut bytes);
    bytes.extend(version.to_le_bytes());
    bytes.extend(canonical_json(params));
    bytes.extend((ports.len() as u64).to_le_bytes());
    for (port, digests) in ports {
        text(port, &mut bytes);
        bytes.extend((digests.len() as u64).to_le_bytes());
        for digest in digests {
            bytes.extend(digest.0);
        }
    }
    Digest::of(&bytes)
}

fn text(text: &str, bytes: &mut Vec<u8>) {
    bytes.extend((text.len() as u64).to_le_bytes());
    bytes.extend(text.as_bytes());
}
