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
use std::collections::BTreeMap;

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
/// More than one camera, a lens that [`Lens`] cannot express, entries that refer to what is not there.
pub fn to_sparse(model: &Model, photos: Option<&[String]>) -> Result<SparseModel> {
    let lens = one_lens(model)?;
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
    let mut views = Vec::with_capacity(images.len());
    for image in &images {
        let q = Quaternion::new(image.quaternion[0], image.quaternion[1], image.quaternion[2], image.quaternion[3]);
        if !(q.norm() > 1e-9 && q.norm().is_finite()) {
            return Err(Error::failed(format!("COLMAP image `{}`: its quaternion is zero or not finite", image.name)));
        }
        let rotation = UnitQuaternion::from_quaternion(q).to_rotation_matrix().into_inner();
        views.push(SparseView { file: image.name.clone(), rotation, translation: Vec3::from(image.translation) });
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
    let sparse = SparseModel { lens, views, points };
    sparse.check()?;
    Ok(sparse)
}

/// COLMAP's entries of a sparse model; the lens becomes `OPENCV`, or `FULL_OPENCV` where k3 is not 0.
pub fn from_sparse(sparse: &SparseModel) -> Model {
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
                camera_id: 1,
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
    Model { cameras: vec![lens::to_camera(&sparse.lens)], images, points }
}

fn one_lens(model: &Model) -> Result<Lens> {
    let mut used: Vec<u32> = model.images.iter().map(|i| i.camera_id).collect();
    used.sort_unstable();
    used.dedup();
    let [id] = used[..] else {
        return Err(Error::failed(format!("the COLMAP model uses {} cameras", used.len()))
            .help("all photographs are taken with one lens: run COLMAP with --ImageReader.single_camera 1"));
    };
    let camera = model
        .cameras
        .iter()
        .find(|c| c.id == id)
        .ok_or_else(|| Error::failed(format!("the COLMAP model's images name camera {id}, which cameras lacks")))?;
    lens::from_camera(camera)
}

#[cfg(test)]
mod tests;
