//! Levels of one channel or two, sampled many positions abreast.
//!
//! A bilinear tap looks at 2 x 2 pixels. They are kept together, once for every pixel as their upper left one (edges
//! repeated), so that a tap is one load; positions, weights and blends then run in lanes.

use super::{Level, split};

/// A level of C channels whose pixels stand with their neighbours to the right, below, and both.
#[derive(Debug, Clone)]
pub(super) struct Quads<const C: usize> {
    scale: f64,
    width: usize,
    height: usize,
    quads: Vec<[[u8; 4]; C]>,
}

impl<const C: usize> Quads<C> {
    pub(super) fn new(level: &Level<C>) -> Self {
        let &Level { scale, width, height, ref pixels } = level;
        let mut quads = Vec::with_capacity(pixels.len());
        for y in 0..height {
            let above = &pixels[y * width..][..width];
            let below = &pixels[(y + 1).min(height - 1) * width..][..width];
            for x in 0..width {
                let right = (x + 1).min(width - 1);
                quads.push(std::array::from_fn(|c| [above[x][c], above[right][c], below[x][c], below[right][c]]));
            }
        }
        Self { scale, width, height, quads }
    }

    /// Width and height.
    pub(super) fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Bilinear values at positions given in pixels of level 0; anything beyond the edges or where they are NaN.
    #[inline(always)]
    fn at<const N: usize>(&self, u: &[f64; N], v: &[f64; N]) -> [[f32; N]; C] {
        let (right, bottom) = ((self.width - 1) as f64, (self.height - 1) as f64);
        let (mut fu, mut fv, mut index) = ([0.0f32; N], [0.0f32; N], [0i32; N]);
        for l in 0..N {
            let (u, v) = ((u[l] + 0.5) * self.scale - 0.5, (v[l] + 0.5) * self.scale - 0.5);
            let (u, v) = (between(u, right), between(v, bottom));
            let (u0, v0) = (u as i32, v as i32);
            (fu[l], fv[l]) = ((u - f64::from(u0)) as f32, (v - f64::from(v0)) as f32);
            index[l] = v0 * self.width as i32 + u0;
        }
        let mut quads = [[0u32; N]; C];
        for l in 0..N {
            let all = self.quads.get(index[l] as usize).copied().unwrap_or([[0; 4]; C]);
            for c in 0..C {
                quads[c][l] = u32::from_le_bytes(all[c]);
            }
        }
        let mut out = [[0.0; N]; C];
        for c in 0..C {
            for l in 0..N {
                let quad = quads[c][l];
                let above = byte(quad) + fu[l] * (byte(quad >> 8) - byte(quad));
                let below = byte(quad >> 16) + fu[l] * (byte(quad >> 24) - byte(quad >> 16));
                out[c][l] = above + fv[l] * (below - above);
            }
        }
        out
    }
}

/// A number from 0 to `end`, where NaN is 0.
#[inline(always)]
fn between(value: f64, end: f64) -> f64 {
    let value = if value > 0.0 { value } else { 0.0 };
    if value < end { value } else { end }
}

#[inline(always)]
fn byte(quad: u32) -> f32 {
    (quad & 255) as i32 as f32
}

/// Values at positions where they are wanted; see [`super::Pyramid::samples`]. Anything outside.
#[inline(always)]
pub(super) fn samples<const C: usize, const N: usize>(
    levels: &[Quads<C>],
    u: &[f64; N],
    v: &[f64; N],
    texel: &[f64; N],
    wanted: &[bool; N],
) -> [[u8; N]; C] {
    let top = levels.len() as i32 - 1;
    let (mut level, mut fraction) = ([0; N], [0.0; N]);
    for l in 0..N {
        let (whole, rest) = split(texel[l]);
        level[l] = whole.min(top);
        fraction[l] = if whole < top { rest } else { 0.0 };
    }
    let mut any = 0;
    for l in 0..N {
        any = if wanted[l] { level[l] } else { any };
    }
    let (mut alike, mut blended) = (true, false);
    for l in 0..N {
        alike &= !wanted[l] | (level[l] == any);
        blended |= fraction[l] != 0.0;
    }
    let mut value = [[0.0; N]; C];
    if alike {
        value = levels[any as usize].at(u, v);
        if blended {
            blend(&mut value, &levels[(any + 1).min(top) as usize].at(u, v), &fraction);
        }
    } else {
        for l in (0..N).filter(|&l| wanted[l]) {
            let mut one = levels[level[l] as usize].at(&[u[l]], &[v[l]]);
            if fraction[l] != 0.0 {
                blend(&mut one, &levels[level[l] as usize + 1].at(&[u[l]], &[v[l]]), &[fraction[l]]);
            }
            for c in 0..C {
                [value[c][l]] = one[c];
            }
        }
    }
    let mut out = [[0; N]; C];
    for c in 0..C {
        for l in 0..N {
            out[c][l] = (value[c][l] + 0.5) as u8;
        }
    }
    out
}

#[inline(always)]
fn blend<const C: usize, const N: usize>(value: &mut [[f32; N]; C], coarse: &[[f32; N]; C], fraction: &[f32; N]) {
    for c in 0..C {
        for l in 0..N {
            value[c][l] += fraction[l] * (coarse[c][l] - value[c][l]);
        }
    }
}
