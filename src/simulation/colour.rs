//! Light is added up in linear RGB; photographs and parameters speak sRGB (IEC 61966-2-1).

use crate::optics::Vec3;

/// Linear light of an sRGB value, both 0..1.
pub fn linear(srgb: f64) -> f64 {
    if srgb <= 0.040_45 { srgb / 12.92 } else { ((srgb + 0.055) / 1.055).powf(2.4) }
}

/// Linear light of an sRGB colour.
pub fn linear_rgb(srgb: [f64; 3]) -> Vec3 {
    Vec3::new(linear(srgb[0]), linear(srgb[1]), linear(srgb[2]))
}

/// sRGB value of linear light; light over 1 saturates.
pub fn encoded(linear: f64) -> f64 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoding_is_undone() {
        for i in 0..=255 {
            let s = f64::from(i) / 255.0;
            assert!((encoded(linear(s)) - s).abs() < 1e-6, "{s}");
        }
        // 18 % grey is coded as 0.4614 (118 of 255).
        assert!((encoded(0.18) * 255.0 - 117.6).abs() < 0.1);
    }
}
