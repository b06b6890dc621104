//! Rows of points at equal steps along x, [`LANES`] rows abreast: each column starts from the cubic
//! extrapolation of the columns before it, so that one Newton step is mostly enough.
//!
//! A step is taken as the solution where it is under 3e-4 in b (mm) and 3e-6 in s and stays inside the
//! fold: what is left after it is of the order of its square over the tank's radius, 1e-9 mm. All
//! other columns go to the safeguarded solution.
//!
//! A row whose points lie beyond the fold goes on along the fold: its ray is the fold's own at the point's height, found by
//! Newton's method in s alone.
//!
//! Columns whose points all lie beyond the fold by more than the `reach` asked for are passed over until one may be back
//! within it: the distance from the fold changes by less than [`MOST_APPROACH`] per mm.

use super::{Rays, ViewMap};

/// Rows solved abreast.
pub const LANES: usize = 8;

/// Largest change of the distance from the fold's ray per distance gone.
pub(super) const MOST_APPROACH: f64 = 2.5;

/// A row rests only where it may do so for this many columns: it starts again slowly.
const SHORTEST_REST: f64 = 8.0;

/// Steps before the safeguarded solution takes over: one is mostly enough, where a row crosses the fold two more.
const ROUNDS: usize = 3;

/// A point closer to the fold's ray than this (mm) may lie on either side of it.
const TOUCHES: f64 = 1e-6;

/// Rays of [`LANES`] neighbouring points.
pub type Lanes = Rays<LANES>;

/// [`LANES`] neighbouring rows of a grid in one plane.
#[derive(Debug)]
pub struct March<'a> {
    map: &'a ViewMap,
    /// First point of each row and the step along the rows, in the turned frame.
    x: [f64; LANES],
    y: [f64; LANES],
    step: (f64, f64),
    z: f64,
    spacing: f64,
    /// Distance from the regular rays beyond which a point's ray is not asked for.
    reach: f64,
    /// Column from which on each row is solved again.
    rests_until: [usize; LANES],
    /// The side, ±1, of the fold that each row's last point lay beyond; else 0.
    on_fold: [f64; LANES],
    /// Each row's last ray and its backward differences over the columns, of orders one to three: their sum is the cubic
    /// extrapolation to the next column.
    b: [[f64; LANES]; 4],
    s: [[f64; LANES]; 4],
    /// How many columns they stand on.
    known: usize,
}

/// Takes in the next value of a series whose last value and differences stand on `known` values.
#[inline(always)]
fn differ(series: &mut [[f64; LANES]; 4], next: &[f64; LANES], known: usize) {
    let [value, first, second, third] = series;
    for l in 0..LANES {
        let d1 = next[l] - value[l];
        let d2 = d1 - first[l];
        third[l] = if known > 2 { d2 - second[l] } else { 0.0 };
        second[l] = if known > 1 { d2 } else { 0.0 };
        first[l] = if known > 0 { d1 } else { 0.0 };
        value[l] = next[l];
    }
}

impl<'a> March<'a> {
    /// Rows whose first points are `(x, y[l], z)` and whose points lie `spacing` apart along x; tank frame, mm.
    /// Points farther than `reach` (mm, may be infinite) from every regular ray need no solution.
    pub fn new(map: &'a ViewMap, x: f64, y: &[f64; LANES], z: f64, spacing: f64, reach: f64) -> Self {
        let (mut px, mut py) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            (px[l], py[l]) = map.turned(x, y[l]);
        }
        let Lanes { b, s, .. } = map.axis_rays();
        Self {
            map,
            x: px,
            y: py,
            step: map.turned(spacing, 0.0),
            z,
            spacing,
            reach,
            rests_until: [0; LANES],
            on_fold: [0.0; LANES],
            b: [b, [0.0; LANES], [0.0; LANES], [0.0; LANES]],
            s: [s, [0.0; LANES], [0.0; LANES], [0.0; LANES]],
            known: 0,
        }
    }

    /// Passes over a column: the next one starts from the last ray known.
    #[inline(always)]
    pub fn rest(&mut self) {
        self.known = 0;
    }

    /// Rays of the points of column `i`, for the lanes that are `wanted`; the distance is infinite for the others
    /// and those known to lie beyond the reach. Columns follow each other.
    #[inline(always)]
    pub fn column(&mut self, i: usize, wanted: &[bool; LANES]) -> Lanes {
        if !(0..LANES).any(|l| wanted[l] & (i >= self.rests_until[l])) {
            // The columns' even steps end here.
            self.rest();
            return Lanes { b: self.b[0], s: self.s[0], distance: [f64::INFINITY; LANES], ..Lanes::ZERO };
        }
        let (dx, dy) = (self.step.0 * i as f64, self.step.1 * i as f64);
        let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
        let (mut b, mut s) = (self.b[0], self.s[0]);
        let going = if self.known > 0 { 1.0 } else { 0.0 };
        for l in 0..LANES {
            x[l] = self.x[l] + dx;
            y[l] = self.y[l] + dy;
            b[l] += going * (self.b[1][l] + self.b[2][l] + self.b[3][l]);
            s[l] += going * (self.s[1][l] + self.s[2][l] + self.s[3][l]);
        }
        let mut lanes = Lanes { b, s, ..Lanes::ZERO };
        let mut follows = self.glide(&x, &y, wanted, &mut lanes);
        if (0..LANES).any(|l| wanted[l] & !follows[l]) {
            (lanes.b, lanes.s) = (b, s);
            self.map.solve_rays(&x, &y, self.z, wanted, &mut lanes);
            follows = *wanted;
            for l in 0..LANES {
                let beyond = (lanes.distance[l] > TOUCHES) & self.map.fold.is_smooth();
                self.on_fold[l] = if beyond { lanes.b[l].signum() } else { 0.0 };
            }
        }
        for (l, follows) in follows.into_iter().enumerate() {
            if !follows {
                // Stays where it was.
                (lanes.b[l], lanes.s[l]) = (self.b[0][l], self.s[0][l]);
                for order in 1..4 {
                    (self.b[order][l], self.s[order][l]) = (0.0, 0.0);
                }
            }
        }
        differ(&mut self.b, &lanes.b, self.known);
        differ(&mut self.s, &lanes.s, self.known);
        self.known = (self.known + 1).min(3);
        for (l, &wanted) in wanted.iter().enumerate() {
            if !wanted {
                lanes.distance[l] = f64::INFINITY;
            } else if lanes.distance[l] > self.reach {
                let columns = (lanes.distance[l] - self.reach) / (MOST_APPROACH * self.spacing);
                if columns >= SHORTEST_REST {
                    self.rests_until[l] = i + columns as usize;
                }
            }
        }
        lanes
    }

    /// Plain Newton steps, up to [`ROUNDS`]; which rows have settled, well inside the folds or beyond one on its ray.
    #[inline(always)]
    fn glide(
        &mut self,
        x: &[f64; LANES],
        y: &[f64; LANES],
        wanted: &[bool; LANES],
        lanes: &mut Lanes,
    ) -> [bool; LANES] {
        let (low, high) = self.map.s_range;
        let (path, within_fold, z) = (self.map.path, self.map.within_fold, self.z);
        // Copies: what may alias keeps the loop from being vectorised.
        let (x, y) = (*x, *y);
        let mut settled = [false; LANES];
        for _ in 0..ROUNDS {
            let (mut b, s, side) = (lanes.b, lanes.s, self.on_fold);
            // Change of b along the fold with s.
            let mut slope = [0.0; LANES];
            if side != [0.0; LANES] {
                let mut s2 = [0.0; LANES];
                for l in 0..LANES {
                    s2[l] = s[l] * s[l];
                }
                let (ratios, slopes) = self.map.fold.ratios_and_slopes(&s2);
                for l in 0..LANES {
                    // b = ratio N₁.
                    let n1_squared = path.n_squared[0] - s2[l];
                    let n1 = n1_squared.sqrt();
                    b[l] = if side[l] == 0.0 { b[l] } else { side[l] * ratios[l] * n1 };
                    slope[l] = side[l] * s[l] * (2.0 * slopes[l] * n1_squared - ratios[l]) / n1;
                }
            }
            // Arrays by themselves stay in registers, a struct of them is copied about.
            let (mut next_b, mut next_s, mut density) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            let (mut wall_z, mut water_z, mut distance) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            let (mut strays, mut crosses) = ([0.0; LANES], [0.0; LANES]);
            for l in 0..LANES {
                let m = path.misses(b[l], s[l], x[l], y[l], z);
                // Along the fold s alone answers F₂; both kinds of step share a division.
                let (determinant, f2_along) = (m.f1_b * m.f2_s - m.f1_s * m.f2_b, m.f2_s + m.f2_b * slope[l]);
                let of_both = 1.0 / (determinant * f2_along);
                let inverse = f2_along * of_both;
                density[l] = inverse.abs();
                let s2 = s[l] * s[l];
                let n1_squared = path.n_squared[0] - s2;
                let fold = within_fold.ratio(s2);
                let (db_free, ds_free) =
                    ((m.f2 * m.f1_s - m.f1 * m.f2_s) * inverse, (m.f1 * m.f2_b - m.f2 * m.f1_b) * inverse);
                let along = -m.f2 * determinant * of_both;
                // Plain selects of numbers vectorise too.
                let db = if side[l] == 0.0 { db_free } else { slope[l] * along };
                let ds = if side[l] == 0.0 { ds_free } else { along };
                next_b[l] = b[l] + db;
                next_s[l] = s[l] + ds;
                wall_z[l] = m.outer_wall.moved(db, ds);
                water_z[l] = m.inner_wall.moved(db, ds);
                let beyond = side[l] * (m.f1 + m.f1_b * db + m.f1_s * ds);
                distance[l] = beyond.abs();
                let to_fold = fold * fold.abs() * n1_squared - next_b[l] * next_b[l];
                let room = if side[l] == 0.0 { to_fold } else { beyond - TOUCHES };
                let inside = (next_s[l] > low) & (next_s[l] < high);
                let small = (db.abs() < 3e-4) & (ds.abs() < 3e-6);
                crosses[l] = if room > 0.0 { 0.0 } else { 1.0 };
                strays[l] = if inside & small { crosses[l] } else { 1.0 };
            }
            (lanes.b, lanes.s, lanes.density) = (next_b, next_s, density);
            (lanes.wall_z, lanes.water_z, lanes.distance) = (wall_z, water_z, distance);
            settled = strays.map(|stray| stray == 0.0);
            if (0..LANES).all(|l| settled[l] | !wanted[l]) {
                break;
            }
            if self.map.fold.is_smooth() {
                for l in 0..LANES {
                    let other = if side[l] == 0.0 { 1f64.copysign(next_b[l]) } else { 0.0 };
                    self.on_fold[l] = if crosses[l] == 0.0 { side[l] } else { other };
                }
            }
        }
        settled
    }
}
