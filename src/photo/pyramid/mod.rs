//! Sampling a photograph at the scale of what is looked at.
//!
//! Level 0 is the photograph; each further level halves it, every pixel the rounded mean of the 2 x 2 below
//! (edges repeated where a side is odd). A sample of texel size T px (T >= 1) blends the bilinear values of the
//! levels of texel 2^e <= T < 2^{e+1}, linearly in T; T <= 1 is the plain bilinear value.
//!
//! A bilinear tap among texels of size T blurs, averaged over its position, by T²/4 (box T²/12 and tent
//! T²/6); a box of side L blurs by L²/12. [`Pyramid::texel_of_box`] therefore takes T = L/√3.

mod quads;

use super::Picture;
use quads::Quads;
use rayon::prelude::*;

/// A photograph and its halvings.
#[derive(Debug, Clone)]
pub struct Pyramid {
    levels: Levels,
}

/// Pictures of one channel or two, such as shares of root with their confidence, are sampled as such: the same values for
/// less work.
#[derive(Debug, Clone)]
enum Levels {
    /// R, G, B and a pad.
    Colour(Vec<Level<4>>),
    /// Three channels alike.
    Gray(Vec<Quads<1>>),
    /// Red and green; blue is 0.
    Pair(Vec<Quads<2>>),
}

#[derive(Debug, Clone)]
struct Level<const C: usize> {
    /// Pixels of this level per pixel of the photograph.
    scale: f64,
    width: usize,
    height: usize,
    pixels: Vec<[u8; C]>,
}

impl Pyramid {
    /// The photograph alone: every sample is a bilinear one.
    pub fn flat(picture: &Picture) -> Self {
        Self::new(picture, 1.0)
    }

    /// The photograph and its halvings for texels up to `largest_texel` px.
    pub fn new(picture: &Picture, largest_texel: f64) -> Self {
        let picture = picture.as_standard_layout();
        let values = picture.as_slice().expect("standard layout");
        let is_gray = values.chunks_exact(3).all(|rgb| rgb[0] == rgb[1] && rgb[0] == rgb[2]);
        let (height, width, _) = picture.dim();
        let levels = if is_gray {
            Levels::Gray(quad_levels(picture.dim(), values.chunks_exact(3).map(|rgb| [rgb[0]]), largest_texel))
        } else if values.chunks_exact(3).all(|rgb| rgb[2] == 0) {
            Levels::Pair(quad_levels(picture.dim(), values.chunks_exact(3).map(|rgb| [rgb[0], rgb[1]]), largest_texel))
        } else {
            let pixels = values.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2], 0]).collect();
            Levels::Colour(halvings(Level { scale: 1.0, width, height, pixels }, largest_texel))
        };
        Self { levels }
    }

    /// Texel size whose bilinear tap blurs as much as a box of this side, both in px.
    pub fn texel_of_box(side: f64) -> f64 {
        side / 3f64.sqrt()
    }

    /// Value at pixel `(u, v)` with texels of size `texel` px; `None` beyond the outermost pixels' edges or
    /// where a coordinate is NaN. Between the outermost centres and their edges the outermost values hold.
    pub fn sample(&self, u: f64, v: f64, texel: f64) -> Option<[u8; 3]> {
        let [[red, green, blue, seen]] = self.samples(&[u], &[v], &[texel], &[true]);
        (seen > 0).then_some([red, green, blue])
    }

    /// The values, and 255, at N pixels abreast; zeros where [`Self::sample`] gives `None` and where none is wanted.
    #[inline(always)]
    pub fn samples<const N: usize>(
        &self,
        u: &[f64; N],
        v: &[f64; N],
        texel: &[f64; N],
        wanted: &[bool; N],
    ) -> [[u8; 4]; N] {
        let mut out = [[0; 4]; N];
        match &self.levels {
            Levels::Colour(levels) => {
                let inside = inside(levels[0].width, levels[0].height, u, v);
                for l in (0..N).filter(|&l| wanted[l] & inside[l]) {
                    let [red, green, blue, _] = colour(levels, u[l], v[l], texel[l]);
                    out[l] = [red, green, blue, 255];
                }
            }
            Levels::Gray(levels) => {
                let [width, height] = levels[0].size();
                let inside = inside(width, height, u, v);
                let [values] = quads::samples(levels, u, v, texel, wanted);
                for l in 0..N {
                    let seen = u32::from(wanted[l] & inside[l]);
                    out[l] = (seen * (u32::from(values[l]) * 0x0001_0101 + 0xFF00_0000)).to_le_bytes();
                }
            }
            Levels::Pair(levels) => {
                let [width, height] = levels[0].size();
                let inside = inside(width, height, u, v);
                let [red, green] = quads::samples(levels, u, v, texel, wanted);
                for l in 0..N {
                    let seen = u32::from(wanted[l] & inside[l]);
                    let value = u32::from(red[l]) + u32::from(green[l]) * 0x100 + 0xFF00_0000;
                    out[l] = (seen * value).to_le_bytes();
                }
            }
        }
        out
    }
}

/// Which positions lie within the picture's edges; NaN does not.
#[inline(always)]
fn inside<const N: usize>(width: usize, height: usize, u: &[f64; N], v: &[f64; N]) -> [bool; N] {
    let (right, bottom) = (width as f64 - 0.5, height as f64 - 0.5);
    let mut inside = [false; N];
    for l in 0..N {
        inside[l] = (u[l] >= -0.5) & (v[l] >= -0.5) & (u[l] <= right) & (v[l] <= bottom);
    }
    inside
}

/// Level of a texel size, and how far on the way to the next: exponent and fraction.
#[inline(always)]
fn split(texel: f64) -> (i32, f32) {
    let texel = texel as f32;
    let bits = if texel > 1.0 { texel } else { 1.0 }.to_bits();
    ((bits >> 23) as i32 - 127, f32::from_bits((bits & 0x007F_FFFF) | 0x3F80_0000) - 1.0)
}

/// The levels of a picture of so many pixels, as quads.
fn quad_levels<const C: usize>(
    (height, width, _): (usize, usize, usize),
    pixels: impl Iterator<Item = [u8; C]>,
    largest_texel: f64,
) -> Vec<Quads<C>> {
    let finest = Level { scale: 1.0, width, height, pixels: pixels.collect() };
    halvings(finest, largest_texel).iter().map(Quads::new).collect()
}

/// A level and its halvings.
fn halvings<const C: usize>(finest: Level<C>, largest_texel: f64) -> Vec<Level<C>> {
    let mut levels = vec![finest];
    let mut texel = 1.0;
    while texel < largest_texel {
        let last = levels.last().expect("at least one level");
        if last.width.max(last.height) < 2 {
            break;
        }
        let half = last.halved();
        levels.push(half);
        texel *= 2.0;
    }
    levels
}

/// See [`Pyramid::sample`]; the position lies inside.
#[inline(always)]
fn colour(levels: &[Level<4>], u: f64, v: f64, texel: f64) -> [u8; 4] {
    let (level, fraction) = split(texel);
    let (level, top) = (level as usize, levels.len() - 1);
    let mut value = levels[level.min(top)].at(u, v);
    if level < top && fraction != 0.0 {
        let coarse = levels[level + 1].at(u, v);
        for c in 0..4 {
            value[c] += fraction * (coarse[c] - value[c]);
        }
    }
    let mut out = [0; 4];
    for c in 0..4 {
        out[c] = (value[c] + 0.5) as u8;
    }
    out
}

impl<const C: usize> Level<C> {
    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let mut pixels = vec![[0; C]; width * height];
        pixels.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            let above = &self.pixels[2 * y * self.width..][..self.width];
            let below = &self.pixels[(2 * y + 1).min(self.height - 1) * self.width..][..self.width];
            for (x, pixel) in row.iter_mut().enumerate() {
                let (left, right) = (2 * x, (2 * x + 1).min(self.width - 1));
                for c in 0..C {
                    let sum = [above[left][c], above[right][c], below[left][c], below[right][c]];
                    pixel[c] = ((sum.iter().map(|&v| u16::from(v)).sum::<u16>() + 2) / 4) as u8;
                }
            }
        });
        Self { scale: 0.5 * self.scale, width, height, pixels }
    }
}

impl Level<4> {
    /// Bilinear value at a position given in pixels of level 0.
    #[inline(always)]
    fn at(&self, u: f64, v: f64) -> [f32; 4] {
        let u = ((u + 0.5) * self.scale - 0.5).clamp(0.0, (self.width - 1) as f64);
        let v = ((v + 0.5) * self.scale - 0.5).clamp(0.0, (self.height - 1) as f64);
        let (u0, v0) = (u as usize, v as usize);
        let (u1, v1) = ((u0 + 1).min(self.width - 1), (v0 + 1).min(self.height - 1));
        let (fu, fv) = ((u - u0 as f64) as f32, (v - v0 as f64) as f32);
        let (top, low) = (&self.pixels[v0 * self.width..], &self.pixels[v1 * self.width..]);
        let (a, b, c, d) = (top[u0], top[u1], low[u0], low[u1]);
        // A closure would not be inlined into code for wide registers.
        let mut out = [0.0; 4];
        for i in 0..4 {
            let (a, b, c, d) = (f32::from(a[i]), f32::from(b[i]), f32::from(c[i]), f32::from(d[i]));
            let above = a + fu * (b - a);
            let below = c + fu * (d - c);
            out[i] = above + fv * (below - above);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_keeps_its_values_at_every_scale() {
        let ramp = Picture::from_shape_fn((64, 64, 3), |(y, x, _)| (2 * x + y) as u8);
        let pyramid = Pyramid::new(&ramp, 8.0);
        assert!(matches!(&pyramid.levels, Levels::Gray(levels) if levels.len() == 4));
        for texel in [0.3, 1.0, 1.5, 2.0, 3.7, 6.0] {
            let value = pyramid.sample(30.25, 31.5, texel).unwrap()[1];
            assert!(value.abs_diff(92) <= 1, "texel {texel}: {value}");
        }
    }

    #[test]
    fn fine_stripes_average_out_where_texels_are_wide() {
        let stripes = Picture::from_shape_fn((64, 64, 3), |(_, x, _)| if x % 2 == 0 { 0 } else { 200 });
        let pyramid = Pyramid::new(&stripes, 4.0);
        assert_eq!(pyramid.sample(31.0, 20.0, 1.0), Some([200; 3]));
        assert_eq!(pyramid.sample(31.0, 20.0, 2.0), Some([100; 3]));
    }

    #[test]
    fn gray_is_sampled_as_colours_are() {
        let code = |y: usize, x: usize| (7 * x + 13 * y) as u8;
        let gray = Picture::from_shape_fn((41, 33, 3), |(y, x, _)| code(y, x));
        // One pixel far off makes it a colour picture.
        let mut coloured = gray.clone();
        coloured[[40, 32, 2]] ^= 1;
        let (gray, coloured) = (Pyramid::new(&gray, 4.0), Pyramid::new(&coloured, 4.0));
        assert!(matches!((&gray.levels, &coloured.levels), (Levels::Gray(a), Levels::Colour(b)) if a.len() == b.len()));
        for k in 0..2000 {
            let (u, v, texel) = (f64::from(k) * 0.0131 - 0.5, f64::from(k % 97) * 0.31 - 0.5, f64::from(k % 13) * 0.3);
            assert_eq!(gray.sample(u, v, texel), coloured.sample(u, v, texel));
        }
        // Whole pixels, edges and centres too.
        for k in 0..=2 * 41 * 33 {
            let (u, v) = (f64::from(k % 67) * 0.5 - 0.5, f64::from(k / 67) * 0.5 - 0.5);
            assert_eq!(gray.sample(u, v, 1.0), coloured.sample(u, v, 1.0), "{u} {v}");
        }
    }

    #[test]
    fn two_channels_are_sampled_as_colours_are() {
        let pair =
            Picture::from_shape_fn((41, 33, 3), |(y, x, c)| if c < 2 { (7 * x + 13 * y + 91 * c) as u8 } else { 0 });
        let mut coloured = pair.clone();
        coloured[[40, 32, 2]] = 1;
        let (pair, coloured) = (Pyramid::new(&pair, 4.0), Pyramid::new(&coloured, 4.0));
        assert!(matches!((&pair.levels, &coloured.levels), (Levels::Pair(_), Levels::Colour(_))));
        for k in 0..2000 {
            let (u, v, texel) = (f64::from(k) * 0.0131 - 0.5, f64::from(k % 97) * 0.31 - 0.5, f64::from(k % 13) * 0.3);
            assert_eq!(pair.sample(u, v, texel), coloured.sample(u, v, texel));
        }
    }

    #[test]
    fn abreast_is_one_by_one() {
        for salt in [0, 1, 2] {
            let mut picture = Picture::from_shape_fn((41, 33, 3), |(y, x, _)| (7 * x + 13 * y) as u8);
            picture[[40, 32, 2]] ^= salt;
            if salt == 2 {
                picture.index_axis_mut(ndarray::Axis(2), 2).fill(0);
            }
            let pyramid = Pyramid::new(&picture, 4.0);
            for k in 0..3000 {
                let of = |l: usize, step: usize, base: usize| ((k * step + l * base) % 997) as f64 / 997.0;
                let mut u: [f64; 8] = std::array::from_fn(|l| of(l, 31, 17) * 36.0 - 1.5);
                let v: [f64; 8] = std::array::from_fn(|l| of(l, 57, 29) * 44.0 - 1.5);
                // Every third time all lanes take the same levels.
                let texel: [f64; 8] =
                    std::array::from_fn(|l| if k % 3 == 0 { of(0, 7, 1) * 9.0 } else { of(l, 7, 191) * 9.0 });
                let wanted: [bool; 8] = std::array::from_fn(|l| (k + l) % 5 != 0);
                u[k % 8] = f64::NAN;
                let found = pyramid.samples(&u, &v, &texel, &wanted);
                for l in 0..8 {
                    let one = pyramid.sample(u[l], v[l], texel[l]).filter(|_| wanted[l]);
                    assert_eq!(found[l], one.map_or([0; 4], |[r, g, b]| [r, g, b, 255]), "{k} {l}");
                }
            }
        }
    }

    #[test]
    fn outside_there_is_nothing() {
        let pyramid = Pyramid::flat(&Picture::from_elem((5, 7, 3), 9));
        assert_eq!(pyramid.sample(-0.5, 4.5, 1.0), Some([9; 3]));
        for (u, v) in [(-0.51, 0.0), (6.51, 0.0), (0.0, -0.51), (0.0, 4.51), (f64::NAN, 0.0)] {
            assert_eq!(pyramid.sample(u, v, 1.0), None);
        }
    }
}
