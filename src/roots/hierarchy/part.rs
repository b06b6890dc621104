//! A stretch of a piece that a root takes.

/// Part of a piece, run through from one point to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// The piece.
    pub piece: usize,
    /// Where the root enters.
    pub from: usize,
    /// Where it leaves.
    pub to: usize,
}

impl Part {
    /// The points run through, in order.
    pub fn points(self) -> impl DoubleEndedIterator<Item = usize> {
        let Self { from, to, .. } = self;
        (0..=from.abs_diff(to)).map(move |k| if from <= to { from + k } else { from - k })
    }
}
