//! One view: a lens and where it stood when the photograph was taken.

use super::{Lens, Mat3, Vec3};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// A photograph's camera in the tank frame: `x_cam = R x_tank + t`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// The lens.
    pub lens: Lens,
    /// Rotation part of `cam_from_tank`.
    pub rotation: Mat3,
    /// Translation part of `cam_from_tank`, mm.
    pub translation_mm: Vec3,
}

impl View {
    /// The same view through a lens without distortion.
    pub fn ideal(&self) -> Self {
        Self { lens: self.lens.ideal(), ..self.clone() }
    }

    /// Camera centre in the tank frame, mm.
    pub fn centre_in_tank(&self) -> Vec3 {
        -(self.rotation.transpose() * self.translation_mm)
    }

    /// Unit direction in the tank frame of the ray that enters through pixel `(u, v)`.
    pub fn ray_in_tank(&self, u: f64, v: f64) -> Vec3 {
        let (x, y) = self.lens.direction(u, v);
        (self.rotation.transpose() * Vec3::new(x, y, 1.0)).normalize()
    }

    /// Pixel in which light arriving along `-direction_in_tank` is seen; `None` behind the camera.
    pub fn pixel_of_direction(&self, direction_in_tank: &Vec3) -> Option<(f64, f64)> {
        let d = self.rotation * direction_in_tank;
        (d.z > 1e-12).then(|| self.lens.pixel(d.x / d.z, d.y / d.z))
    }

    /// Whether the pixel lies on the picture (to half a pixel beyond the outer centres).
    pub fn holds(&self, u: f64, v: f64) -> bool {
        u >= -0.5 && v >= -0.5 && u <= self.lens.width as f64 - 0.5 && v <= self.lens.height as f64 - 0.5
    }

    /// Fails where a number is not finite or the rotation is not one (to 1e-6).
    ///
    /// # Errors
    /// Says which part is wrong and what it should be.
    pub fn check(&self) -> Result<()> {
        self.lens.check()?;
        if self.rotation.iter().chain(self.translation_mm.iter()).any(|x| !x.is_finite()) {
            return Err(Error::failed("pose holds a number that is not finite (NaN or infinity)"));
        }
        let drift = (self.rotation * self.rotation.transpose() - Mat3::identity()).abs().max();
        if drift > 1e-6 || self.rotation.determinant() < 0.0 {
            return Err(Error::failed(format!(
                "R is not a rotation: |R Rᵀ - 1| reaches {drift:.1e}, det R = {:.6}",
                self.rotation.determinant()
            ))
            .help("R must be orthonormal with determinant +1; write more digits, or check rows against columns"));
        }
        Ok(())
    }
}
