//! How the traits vary: a reconstruction from each of some random halves of the views.

use super::reconstruct::{Photographs, reconstruct};
use super::settings::Settings;
use crate::error::{Error, Result};
use crate::flow::{Graph, NodeId};
use crate::roots::traits::spread::halves;
use crate::stages::spread::Spread;

/// How many random halves of that many views the study asks for.
///
/// # Errors
/// Where they are too few or too small.
pub(super) fn spread_halves(s: &Settings, views: usize) -> Result<usize> {
    let count = s.traits.resample;
    if count > 0 && (!(2..=1000).contains(&count) || views < 6) {
        return Err(Error::usage(format!("traits.resample is {count} for {views} photographs"))
            .help("give 2 to 1000 halves of at least 6 photographs, or 0"));
    }
    Ok(count)
}

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
    let count = spread_halves(s, from.views.len())?;
    if count == 0 {
        return Ok(None);
    }
    let mut draws = Vec::with_capacity(count);
    for (n, half) in halves(from.views.len(), count).iter().enumerate() {
        let pick = |list: &[NodeId]| half.iter().map(|&v| list[v]).collect::<Vec<_>>();
        let (files, cameras, views) = (pick(from.files), pick(from.cameras), pick(from.views));
        let evidence = if from.evidence.is_empty() { Vec::new() } else { pick(from.evidence) };
        let background = from.background;
        let half = Photographs { files: &files, cameras: &cameras, views: &views, background, evidence: &evidence };
        draws.push(reconstruct(graph, s, &half, &format!("/half-{}", n + 1)).traits);
    }
    Ok(Some(graph.add("spread", Spread {}, &[("traits", &[traits][..]), ("draws", &draws)])))
}
