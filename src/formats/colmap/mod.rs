//! COLMAP's sparse models (cameras, images and points3D, as text or binary files) and its command lines.
//!
//! COLMAP puts the *corner* of the top-left pixel at (0, 0), the crate its centre: half a pixel is taken
//! off on reading and added on writing, here and nowhere else. Poses are `x_cam = R x + t` in both;
//! quaternions are (w, x, y, z).

pub mod binary;
pub mod command;
mod lens;
pub mod text;

use crate::calibration::sparse::{Sighting, SparseModel, SparsePoint, SparseView};
use crate::error::{Error, Result};
use crate::optics::{Lens, Vec3};
use nalgebra::{Quaternion, UnitQuaternion};
use std::collections::{BTreeMap, BTreeSet};

/// A camera entry as the files give it.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// COLMAP's number of the camera.
    pub id: u32,
    /// Name of the camera model, `SIMPLE_RADIAL` for one.
    pub model: String,
    /// Picture width, px.
    pub width: u64,
    /// Picture height, px.
    pub height: u64,
    /// Parameters in the model's order.
    pub params: Vec<f64>,
}

/// An image entry as the files give it.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// COLMAP's number of the image.
    pub id: u32,
    /// Rotation of `cam_from_world` as (w, x, y, z).
    pub quaternion: [f64; 4],
    /// Translation of `cam_from_world`.
    pub translation: [f64; 3],
    /// Its camera.
    pub camera_id: u32,
    /// File name.
    pub name: String,
    /// Keypoints in COLMAP's pixels with the number of their 3-D point; -1 for none.
    pub keypoints: Vec<(f64, f64, i64)>,
}

/// A point entry as the files give it.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// COLMAP's number of the point.
    pub id: u64,
    /// Position.
    pub position: [f64; 3],
    /// (image id, index of the keypoint).
    pub track: Vec<(u32, u32)>,
}

/// A sparse model as the three files hold it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Model {
    /// cameras.
    pub cameras: Vec<Camera>,
    /// images.
    pub images: Vec<Image>,
    /// points3D.
    pub points: Vec<Point>,
}

/// Number of the camera models as the binary files write it, with the count of parameters.
const CAMERA_MODELS: [(&str, usize); 11] = [
    ("SIMPLE_PINHOLE", 3),
    ("PINHOLE", 4),
    ("SIMPLE_RADIAL", 4),
    ("RADIAL", 5),
    ("OPENCV", 8),
    ("OPENCV_FISHEYE", 8),
    ("FULL_OPENCV", 12),
    ("FOV", 5),
    ("SIMPLE_RADIAL_FISHEYE", 4),
    ("RADIAL_FISHEYE", 5),
    ("THIN_PRISM_FISHEYE", 12),
];

/// Turns COLMAP's entries into a sparse model in their frame; views are ordered by file name, or as in
/// `photos` where given (names that the model lacks are skipped: not registered).
///
/// # Errors
/// A lens that [`Lens`] cannot express, entries that refer to what is not there.
pub fn to_sparse(model: &Model, photos: Option<&[String]>) -> Result<SparseModel> {
    let mut images: Vec<&Image> = model.images.iter().collect();
    images.sort_by(|a, b| a.name.cmp(&b.name));
    if let Some(photos) = photos {
        let by_name: BTreeMap<&str, &Image> = images.iter().map(|i| (i.name.as_str(), *i)).collect();
        images = photos.iter().filter_map(|name| by_name.get(name.as_str()).copied()).collect();
    }
    if images.is_empty() {
        return Err(Error::failed("the COLMAP model holds none of the photographs")
            .help("the names in its images file must be those of the photographs"));
    }
    let index: BTreeMap<u32, usize> = images.iter().enumerate().map(|(k, i)| (i.id, k)).collect();
    let lenses = lenses(model, &images)?;
    let mut views = Vec::with_capacity(images.len());
    for image in &images {
        let q = Quaternion::new(image.quaternion[0], image.quaternion[1], image.quaternion[2], image.quaternion[3]);
        if !(q.norm() > 1e-9 && q.norm().is_finite()) {
            return Err(Error::failed(format!("COLMAP image `{}`: its quaternion is zero or not finite", image.name)));
        }
        let rotation = UnitQuaternion::from_quaternion(q).to_rotation_matrix().into_inner();
        let translation = Vec3::from(image.translation);
        views.push(SparseView { file: image.name.clone(), lens: lenses[&image.camera_id], rotation, translation });
    }
    let mut points = Vec::with_capacity(model.points.len());
    for p in &model.points {
        let mut seen = Vec::with_capacity(p.track.len());
        for (image_id, k) in &p.track {
            let Some(&view) = index.get(image_id) else { continue };
            let Some(&(u, v, _)) = images[view].keypoints.get(*k as usize) else {
                return Err(Error::failed(format!(
                    "COLMAP point {}: image {image_id} has no keypoint {k}; do the three files belong together?",
                    p.id
                )));
            };
            seen.push(Sighting { view, u: u - 0.5, v: v - 0.5 });
        }
        if seen.len() >= 2 {
            points.push(SparsePoint { position: Vec3::from(p.position), seen });
        }
    }
    let sparse = SparseModel { views, points };
    sparse.check()?;
    Ok(sparse)
}

/// COLMAP's name and parameters of the simplest of its camera models that holds the lens.
///
/// # Errors
/// A lens that COLMAP cannot express.
pub fn camera_model(lens: &Lens) -> Result<(String, Vec<f64>)> {
    lens::to_camera(lens, 1).map(|camera| (camera.model, camera.params))
}

/// COLMAP's entries of a sparse model: equal lenses are one camera, in the simplest model that holds them.
///
/// # Errors
/// A lens that COLMAP cannot express.
pub fn from_sparse(sparse: &SparseModel) -> Result<Model> {
    let mut lenses: Vec<Lens> = Vec::new();
    for view in &sparse.views {
        if !lenses.contains(&view.lens) {
            lenses.push(view.lens);
        }
    }
    let camera_of = |lens: &Lens| lenses.iter().position(|l| l == lens).map_or(0, |k| k as u32 + 1);
    let cameras = lenses.iter().map(|lens| lens::to_camera(lens, camera_of(lens))).collect::<Result<_>>()?;
    let mut images: Vec<Image> = sparse
        .views
        .iter()
        .enumerate()
        .map(|(k, v)| {
            let q = UnitQuaternion::from_matrix(&v.rotation);
            Image {
                id: k as u32 + 1,
                quaternion: [q.w, q.i, q.j, q.k],
                translation: v.translation.into(),
                camera_id: camera_of(&v.lens),
                name: v.file.clone(),
                keypoints: Vec::new(),
            }
        })
        .collect();
    let mut points = Vec::with_capacity(sparse.points.len());
    for (k, p) in sparse.points.iter().enumerate() {
        let id = k as u64 + 1;
        let mut track = Vec::with_capacity(p.seen.len());
        for s in &p.seen {
            let image = &mut images[s.view];
            track.push((image.id, image.keypoints.len() as u32));
            image.keypoints.push((s.u + 0.5, s.v + 0.5, id as i64));
        }
        points.push(Point { id, position: p.position.into(), track });
    }
    Ok(Model { cameras, images, points })
}

/// The lens of every camera that these images name.
fn lenses(model: &Model, images: &[&Image]) -> Result<BTreeMap<u32, Lens>> {
    let ids: BTreeSet<u32> = images.iter().map(|i| i.camera_id).collect();
    let lens = |id| {
        let camera =
            model.cameras.iter().find(|c| c.id == id).ok_or_else(|| {
                Error::failed(format!("the COLMAP model's images name camera {id}, which cameras lacks"))
            })?;
        Ok((id, lens::from_camera(camera)?))
    };
    ids.into_iter().map(lens).collect()
}

#[cfg(test)]
mod tests;
