//! Colour: sRGB as encoded (0..1), linear light, CIE L*a*b* (D65), gray.
//!
//! Constants after IEC 61966-2-1 (sRGB) and CIE 15 (L*a*b* by ε = 216/24389, κ = 24389/27).

/// Weights of R, G, B in gray, ITU-R BT.601: on encoded values, as image libraries do it.
pub const GRAY: [f32; 3] = [0.299, 0.587, 0.114];

/// Gray of an encoded colour.
pub fn gray(rgb: [f32; 3]) -> f32 {
    GRAY[0] * rgb[0] + GRAY[1] * rgb[1] + GRAY[2] * rgb[2]
}

/// Linear light of an encoded value, both 0..1.
pub fn linear_of_srgb(c: f32) -> f32 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// Encoded value of linear light, both 0..1.
pub fn srgb_of_linear(c: f32) -> f32 {
    if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

const XYZ_OF_RGB: [[f32; 3]; 3] = [
    [0.412_456_4, 0.357_576_1, 0.180_437_5],
    [0.212_672_9, 0.715_152_2, 0.072_175],
    [0.019_333_9, 0.119_192, 0.950_304_1],
];
const RGB_OF_XYZ: [[f32; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266, 1.876_010_8, 0.041_556],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];
const WHITE: [f32; 3] = [0.950_47, 1.0, 1.088_83];
const EPSILON: f32 = 216.0 / 24389.0;
const KAPPA: f32 = 24389.0 / 27.0;

fn times(m: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// CIE L*a*b* (L 0..100) of an encoded colour (0..1).
pub fn lab_of_srgb(rgb: [f32; 3]) -> [f32; 3] {
    let xyz = times(&XYZ_OF_RGB, rgb.map(linear_of_srgb));
    let mut f = [0.0; 3];
    for c in 0..3 {
        let t = xyz[c] / WHITE[c];
        f[c] = if t > EPSILON { t.cbrt() } else { (KAPPA * t + 16.0) / 116.0 };
    }
    [116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])]
}

/// Encoded colour of CIE L*a*b*, clamped to 0..1 where it lies outside sRGB.
pub fn srgb_of_lab(lab: [f32; 3]) -> [f32; 3] {
    let fy = (lab[0] + 16.0) / 116.0;
    let f = [fy + lab[1] / 500.0, fy, fy - lab[2] / 200.0];
    let mut xyz = [0.0; 3];
    for c in 0..3 {
        let cube = f[c] * f[c] * f[c];
        xyz[c] = WHITE[c] * if cube > EPSILON { cube } else { (116.0 * f[c] - 16.0) / KAPPA };
    }
    times(&RGB_OF_XYZ, xyz).map(|c| srgb_of_linear(c.clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f32; 3], b: [f32; 3], tolerance: f32) -> bool {
        a.iter().zip(b).all(|(x, y)| (x - y).abs() <= tolerance)
    }

    #[test]
    fn published_values() {
        // Corners of the sRGB cube as commonly tabulated for D65.
        for (rgb, lab) in [
            ([1.0, 1.0, 1.0], [100.0, 0.0, 0.0]),
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
            ([1.0, 0.0, 0.0], [53.24, 80.09, 67.20]),
            ([0.0, 1.0, 0.0], [87.73, -86.18, 83.18]),
            ([0.0, 0.0, 1.0], [32.30, 79.19, -107.86]),
        ] {
            assert!(near(lab_of_srgb(rgb), lab, 0.02), "{rgb:?}: {:?}", lab_of_srgb(rgb));
        }
    }

    #[test]
    fn every_code_survives_the_way_there_and_back() {
        for r in (0..=255).step_by(15) {
            for g in (0..=255).step_by(17) {
                for b in 0..=255u32 {
                    let rgb = [r as f32 / 255.0, g as f32 / 255.0, b as f32 / 255.0];
                    assert!(near(srgb_of_lab(lab_of_srgb(rgb)), rgb, 5e-4), "{rgb:?}");
                }
            }
        }
    }
}
