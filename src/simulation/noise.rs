//! Random numbers that depend on where they are used, not on when: a hash of a seed and coordinates.
//!
//! Used wherever rows are computed in parallel (sensor noise, textures). The hash is the finaliser
//! of SplitMix64 (Steele, Lea, Flood 2014), folded over the coordinates.

/// Mixes a seed with coordinates into 64 bits.
pub fn hash(seed: u64, coordinates: &[u64]) -> u64 {
    coordinates.iter().fold(mix(seed), |state, &x| mix(state ^ x.wrapping_mul(0x9E37_79B9_7F4A_7C15)))
}

fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// Uniform in [0, 1).
pub fn uniform(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// Two independent standard normal numbers (Box and Muller 1958).
pub fn normal_pair(bits: u64) -> (f64, f64) {
    let radius = (-2.0 * (1.0 - uniform(bits)).ln()).sqrt();
    let (sin, cos) = (std::f64::consts::TAU * uniform(mix(bits))).sin_cos();
    (radius * cos, radius * sin)
}

/// Value noise in the plane: random values in [-1, 1] at integer points, smoothly interpolated.
pub fn value_2d(seed: u64, x: f64, y: f64) -> f64 {
    let (x0, y0) = (x.floor(), y.floor());
    let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
    let (fx, fy) = (smooth(x - x0), smooth(y - y0));
    let at = |i: f64, j: f64| 2.0 * uniform(hash(seed, &[(x0 + i) as i64 as u64, (y0 + j) as i64 as u64])) - 1.0;
    let top = at(0.0, 0.0) * (1.0 - fx) + at(1.0, 0.0) * fx;
    let bottom = at(0.0, 1.0) * (1.0 - fx) + at(1.0, 1.0) * fx;
    top * (1.0 - fy) + bottom * fy
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_numbers_have_mean_zero_and_variance_one() {
        let all: Vec<f64> = (0..20_000)
            .flat_map(|i| {
                let (a, b) = normal_pair(hash(7, &[i]));
                [a, b]
            })
            .collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let variance = all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64;
        assert!(mean.abs() < 0.02 && (variance - 1.0).abs() < 0.03, "{mean} {variance}");
    }

    #[test]
    fn coordinates_are_not_interchangeable() {
        assert_ne!(hash(1, &[2, 3]), hash(1, &[3, 2]));
        assert_ne!(hash(1, &[2]), hash(2, &[1]));
    }
}
