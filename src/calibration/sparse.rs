//! What structure from motion or a camera file hands over: lenses, poses, points with their tracks.
//!
//! Pixels are those of the photographs as taken (distortion left in), the centre of the top-left pixel
//! at (0, 0). The frame is arbitrary in position, orientation and scale; [`SparseModel::normalised`]
//! makes it, and all orders, a function of the content alone.

use crate::error::{Error, Result};
use crate::optics::{Lens, Mat3, Vec3};
use serde::{Deserialize, Serialize};

/// A registered photograph: `x_cam = R x + t`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SparseView {
    /// Name of the photograph.
    pub file: String,
    /// Its lens.
    pub lens: Lens,
    /// Rotation of `cam_from_sfm`.
    #[serde(rename = "R")]
    pub rotation: Mat3,
    /// Translation of `cam_from_sfm`, in the model's unit.
    #[serde(rename = "t")]
    pub translation: Vec3,
}

/// A point as one photograph shows it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sighting {
    /// Index into [`SparseModel::views`].
    pub view: usize,
    /// Column, px.
    pub u: f64,
    /// Row, px.
    pub v: f64,
}

/// A reconstructed point and its track.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SparsePoint {
    /// Position in the model's frame.
    #[serde(rename = "xyz")]
    pub position: Vec3,
    /// Where it is seen; ordered by view.
    pub seen: Vec<Sighting>,
}

/// Result of structure from motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SparseModel {
    /// Registered photographs in capture order.
    pub views: Vec<SparseView>,
    /// Points.
    pub points: Vec<SparsePoint>,
}

impl SparseView {
    /// Camera centre in the model's frame.
    pub fn centre(&self) -> Vec3 {
        -(self.rotation.transpose() * self.translation)
    }
}

impl SparseModel {
    /// Fails on numbers that are not finite, matrices that are no rotations and sightings of no view.
    ///
    /// # Errors
    /// Names view or point.
    pub fn check(&self) -> Result<()> {
        for view in &self.views {
            view.lens.check().map_err(|e| e.at(format!("sparse model, `{}`", view.file)))?;
            let drift = (view.rotation * view.rotation.transpose() - Mat3::identity()).abs().max();
            if !view.translation.iter().all(|x| x.is_finite()) || drift.is_nan() || drift > 1e-6 {
                return Err(Error::failed(format!("sparse model: the pose of `{}` is no rigid motion", view.file)));
            }
        }
        for (k, p) in self.points.iter().enumerate() {
            let fine = p.position.iter().all(|x| x.is_finite())
                && p.seen.iter().all(|s| s.view < self.views.len() && s.u.is_finite() && s.v.is_finite());
            if !fine {
                return Err(Error::failed(format!("sparse model: point {k} or its track holds an impossible number")));
            }
        }
        Ok(())
    }

    /// The same model in a frame and an order that rest on its content alone: the first view's camera is
    /// the frame, the root mean square distance of the camera centres from their mean is 1, tracks are
    /// ordered by view and points by their tracks.
    #[must_use]
    pub fn normalised(mut self) -> Self {
        let Some(first) = self.views.first() else { return self };
        let (r0, c0) = (first.rotation, first.centre());
        let n = self.views.len() as f64;
        let mean = self.views.iter().map(SparseView::centre).sum::<Vec3>() / n;
        let size = (self.views.iter().map(|v| (v.centre() - mean).norm_squared()).sum::<f64>() / n).sqrt();
        let scale = if size > 0.0 { 1.0 / size } else { 1.0 };
        for view in &mut self.views {
            let centre = (r0 * (view.centre() - c0)) * scale;
            view.rotation *= r0.transpose();
            view.translation = -(view.rotation * centre);
        }
        for p in &mut self.points {
            p.position = (r0 * (p.position - c0)) * scale;
            p.seen.sort_by(|a, b| a.view.cmp(&b.view).then(a.u.total_cmp(&b.u)).then(a.v.total_cmp(&b.v)));
        }
        let track = |p: &SparsePoint| p.seen.iter().map(|s| (s.view, s.u, s.v)).collect::<Vec<_>>();
        self.points.sort_by(|a, b| {
            let (a, b) = (track(a), track(b));
            a.iter()
                .zip(&b)
                .map(|(x, y)| x.0.cmp(&y.0).then(x.1.total_cmp(&y.1)).then(x.2.total_cmp(&y.2)))
                .find(|o| o.is_ne())
                .unwrap_or(a.len().cmp(&b.len()))
        });
        self
    }

    /// The lens of all views.
    ///
    /// # Errors
    /// Where there is no view, or two lenses; both are named.
    pub fn one_lens(&self) -> Result<Lens> {
        let first = self.views.first().ok_or_else(|| Error::failed("there is no view"))?;
        match self.views.iter().find(|v| v.lens != first.lens) {
            None => Ok(first.lens),
            Some(other) => Err(Error::failed(format!(
                "`{}` and `{}` are taken through two lenses, but the tank is registered with one",
                first.file, other.file
            ))
            .help("give all cameras in the tank's frame (cameras.frame = \"tank\"): there each view may have its own lens")),
        }
    }

    /// Root mean square distance in px between where the points are seen and where they project; `None`
    /// without sightings in front of the cameras.
    pub fn reprojection_rms_px(&self) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0_usize);
        for p in &self.points {
            for s in &p.seen {
                let view = &self.views[s.view];
                let x = view.rotation * p.position + view.translation;
                if x.z > 0.0 {
                    let (u, v) = view.lens.pixel(x.x / x.z, x.y / x.z);
                    sum += (u - s.u).powi(2) + (v - s.v).powi(2);
                    count += 1;
                }
            }
        }
        (count > 0).then(|| (sum / count as f64).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Distortion;
    use nalgebra::Rotation3;

    fn model() -> SparseModel {
        let lens =
            Lens { width: 100, height: 80, focal_px: 90.0, cx: 49.5, cy: 39.5, distortion: Distortion::default() };
        let views: Vec<_> = (0..4)
            .map(|i| {
                let rotation = Rotation3::new(Vec3::new(0.1, 0.4 * f64::from(i), 0.0)).into_inner();
                SparseView { file: format!("{i}.jpg"), lens, rotation, translation: Vec3::new(0.1, 0.0, 5.0) }
            })
            .collect();
        let points = (0..5)
            .map(|k| {
                let position = Vec3::new(0.2 * f64::from(k), 0.1, -0.1 * f64::from(k));
                let seen = views
                    .iter()
                    .enumerate()
                    .map(|(view, w)| {
                        let x = w.rotation * position + w.translation;
                        let (u, v) = lens.pixel(x.x / x.z, x.y / x.z);
                        Sighting { view, u, v }
                    })
                    .collect();
                SparsePoint { position, seen }
            })
            .collect();
        SparseModel { views, points }
    }

    #[test]
    fn normalised_forgets_order_and_gauge_and_keeps_the_pictures() {
        let a = model();
        let mut b = model();
        let (turn, shift, scale) =
            (Rotation3::new(Vec3::new(0.3, -0.2, 0.9)).into_inner(), Vec3::new(1.0, 2.0, 3.0), 7.0);
        for v in &mut b.views {
            let centre = (turn * v.centre()) * scale + shift;
            v.rotation *= turn.transpose();
            v.translation = -(v.rotation * centre);
        }
        for p in &mut b.points {
            p.position = (turn * p.position) * scale + shift;
            p.seen.reverse();
        }
        b.points.reverse();
        assert!(b.reprojection_rms_px().unwrap() < 1e-9);
        let (a, b) = (a.normalised(), b.normalised());
        for (p, q) in a.points.iter().zip(&b.points) {
            assert!((p.position - q.position).norm() < 1e-12);
            assert_eq!(p.seen, q.seen);
        }
        assert!(b.reprojection_rms_px().unwrap() < 1e-9);
        b.check().unwrap();
    }
}
