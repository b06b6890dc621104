//! What became of roots, as colours and words. Colours are Okabe and Ito's, told apart by colour-blind eyes too, the strongest for what
//! differs most.

use super::Page;
use crate::growth::same_roots::Fate;

/// All fates with their colours and what they mean, the least difference first.
pub const ALL: [(Fate, [u8; 3], &str); 5] = [
    (Fate::Same, [138, 148, 156], "the same in both"),
    (Fate::Length, [86, 180, 233], "another length"),
    (Fate::Place, [230, 159, 0], "another order, parent or direction"),
    (Fate::Part, [204, 121, 167], "a part of another root in the other result"),
    (Fate::Only, [240, 228, 66], "in this result only"),
];

/// Its colour.
pub fn colour(fate: Fate) -> [u8; 3] {
    ALL[fate as usize].1
}

/// Of every result what became of each root; of the first the greatest difference to any other.
pub fn of_all(page: &Page<'_>) -> Vec<Vec<Fate>> {
    let mut all: Vec<Vec<Fate>> = page.shown.iter().map(|shown| vec![Fate::Same; shown.roots.len()]).collect();
    for (n, other) in page.others.iter().enumerate() {
        for entry in &other.entries {
            // The whole that a part is of has a fate of its own.
            if let (Some(root), true) = (entry.first, entry.is_of_first) {
                all[0][root] = all[0][root].max(entry.fate);
            }
            let is_of_other = !entry.is_of_first || entry.fate < Fate::Part;
            if let (Some(root), true) = (entry.other, is_of_other) {
                all[n + 1][root] = entry.fate;
            }
        }
    }
    all
}
