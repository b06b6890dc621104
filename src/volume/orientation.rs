//! The 13 orientations of a 3x3x3 neighbourhood and the neighbours across each.  Paper 2.5.
//!
//! The 26 neighbours form 13 antipodal pairs: 3 along axes, 6 along face diagonals, 4 along body
//! diagonals. A tangent takes the orientation nearest by angle (at most 27.6° away; on a tie the first
//! in the order of [`ORIENTATIONS`]). The neighbours across an orientation are those whose offset is
//! orthogonal to it: 8 for an axis, 8 for a face diagonal, 6 for a body diagonal.

/// One of each antipodal pair, (x, y, z).
pub const ORIENTATIONS: [[i8; 3]; 13] = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 0],
    [1, -1, 0],
    [1, 0, 1],
    [1, 0, -1],
    [0, 1, 1],
    [0, 1, -1],
    [1, 1, 1],
    [1, 1, -1],
    [1, -1, 1],
    [-1, 1, 1],
];

/// Index of the orientation nearest to a tangent of any length and sign.
pub fn nearest(tangent: [f32; 3]) -> usize {
    let mut best = 0;
    let mut greatest = -1.0;
    for (index, d) in ORIENTATIONS.iter().enumerate() {
        let dot: f32 = (0..3).map(|c| tangent[c] * f32::from(d[c])).sum();
        let length2: f32 = d.iter().map(|&x| f32::from(x * x)).sum();
        // cos² times the tangent's squared length.
        let closeness = dot * dot / length2;
        if closeness > greatest {
            (best, greatest) = (index, closeness);
        }
    }
    best
}

/// Offsets (x, y, z) of the neighbours across an orientation.
pub fn across(orientation: usize) -> Vec<[i8; 3]> {
    let d = ORIENTATIONS[orientation];
    let mut offsets = Vec::new();
    for z in -1..=1 {
        for y in -1..=1 {
            for x in -1..=1 {
                if [x, y, z] != [0; 3] && x * d[0] + y * d[1] + z * d[2] == 0 {
                    offsets.push([x, y, z]);
                }
            }
        }
    }
    offsets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_orientation_is_its_own_nearest_and_has_its_number_of_neighbours_across() {
        for (index, d) in ORIENTATIONS.iter().enumerate() {
            for sign in [-0.3, 2.0] {
                assert_eq!(nearest(d.map(|x| sign * f32::from(x))), index);
            }
            let expected = if d.iter().filter(|&&x| x != 0).count() == 3 { 6 } else { 8 };
            assert_eq!(across(index).len(), expected);
        }
    }

    #[test]
    fn the_nearest_is_never_farther_than_27_6_degrees() {
        let mut worst = 0.0f32;
        for a in 0..200 {
            for b in 0..100 {
                let (phi, cos) = (a as f32 * 0.0314, b as f32 / 99.0);
                let sin = (1.0 - cos * cos).sqrt();
                let t = [sin * phi.cos(), sin * phi.sin(), cos];
                let d = ORIENTATIONS[nearest(t)].map(f32::from);
                let dot: f32 = (0..3).map(|c| t[c] * d[c]).sum::<f32>().abs();
                worst = worst.max((dot / d.iter().map(|x| x * x).sum::<f32>().sqrt()).min(1.0).acos());
            }
        }
        assert!(worst.to_degrees() < 27.7, "{}", worst.to_degrees());
    }
}
