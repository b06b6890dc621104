//! How the traits vary: a reconstruction from each of some random halves of the views.

use super::reconstruct::{Photographs, Seen, reconstruct};
use super::settings::Settings;
use crate::error::{Error, Result};
use crate::flow::{Graph, NodeId};
use crate::roots::traits::spread::halves;
use crate::stages::spread::Spread;

/// How the traits vary over random halves of the views.
///
/// # Errors
/// Where halves are too few or too small.
pub(super) fn spread(
    graph: &mut Graph,
    s: &Settings,
    from: &Photographs<'_>,
    traits: NodeId,
) -> Result<Option<NodeId>> {
    let count = s.traits.resample;
    if count == 0 {
        return Ok(None);
    }
    if !(2..=1000).contains(&count) || from.views.len() < 6 {
        return Err(Error::usage(format!("traits.resample is {count} for {} photographs", from.views.len()))
            .help("give 2 to 1000 halves of at least 6 photographs, or 0"));
    }
    let mut draws = Vec::with_capacity(count);
    for (n, half) in halves(from.views.len(), count).iter().enumerate() {
        let pick = |list: &[NodeId]| half.iter().map(|&v| list[v]).collect::<Vec<_>>();
        let seen: Vec<Seen<'_>> = half.iter().map(|&v| from.seen[v]).collect();
        let (files, views) = (pick(from.files), pick(from.views));
        let evidence = if from.evidence.is_empty() { Vec::new() } else { pick(from.evidence) };
        let background = from.background;
        let half = Photographs { files: &files, seen: &seen, views: &views, background, evidence: &evidence };
        draws.push(reconstruct(graph, s, &half, &format!("/half-{}", n + 1)).traits);
    }
    Ok(Some(graph.add("spread", Spread {}, &[("traits", &[traits][..]), ("draws", &draws)])))
}
