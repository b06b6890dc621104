//! Pieces as beads: points about half a millimetre apart, all pieces in one row.

use crate::optics::Vec3;
use crate::roots::diameter::track::Beads;
use std::ops::Range;

/// Least way between two beads, mm: about a pixel, so that their looks are measurements of their own.
const LEAST_MM: f64 = 0.4;

/// All beads of all pieces.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Chain {
    /// Tank frame, mm.
    pub places: Vec<Vec3>,
    /// Unit tangents; zero where a piece is a point.
    pub tangents: Vec<Vec3>,
    /// Length of root that a bead stands for, mm.
    pub step_mm: Vec<f64>,
    /// Number of the piece.
    pub piece: Vec<u32>,
    /// The beads of each piece.
    pub pieces: Vec<Range<usize>>,
}

impl Chain {
    /// The beads of the lines, mm.
    pub fn new<'a>(lines: impl Iterator<Item = &'a [[f64; 3]]>) -> Self {
        let mut chain = Self::default();
        for (number, line) in lines.enumerate() {
            let beads = Beads::new(line, LEAST_MM);
            let (start, last) = (chain.places.len(), beads.places.len().saturating_sub(1));
            for b in 0..beads.places.len() {
                let (from, to) = (b.saturating_sub(1), (b + 1).min(last));
                chain.places.push(beads.places[b]);
                chain.tangents.push(beads.tangent(b).unwrap_or_else(Vec3::zeros));
                chain.step_mm.push((beads.arc_mm[to] - beads.arc_mm[from]) / (to - from).max(1) as f64);
                chain.piece.push(number as u32);
            }
            chain.pieces.push(start..chain.places.len());
        }
        chain
    }

    /// How many beads.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Beads of the same piece up to `reach` before and behind.
    pub fn near(&self, bead: usize, reach: usize) -> Range<usize> {
        let piece = &self.pieces[self.piece[bead] as usize];
        bead.saturating_sub(reach).max(piece.start)..(bead + reach + 1).min(piece.end)
    }
}
