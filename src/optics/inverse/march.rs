//! Rows of points at equal steps along x, [`LANES`] rows abreast: each column starts from the cubic
//! extrapolation of the columns before it, so that one Newton step is mostly enough.
//!
//! A step is taken as the solution where it is under 3e-4 in b (mm) and 3e-6 in s and stays inside the
//! innermost fold: what is left after it is of the order of its square over the tank's radius, 1e-9 mm. All
//! other columns go to the safeguarded solution.
//!
//! A row whose point lies beyond the fold by more than the `reach` asked for rests until it may be back within it:
//! the distance from the fold changes by less than [`MOST_APPROACH`] per mm. The other rows march on quickly.

use super::{Rays, ViewMap};

/// Rows solved abreast.
pub const LANES: usize = 8;

/// Largest change of the distance from the fold's ray per distance gone.
const MOST_APPROACH: f64 = 2.5;

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
    /// The last four columns' rays, latest first, and how many of them are in use.
    past: [([f64; LANES], [f64; LANES]); 4],
    known: usize,
}

/// Weights of the last columns in the extrapolation to the next one, by how many are known.
const EXTRAPOLATION: [[f64; 4]; 5] =
    [[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [2.0, -1.0, 0.0, 0.0], [3.0, -3.0, 1.0, 0.0], [4.0, -6.0, 4.0, -1.0]];

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
            past: [(b, s); 4],
            known: 0,
        }
    }

    /// Rays of the points of column `i`, for the lanes that are `wanted`; the distance is infinite for the others
    /// and those known to lie beyond the reach. Columns follow each other.
    #[inline(always)]
    pub fn column(&mut self, i: usize, wanted: &[bool; LANES]) -> Lanes {
        let awake: [bool; LANES] = std::array::from_fn(|l| wanted[l] & (i >= self.rests_until[l]));
        if !awake.contains(&true) {
            // The columns' even steps end here.
            self.known = 0;
            let (b, s) = self.past[0];
            return Lanes { b, s, distance: [f64::INFINITY; LANES], density: [0.0; LANES] };
        }
        let (dx, dy) = (self.step.0 * i as f64, self.step.1 * i as f64);
        let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
        let (mut b, mut s) = ([0.0; LANES], [0.0; LANES]);
        let w = EXTRAPOLATION[self.known];
        let [p0, p1, p2, p3] = &self.past;
        for l in 0..LANES {
            x[l] = self.x[l] + dx;
            y[l] = self.y[l] + dy;
            b[l] = w[0] * p0.0[l] + w[1] * p1.0[l] + w[2] * p2.0[l] + w[3] * p3.0[l];
            s[l] = w[0] * p0.1[l] + w[1] * p1.1[l] + w[2] * p2.1[l] + w[3] * p3.1[l];
        }
        let guess = Lanes { b, s, distance: [0.0; LANES], density: [0.0; LANES] };
        let mut lanes = guess;
        if !self.glide(&x, &y, &awake, &mut lanes) {
            lanes = guess;
            self.map.solve_rays(&x, &y, self.z, &awake, &mut lanes);
        }
        self.past = [(lanes.b, lanes.s), self.past[0], self.past[1], self.past[2]];
        self.known = (self.known + 1).min(4);
        for (l, awake) in awake.into_iter().enumerate() {
            if !awake {
                // Stays where it was; the weights of the extrapolation sum to one, so it starts again from there.
                let (b, s) = (self.past[1].0[l], self.past[1].1[l]);
                for past in &mut self.past {
                    (past.0[l], past.1[l]) = (b, s);
                }
                lanes.distance[l] = f64::INFINITY;
            } else if lanes.distance[l] > self.reach {
                let columns = (lanes.distance[l] - self.reach) / (MOST_APPROACH * self.spacing);
                self.rests_until[l] = i + (columns as usize).max(1);
            }
        }
        lanes
    }

    /// Up to two plain Newton steps; whether every wanted lane has settled well inside the folds.
    #[inline(always)]
    fn glide(&self, x: &[f64; LANES], y: &[f64; LANES], wanted: &[bool; LANES], lanes: &mut Lanes) -> bool {
        let (low, high) = self.map.s_range;
        let inside = self.map.innermost_fold * self.map.innermost_fold;
        for _ in 0..2 {
            let mut strays = [0.0; LANES];
            for l in 0..LANES {
                let (b, s) = (lanes.b[l], lanes.s[l]);
                let m = self.map.path.misses(b, s, x[l], y[l], self.z);
                let inverse = 1.0 / (m.f1_b * m.f2_s - m.f1_s * m.f2_b);
                lanes.density[l] = inverse.abs();
                let db = (m.f2 * m.f1_s - m.f1 * m.f2_s) * inverse;
                let ds = (m.f1 * m.f2_b - m.f2 * m.f1_b) * inverse;
                lanes.b[l] = b + db;
                lanes.s[l] = s + ds;
                let within = (lanes.b[l] * lanes.b[l] < inside * (self.map.path.n_squared[0] - s * s))
                    & (lanes.s[l] > low)
                    & (lanes.s[l] < high);
                let small = (db.abs() < 3e-4) & (ds.abs() < 3e-6);
                strays[l] = if within & small { 0.0 } else { 1.0 };
            }
            let strays = (0..LANES).filter(|&l| wanted[l]).map(|l| strays[l]).sum::<f64>();
            if strays == 0.0 {
                return true;
            }
        }
        false
    }
}
