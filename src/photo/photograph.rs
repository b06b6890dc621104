//! A decoded photograph, in the depth that its file has: 8 or 16 bits a channel, as encoded (sRGB).
//!
//! Codes are counted as of 8 bits, 0..255; a photograph of 16 bits divides each into 257 steps.

use super::Picture;
use ndarray::Array3;

/// A type of pixel values: whole steps, of which a code of 0..255 holds some.
pub trait Depth: Copy + Default + Send + Sync + 'static {
    /// Steps in a code.
    const STEPS: u16;
    /// The greatest value: code 255.
    const GREATEST: u16 = 255 * Self::STEPS;
    /// The value in steps.
    fn steps(self) -> u16;
    /// The nearest value to so many steps; what lies beyond the ends is cut off.
    fn nearest(steps: f32) -> Self;
}

impl Depth for u8 {
    const STEPS: u16 = 1;

    fn steps(self) -> u16 {
        self.into()
    }

    fn nearest(steps: f32) -> Self {
        (steps + 0.5).clamp(0.0, 255.0) as Self
    }
}

impl Depth for u16 {
    const STEPS: u16 = 257;

    fn steps(self) -> u16 {
        self
    }

    fn nearest(steps: f32) -> Self {
        (steps + 0.5).clamp(0.0, 65535.0) as Self
    }
}

/// A photograph: (y, x, rgb) as encoded (sRGB).
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Photograph {
    /// 8 bits a channel.
    Eight(Picture),
    /// 16 bits a channel.
    Sixteen(Array3<u16>),
}

impl Photograph {
    /// Width and height, px.
    pub fn size(&self) -> (usize, usize) {
        let (height, width, _) = match self {
            Self::Eight(codes) => codes.dim(),
            Self::Sixteen(steps) => steps.dim(),
        };
        (width, height)
    }

    /// Codes 0..255, with fractions where it has 16 bits.
    pub fn codes(&self) -> Array3<f32> {
        match self {
            Self::Eight(codes) => codes.mapv(f32::from),
            Self::Sixteen(steps) => steps.mapv(|v| f32::from(v) / f32::from(u16::STEPS)),
        }
    }

    /// The photograph in 8 bits; those of 16 are rounded.
    pub fn into_picture(self) -> Picture {
        match self {
            Self::Eight(codes) => codes,
            Self::Sixteen(steps) => steps.mapv(|v| ((u32::from(v) + 128) / 257) as u8),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_bits_are_rounded_to_the_nearest_code() {
        for v in (0..=u16::MAX).step_by(7).chain([u16::MAX]) {
            let picture = Photograph::Sixteen(Array3::from_elem((1, 1, 3), v)).into_picture();
            assert_eq!(f64::from(picture[[0, 0, 0]]), (f64::from(v) / 257.0).round(), "{v}");
        }
    }

    #[test]
    fn values_are_rounded_and_cut_off() {
        assert_eq!([u8::nearest(-3.0), u8::nearest(7.4), u8::nearest(7.6), u8::nearest(300.0)], [0, 7, 8, 255]);
        assert_eq!([u16::nearest(-3.0), u16::nearest(65534.6), u16::nearest(1e6)], [0, 65535, 65535]);
        assert_eq!((<u8 as Depth>::GREATEST, <u16 as Depth>::GREATEST), (255, 65535));
    }
}
