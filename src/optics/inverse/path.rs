//! A ray through air, wall and water in closed form.  Paper 2.3.1; Bouguer's invariant.
//!
//! The walls are cylinders about z, so along a ray two numbers survive every refraction: the axial
//! `s = n v_z` (the normals have no z part) and the moment about the axis `b = n (x v_y - y v_x)`. In the
//! frame turned about z in which the camera stands at `(R₀, 0, z₀)` they fix the whole ray. With
//! `N_i = √(n_i² - s²)` and `q_i = b / N_i` (the distance, in plan, at which the straight piece of the ray in
//! medium i passes the axis; i = air, wall, water) the piece in the water runs in plan in the direction
//!
//! ```text
//! α = π - asin(q₁/R₀) + asin(q₁/r) - asin(q₂/r) + asin(q₂/rᵢ) - asin(q₃/rᵢ)
//! ```
//!
//! at the distance `q₃` from the axis; e^{iα} is a product of complex numbers `√(1-k²) ± ik`, so nothing
//! but square roots and divisions is needed. A point `(x, y, z)` lies on the ray if both misses vanish:
//!
//! ```text
//! F₁ = x sin α - y cos α - q₃
//! F₂ = z₀ + s (l₁/N₁ + l₂/N₂ + l₃/N₃) - z         l₁ = √(R₀²-q₁²) - √(r²-q₁²)
//!                                                  l₂ = √(r²-q₂²) - √(rᵢ²-q₂²)
//!                                                  l₃ = x cos α + y sin α + √(rᵢ²-q₃²)
//! ```
//!
//! F₁ is the signed horizontal distance of the point from the ray (and its distance in space where
//! F₂ = 0); F₂ is the height of the ray over the point, where the ray passes it.
//!
//! The ray leaves the water again at azimuth `φ₃ = α - asin(q₃/rᵢ)` and height z₃. It is **regular** while
//! the determinant of (b, s) → (φ₃, z₃) keeps the sign it has on the axis, negative (paper 2.3.3).

/// The camera's place and the walls, in the camera's turned frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Path {
    /// Distance of the camera from the axis, mm.
    pub r0: f64,
    /// Height of the camera, mm (z of the tank frame).
    pub z0: f64,
    /// Outer radius, mm.
    pub outer: f64,
    /// Inner radius, mm.
    pub inner: f64,
    /// Squares of the indices of air, wall, water.
    pub n_squared: [f64; 3],
}

/// The misses of a ray at a point and their derivatives in (b, s).
#[derive(Debug, Clone, Copy)]
pub(super) struct Misses {
    pub f1: f64,
    pub f2: f64,
    pub f1_b: f64,
    pub f1_s: f64,
    pub f2_b: f64,
    pub f2_s: f64,
    /// F₂ with the point's foot on the ray moved back onto the ray's chord, where it lies beyond.
    pub f2_on_chord: f64,
    /// Where the ray meets the outer and the inner wall.
    pub outer_wall: Height,
    pub inner_wall: Height,
}

/// The height at which a ray meets a wall and its derivatives in (b, s).
#[derive(Debug, Clone, Copy)]
pub(super) struct Height {
    pub z: f64,
    pub z_b: f64,
    pub z_s: f64,
}

impl Height {
    /// The height of the ray at (b + db, s + ds), to second order.
    #[inline(always)]
    pub fn moved(&self, db: f64, ds: f64) -> f64 {
        self.z + db * self.z_b + ds * self.z_s
    }
}

impl Path {
    /// The misses of ray (b, s) at the point. Straight-line arithmetic, so that loops over lanes vectorise.
    #[inline(always)]
    pub fn misses(&self, b: f64, s: f64, x: f64, y: f64, z: f64) -> Misses {
        let s2 = s * s;
        // 1/N and q of the three media; reciprocals share their divisions, which cost most here.
        let n1 = (self.n_squared[0] - s2).sqrt();
        let n2 = (self.n_squared[1] - s2).sqrt();
        let n3 = (self.n_squared[2] - s2).sqrt();
        let n12 = n1 * n2;
        let of_all = 1.0 / (n12 * n3);
        let (m1, m2, m3) = (n2 * n3 * of_all, n1 * n3 * of_all, n12 * of_all);
        let (q1, q2, q3) = (b * m1, b * m2, b * m3);
        // Half chords, in plan, of the three straight pieces within each circle that they meet.
        let c1r0 = (self.r0 * self.r0 - q1 * q1).sqrt();
        let c1r = (self.outer * self.outer - q1 * q1).sqrt();
        let c2r = (self.outer * self.outer - q2 * q2).sqrt();
        let c2i = (self.inner * self.inner - q2 * q2).sqrt();
        let c3i = (self.inner * self.inner - q3 * q3).sqrt();
        // e^{iα}: the product of the five turns, each scaled by its radius.
        let (re, im) = (-c1r0, q1);
        let (re, im) = (re * c1r - im * q1, re * q1 + im * c1r);
        let (re, im) = (re * c2r + im * q2, im * c2r - re * q2);
        let (re, im) = (re * c2i - im * q2, re * q2 + im * c2i);
        let (re, im) = (re * c3i + im * q3, im * c3i - re * q3);
        let unit = 1.0 / (self.r0 * self.outer * self.outer * self.inner * self.inner);
        let (cos, sin) = (re * unit, im * unit);
        // dα/dq of each medium.
        let (c1, c2) = (c1r0 * c1r, c2r * c2i);
        let c12 = c1 * c2;
        let of_all = 1.0 / (c12 * c3i);
        let of_two = c3i * of_all;
        let a1 = (c1r0 - c1r) * (c2 * of_two);
        let a2 = (c2r - c2i) * (c1 * of_two);
        let a3 = -c12 * of_all;
        let (m1c, m2c, m3c) = (m1 * m1 * m1, m2 * m2 * m2, m3 * m3 * m3);
        let alpha_b = a1 * m1 + a2 * m2 + a3 * m3;
        let alpha_s = s * b * (a1 * m1c + a2 * m2c + a3 * m3c);
        // The point along and across the ray, in plan.
        let along = x * cos + y * sin;
        let across = x * sin - y * cos;
        let (l1, l2, l3) = (c1r0 - c1r, c2r - c2i, along + c3i);
        let (in_air, in_wall) = (l1 * m1, l2 * m2);
        let reach = in_air + in_wall + l3 * m3;
        let outer_wall = Height {
            z: self.z0 + s * in_air,
            z_b: s * (q1 * a1 * m1 * m1),
            z_s: in_air + s2 * ((l1 + q1 * q1 * a1) * m1c),
        };
        let inner_wall = Height {
            z: outer_wall.z + s * in_wall,
            z_b: outer_wall.z_b + s * (q2 * a2 * m2 * m2),
            z_s: outer_wall.z_s + in_wall + s2 * ((l2 + q2 * q2 * a2) * m2c),
        };
        Misses {
            f1: across - q3,
            f2: self.z0 + s * reach - z,
            f1_b: along * alpha_b - m3,
            f1_s: along * alpha_s - q3 * s * m3 * m3,
            f2_b: inner_wall.z_b + s * (q3 * a3 * m3 * m3 - across * alpha_b * m3),
            f2_s: inner_wall.z_s + l3 * m3 + s2 * ((l3 + q3 * q3 * a3) * m3c) - s * across * alpha_s * m3,
            f2_on_chord: self.z0 + s * (reach - (along - along.max(-c3i).min(c3i)) * m3) - z,
            outer_wall,
            inner_wall,
        }
    }

    /// Heights at which ray (b, s) meets the outer and the inner wall, mm.
    #[inline(always)]
    pub fn entry_heights(&self, b: f64, s: f64) -> (f64, f64) {
        let m1 = 1.0 / (self.n_squared[0] - s * s).sqrt();
        let m2 = 1.0 / (self.n_squared[1] - s * s).sqrt();
        let (q1, q2) = (b * m1, b * m2);
        let l1 = (self.r0 * self.r0 - q1 * q1).sqrt() - (self.outer * self.outer - q1 * q1).sqrt();
        let l2 = (self.outer * self.outer - q2 * q2).sqrt() - (self.inner * self.inner - q2 * q2).sqrt();
        let z1 = self.z0 + s * l1 * m1;
        (z1, z1 + s * l2 * m2)
    }

    /// Largest |b| with which a ray of this s gets into the water: beyond it the ray misses a wall or is
    /// reflected totally. `s²` must be under every squared index.
    pub fn largest_moment(&self, s: f64) -> f64 {
        let [n1, n2, n3] = self.n_squared.map(|n2| (n2 - s * s).sqrt());
        (self.outer * n1.min(n2)).min(self.inner * n2.min(n3))
    }

    /// Determinant of (b, s) → (φ₃, z₃); negative on regular rays.
    pub fn exit_determinant(&self, b: f64, s: f64) -> f64 {
        let m = self.n_squared.map(|n2| 1.0 / (n2 - s * s).sqrt());
        let q = m.map(|m| b * m);
        let half_chord = |radius: f64, q: f64| (radius * radius - q * q).sqrt();
        let (c1r0, c1r) = (half_chord(self.r0, q[0]), half_chord(self.outer, q[0]));
        let (c2r, c2i) = (half_chord(self.outer, q[1]), half_chord(self.inner, q[1]));
        let c3i = half_chord(self.inner, q[2]);
        let l = [c1r0 - c1r, c2r - c2i, 2.0 * c3i];
        let a = [1.0 / c1r - 1.0 / c1r0, 1.0 / c2i - 1.0 / c2r, -2.0 / c3i];
        let sum = |f: &dyn Fn(usize) -> f64| f(0) + f(1) + f(2);
        let phi_b = sum(&|i| a[i] * m[i]);
        let phi_s = s * b * sum(&|i| a[i] * m[i].powi(3));
        let z_b = s * sum(&|i| q[i] * a[i] * m[i] * m[i]);
        let z_s = sum(&|i| l[i] * m[i]) + s * s * sum(&|i| (l[i] + q[i] * q[i] * a[i]) * m[i].powi(3));
        phi_b * z_s - phi_s * z_b
    }
}
