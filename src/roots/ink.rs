//! Roots as coloured lines on a photograph.

use super::Root;
use crate::optics::Vec3;

/// A line on a photograph.
#[derive(Debug, Clone, PartialEq)]
pub struct Ink {
    /// Number of the root.
    pub root: i64,
    /// Pixels (u, v) in order.
    pub pixels: Vec<[f64; 2]>,
    /// Colour, sRGB.
    pub colour: [u8; 3],
}

/// Colour by branching order: Okabe and Ito's palette, told apart by colour-blind eyes too.
pub fn by_order(root: &Root) -> [u8; 3] {
    const PALETTE: [[u8; 3]; 6] =
        [[213, 94, 0], [86, 180, 233], [240, 228, 66], [0, 158, 115], [204, 121, 167], [230, 159, 0]];
    PALETTE[(root.order as usize).min(PALETTE.len() - 1)]
}

/// Colour by number: hues a golden angle apart, so that neighbours in number differ most.
pub fn by_root(root: &Root) -> [u8; 3] {
    let hue = (root.id as f64 * 0.618_033_988_75).rem_euclid(1.0) * 6.0;
    let lightness = if root.id.rem_euclid(2) == 0 { 1.0 } else { 0.8 };
    [5.0, 3.0, 1.0].map(|n| {
        let k = (n + hue) % 6.0;
        // Hue to RGB at saturation 0.75.
        let value = 1.0 - 0.75 * k.min(4.0 - k).clamp(0.0, 1.0);
        (255.0 * lightness * value).round() as u8
    })
}

/// The roots as lines, cut where `pixel` sees no point.
pub fn lines(roots: &[Root], pixel: impl Fn(&Vec3) -> Option<[f64; 2]>, colour: impl Fn(&Root) -> [u8; 3]) -> Vec<Ink> {
    let mut all = Vec::new();
    for root in roots {
        let mut open: Vec<[f64; 2]> = Vec::new();
        for p in root.points_mm.iter().map(Some).chain([None]) {
            match p.and_then(|p| pixel(&Vec3::from(*p))) {
                Some(p) => open.push(p),
                None if open.len() > 1 => {
                    all.push(Ink { root: root.id, pixels: std::mem::take(&mut open), colour: colour(root) });
                }
                None => open.clear(),
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_where_unseen() {
        let root = Root {
            id: 1,
            parent: -1,
            order: 1,
            points_mm: (0..10).map(|k| [f64::from(k), 0.0, 0.0]).collect(),
            radii_mm: vec![1.0; 10],
        };
        let seen = |p: &Vec3| (p.x != 4.0 && p.x != 6.0).then_some([p.x, p.y]);
        let ink = lines(std::slice::from_ref(&root), seen, by_order);
        assert_eq!(ink.iter().map(|i| i.pixels.len()).collect::<Vec<_>>(), [4, 3]);
        let colours: std::collections::BTreeSet<[u8; 3]> =
            (0..40).map(|id| by_root(&Root { id, ..root.clone() })).collect();
        assert!(colours.len() > 35);
    }
}
