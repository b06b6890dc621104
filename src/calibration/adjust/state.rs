//! The adjustment's unknowns, observations and projections with their derivatives.

use super::axis::{AXIS, Axis, Play};
use crate::calibration::sparse::Sighting;
use crate::optics::lens::PixelSlopes;
use crate::optics::{Lens, Mat3, Vec3, View};
use nalgebra::{Matrix2, Matrix2x3, Rotation3, SMatrix, Vector2};

/// Unknowns common to all views: f, cx, cy, k1, k2, p1, p2, k3 and the printed surface's radius.
pub const COMMON: usize = 9;
/// Unknowns of a pose: ω, δt.
pub const POSE: usize = 6;

/// A line on the printed surface whose edge the photographs show.
#[derive(Debug, Clone, PartialEq)]
pub struct Contour {
    /// What it is, for messages: `rim`, `floor`.
    pub name: String,
    /// Radius, mm.
    pub radius_mm: f64,
    /// Which line.
    pub shape: Shape,
}

/// A line on a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A circle about the axis.
    Ring {
        /// Height in the tank frame, mm.
        z_mm: f64,
        /// On which side of the edge the outside lies: -1 above (towards z = 0 and beyond), +1 below.
        outward: f64,
    },
    /// Where the surface turns out of the camera's sight, between two heights.
    Side {
        /// The heights, mm.
        z_mm: [f64; 2],
        /// -1 where azimuths are smaller than the camera's, +1 where they are greater.
        turn: f64,
    },
}

impl Contour {
    /// Whether it is one of the sides.
    pub fn is_side(&self) -> bool {
        matches!(self.shape, Shape::Side { .. })
    }

    /// Azimuth of the side that a camera at `centre_mm` sees on a cylinder of that radius; `None` from inside.
    pub fn side_azimuth(turn: f64, radius_mm: f64, centre_mm: &Vec3) -> Option<f64> {
        let distance = centre_mm.x.hypot(centre_mm.y);
        (distance > radius_mm).then(|| centre_mm.y.atan2(centre_mm.x) + turn * (radius_mm / distance).acos())
    }
}

/// A point of a contour's edge as a photograph shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutlinePoint {
    /// Which view.
    pub view: usize,
    /// Which contour.
    pub contour: usize,
    /// Column, px.
    pub u: f64,
    /// Row, px.
    pub v: f64,
    /// Place along the contour, azimuth of a ring (radians) or height of a side (mm): a start, followed by the adjustment.
    pub along: f64,
}

/// What is observed.
#[derive(Debug, Clone)]
pub struct Network {
    /// Radius of the printed surface, mm.
    pub belt_radius_mm: f64,
    /// Tracks of the belt points.
    pub tracks: Vec<Vec<Sighting>>,
    /// How many sightings share their pixels, at least 1: so many count as one.
    pub redundancy: f64,
    /// The tank's outline.
    pub contours: Vec<Contour>,
    /// Points of its edges.
    pub outline: Vec<OutlinePoint>,
    /// Focal length from elsewhere (EXIF) with its standard deviation, px.
    pub focal_prior_px: Option<(f64, f64)>,
    /// Whether the lens stays as it is.
    pub holds_lens: bool,
}

impl Network {
    /// In how many places the contour is seen.
    pub fn seen(&self, contour: usize) -> usize {
        self.outline.iter().filter(|o| o.contour == contour).count()
    }

    /// The rings' heights, mm.
    pub fn ring_heights_mm(&self) -> Vec<f64> {
        let height = |contour: &Contour| match contour.shape {
            Shape::Ring { z_mm, .. } => Some(z_mm),
            Shape::Side { .. } => None,
        };
        self.contours.iter().filter_map(height).collect()
    }
}

/// Where the adjustment begins.
#[derive(Debug, Clone)]
pub struct Start {
    /// Views in the tank frame; all with one lens.
    pub views: Vec<View>,
    /// Belt points in the tank frame, one per track, mm.
    pub points_mm: Vec<Vec3>,
}

#[derive(Debug, Clone)]
pub(super) struct State {
    pub lens: Lens,
    /// By how much the printed surface's radius exceeds the given one, mm.
    pub thicker_mm: f64,
    pub poses: Vec<(Mat3, Vec3)>,
    /// (φ, z).
    pub points: Vec<(f64, f64)>,
    /// Place of each outline point along its contour.
    pub along: Vec<f64>,
    /// Edge offset per contour, px.
    pub offsets: Vec<f64>,
    /// The table's axis with the play that the prior allows it, once it is known.
    pub axis: Option<(Axis, Play)>,
}

/// A pixel with its derivatives by the common unknowns, the pose and the point in the tank frame; that by the
/// radius is 0 until [`Projection::rides_on_radius`] is called.
pub(super) struct Projection {
    pub pixel: Vector2<f64>,
    pub by_common: SMatrix<f64, 2, COMMON>,
    pub by_pose: SMatrix<f64, 2, POSE>,
    pub by_point: Matrix2x3<f64>,
}

impl State {
    pub fn size(&self) -> usize {
        self.pose_index(self.poses.len())
    }

    pub fn offset_index(&self, contour: usize) -> usize {
        COMMON + contour
    }

    pub fn axis_index(&self) -> usize {
        COMMON + self.offsets.len()
    }

    pub fn pose_index(&self, view: usize) -> usize {
        self.axis_index() + self.axis.map_or(0, |_| AXIS) + POSE * view
    }

    pub fn common_values(&self) -> [f64; COMMON] {
        let (l, d) = (&self.lens, &self.lens.distortion);
        [l.focal_px, l.cx, l.cy, d.k1, d.k2, d.p1, d.p2, d.k3, self.thicker_mm]
    }

    /// The state after a step of the eliminated system (points move separately).
    pub fn stepped(&self, step: &nalgebra::DVector<f64>) -> Self {
        let mut next = self.clone();
        let l = &mut next.lens;
        l.focal_px += step[0];
        l.cx += step[1];
        l.cy += step[2];
        l.distortion.k1 += step[3];
        l.distortion.k2 += step[4];
        l.distortion.p1 += step[5];
        l.distortion.p2 += step[6];
        l.distortion.k3 += step[7];
        next.thicker_mm += step[8];
        for (contour, offset) in next.offsets.iter_mut().enumerate() {
            *offset += step[COMMON + contour];
        }
        next.axis = self
            .axis
            .map(|(axis, play)| (axis.stepped(&step.fixed_rows::<AXIS>(self.axis_index()).into_owned()), play));
        for view in 0..self.poses.len() {
            let at = self.pose_index(view);
            let turn = Rotation3::new(Vec3::new(step[at], step[at + 1], step[at + 2])).into_inner();
            let (r, t) = self.poses[view];
            next.poses[view] = (turn * r, t + Vec3::new(step[at + 3], step[at + 4], step[at + 5]));
        }
        next
    }

    pub fn views(&self) -> Vec<View> {
        let view = |p: &(Mat3, Vec3)| {
            // Many small turns leave the matrix a little off; the nearest rotation is taken.
            let mut rotation = Rotation3::from_matrix_unchecked(p.0);
            rotation.renormalize();
            View { lens: self.lens, rotation: rotation.into_inner(), translation_mm: p.1 }
        };
        self.poses.iter().map(view).collect()
    }

    /// `None` behind the camera.
    pub fn project(&self, view: usize, point_mm: &Vec3) -> Option<Projection> {
        let (r, t) = &self.poses[view];
        let turned = r * point_mm;
        let c = turned + t;
        if c.z <= 1e-6 {
            return None;
        }
        let (x, y) = (c.x / c.z, c.y / c.z);
        let PixelSlopes { pixel, by_direction, u_by, v_by } = self.lens.pixel_with_derivatives(x, y);
        let by_camera = Matrix2::from_row_slice(&by_direction) * Matrix2x3::new(1.0, 0.0, -x, 0.0, 1.0, -y) / c.z;
        let mut by_common = SMatrix::<f64, 2, COMMON>::zeros();
        for (k, (u, v)) in u_by.into_iter().zip(v_by).enumerate() {
            by_common[(0, k)] = u;
            by_common[(1, k)] = v;
        }
        let mut by_pose = SMatrix::<f64, 2, POSE>::zeros();
        // exp(ω) turned = turned + ω x turned.
        by_pose.fixed_columns_mut::<3>(0).copy_from(&(-by_camera * turned.cross_matrix()));
        by_pose.fixed_columns_mut::<3>(3).copy_from(&by_camera);
        Some(Projection { pixel: Vector2::from(pixel), by_common, by_pose, by_point: by_camera * r })
    }
}

impl Projection {
    /// The point lies on the printed surface at that azimuth: it moves with the surface's radius.
    pub fn rides_on_radius(mut self, azimuth: f64) -> Self {
        let (s, c) = azimuth.sin_cos();
        let by_radius = self.by_point * Vec3::new(c, s, 0.0);
        self.by_common.set_column(COMMON - 1, &by_radius);
        self
    }
}

/// A point of a cylinder about the axis, with its derivatives by azimuth and height as columns.
pub(super) fn on_cylinder(radius_mm: f64, azimuth: f64, z_mm: f64) -> (Vec3, SMatrix<f64, 3, 2>) {
    let (s, c) = azimuth.sin_cos();
    let by =
        SMatrix::<f64, 3, 2>::from_columns(&[Vec3::new(-radius_mm * s, radius_mm * c, 0.0), Vec3::new(0.0, 0.0, 1.0)]);
    (Vec3::new(radius_mm * c, radius_mm * s, z_mm), by)
}
