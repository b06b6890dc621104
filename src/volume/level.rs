//! The level that parts roots from noise in a volume's own ridges.
//!
//! Ridge voxels are of two kinds: very many weak ones of noise and stray crossings, and few strong ones of
//! roots, whose strength depends on the capture (contrast, noise, diameters, sway). Otsu's threshold, the
//! cut that leaves the least variance within the two kinds, lies midway between their means; as the
//! weak ones' mean is nearly zero, that is half the typical root's rootness. Thresholds in units of it
//! mean the same on every capture.
//!
//! Without roots Otsu would part noise from noise; so the level is never below [`NOISE_MULTIPLE`] times the
//! median ridge, which is noise wherever most ridges are.

/// Ridges of noise rarely exceed twice to three times their median.
pub const NOISE_MULTIPLE: f32 = 4.0;

/// The level of a volume's ridges; 0 where there is none.
pub fn level(rootness: &[f32]) -> f32 {
    let mut sorted = rootness.to_vec();
    sorted.sort_unstable_by(f32::total_cmp);
    let total: f64 = sorted.iter().map(|&r| f64::from(r)).sum();
    let n = sorted.len() as f64;
    let (mut below, mut best, mut cut) = (0.0, -1.0, 0.0);
    for (k, pair) in sorted.windows(2).enumerate() {
        below += f64::from(pair[0]);
        let count = (k + 1) as f64;
        let gap = (total - below) / (n - count) - below / count;
        let between = count * (n - count) * gap * gap;
        if between > best && pair[0] < pair[1] {
            (best, cut) = (between, 0.5 * (pair[0] + pair[1]));
        }
    }
    let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    cut.max(NOISE_MULTIPLE * median)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lies_midway_between_two_kinds() {
        let mut ridges: Vec<f32> = (0..9000).map(|n| 0.04 + 0.02 * (n % 100) as f32 / 100.0).collect();
        ridges.extend((0..500).map(|n| 0.8 + 0.4 * (n % 50) as f32 / 50.0));
        let level = level(&ridges);
        assert!(level > 0.06 && level < 0.8, "{level}");
    }

    #[test]
    fn keeps_off_noise_where_there_are_no_roots() {
        let ridges: Vec<f32> = (0..1000).map(|n| 0.01 + 0.02 * n as f32 / 1000.0).collect();
        assert!(level(&ridges) > 2.0 * 0.03);
        assert_eq!(level(&[]), 0.0);
        assert_eq!(level(&[0.5]), 2.0);
    }
}
