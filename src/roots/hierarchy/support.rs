//! Leaves out what the photographs do not show.
//!
//! A ridge of the merged light need not be a root: chance, mirrors and the shadows of others leave short ones. A root is
//! seen by most of the photographs that look at it unhindered; all looks along it count alike, be they few. A ridge that
//! every photograph sees behind or before other roots only is explained by those, unless it was found that the photographs need it
//! ([`crate::roots::explain`]).

use super::HierarchyParams;
use crate::optics::Vec3;
use crate::roots::repair::{Kind, Repair};
use crate::roots::trace::Pieces;

/// The pieces that at least the share `params.shown` of the unhindered looks show, with the ties among them; all of them
/// where no photograph was asked.
pub fn supported(pieces: &Pieces, params: &HierarchyParams, log: &mut Vec<Repair>) -> Pieces {
    let mut kept = pieces.clone();
    if pieces.looks.is_empty() {
        return kept;
    }
    let mut number = vec![None; pieces.pieces.len()];
    kept.pieces.clear();
    kept.looks.clear();
    kept.strengths.clear();
    for (n, piece) in pieces.pieces.iter().enumerate() {
        let looks = pieces.looks.get(n).copied().unwrap_or_default();
        let (shown, points) = (looks.share(), &piece.root.points_mm);
        if shown.unwrap_or(if pieces.explained { 1.0 } else { 0.0 }) >= params.shown {
            number[n] = Some(kept.pieces.len());
            kept.pieces.push(piece.clone());
            kept.looks.push(looks);
            kept.strengths.extend(pieces.strengths.get(n));
            continue;
        }
        let middle = Vec3::from(points[points.len() / 2]);
        let length = crate::roots::curve::chord_lengths(points).last().copied().unwrap_or(0.0);
        let reason = match shown {
            Some(share) => format!("{:.0} % of the photographs that look at it unhindered show a root", 100.0 * share),
            None => "no photograph looks at it past other roots".to_owned(),
        };
        log.push(Repair::new(Kind::Pruned, &middle, length, reason));
    }
    kept.ties = pieces
        .ties
        .iter()
        .filter_map(|tie| {
            let (strand, onto) = (number[tie.strand]?, number[tie.onto]?);
            Some(crate::roots::tie::Tie { strand, onto, ..*tie })
        })
        .collect();
    kept.out_of_sight = pieces
        .out_of_sight
        .iter()
        .filter_map(|out| Some(crate::roots::trace::OutOfSight { piece: number[out.piece]?, ..*out }))
        .collect();
    kept
}
