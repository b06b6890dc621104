//! Light on its way from the water to the camera.
//!
//! # Conventions (fixed once, for the whole crate)
//!
//! - Lengths in mm, angles in radians.
//! - **Tank frame**: origin at the centre of the tank's top disc, z down along the axis, right-handed.
//! - **Camera frame**: x right, y down, z forward; `x_cam = R x_tank + t`. The centre of the top-left
//!   pixel is `(0, 0)`.
//! - Ray directions are unit vectors unless a name says otherwise.

pub mod camera;
pub mod distortion;
pub mod inverse;
pub mod lens;
pub mod tank;
pub mod trace;

pub use camera::View;
pub use distortion::{Distortion, Model};
pub use inverse::{Projection, ViewMap};
pub use lens::Lens;
pub use tank::{Index, Tank};
pub use trace::{WaterRay, trace};

/// A point or a vector in mm.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A rotation or another 3x3 matrix.
pub type Mat3 = nalgebra::Matrix3<f64>;

/// Rotation about the z axis, radians.
pub fn turn_about_z(angle: f64) -> Mat3 {
    nalgebra::Rotation3::from_axis_angle(&Vec3::z_axis(), angle).into_inner()
}
