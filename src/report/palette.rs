//! Colours that tell neighbours apart.

/// A bright colour for the `n`-th thing: hues a golden angle apart, lightness alternating.
pub fn distinct(n: usize) -> [u8; 3] {
    let hue = (n as f64 * 0.618_033_988_749_895).fract() * 6.0;
    let value = [1.0, 0.85, 0.95][n % 3];
    let saturation = [0.85, 0.7, 1.0][(n / 3) % 3];
    let channel = |shift: f64| {
        let k = (shift + hue) % 6.0;
        let x = value * (1.0 - saturation * k.min(4.0 - k).clamp(0.0, 1.0));
        (x * 255.0).round() as u8
    };
    [channel(5.0), channel(3.0), channel(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_dozen_differ() {
        let colours: Vec<_> = (0..12).map(distinct).collect();
        for (i, a) in colours.iter().enumerate() {
            for b in &colours[..i] {
                let apart: i32 = a.iter().zip(b).map(|(x, y)| (i32::from(*x) - i32::from(*y)).abs()).sum();
                assert!(apart > 30, "{a:?} {b:?}");
            }
        }
    }
}
