//! cameras.bin, images.bin, points3D.bin: little-endian, counts before entries.

use super::{CAMERA_MODELS, Camera, Image, Model, Point};
use crate::error::{Error, Result};

/// A reading place in the bytes of one file.
struct Reader<'a> {
    name: &'a str,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8]> {
        let end = self.at.checked_add(n).filter(|&e| e <= self.bytes.len()).ok_or_else(|| self.cut_off())?;
        let part = &self.bytes[self.at..end];
        self.at = end;
        Ok(part)
    }

    fn cut_off(&self) -> Error {
        Error::failed(format!("`{}` ends too early, at byte {}", self.name, self.bytes.len()))
            .help("was the file cut off while being copied?")
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        self.take(N)?.try_into().map_err(|_| self.cut_off())
    }

    fn u8(&mut self) -> Result<u8> {
        Ok(self.array::<1>()?[0])
    }

    fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn u64(&mut self) -> Result<u64> {
        Ok(u64::from_le_bytes(self.array()?))
    }

    fn f64(&mut self) -> Result<f64> {
        Ok(f64::from_le_bytes(self.array()?))
    }

    /// A count of entries of at least `bytes_each`, refused where the file cannot hold them.
    fn count(&mut self, bytes_each: usize) -> Result<usize> {
        let n = self.u64()?;
        let room = (self.bytes.len() - self.at) / bytes_each;
        usize::try_from(n).ok().filter(|&n| n <= room).ok_or_else(|| {
            Error::failed(format!("`{}` announces {n} entries at byte {}, but has room for {room}", self.name, self.at))
                .help("is it a COLMAP binary file, and whole?")
        })
    }

    fn end(&self) -> Result<()> {
        if self.at == self.bytes.len() {
            return Ok(());
        }
        Err(Error::failed(format!("`{}` goes on after its last entry, at byte {}", self.name, self.at)))
    }
}

/// Reads the three binary files.
///
/// # Errors
/// Names file and byte where a file is cut off, too long, or holds an unknown camera model.
pub fn parse(cameras: &[u8], images: &[u8], points: &[u8]) -> Result<Model> {
    let mut model = Model::default();
    let mut r = Reader { name: "cameras.bin", bytes: cameras, at: 0 };
    for _ in 0..r.count(24)? {
        let (id, kind) = (r.u32()?, r.u32()?);
        let (width, height) = (r.u64()?, r.u64()?);
        let &(name, n) = CAMERA_MODELS
            .get(kind as usize)
            .ok_or_else(|| Error::failed(format!("`cameras.bin`: camera {id} has the unknown model number {kind}")))?;
        let params = (0..n).map(|_| r.f64()).collect::<Result<_>>()?;
        model.cameras.push(Camera { id, model: name.to_owned(), width, height, params });
    }
    r.end()?;

    let mut r = Reader { name: "images.bin", bytes: images, at: 0 };
    for _ in 0..r.count(73)? {
        let id = r.u32()?;
        let quaternion = [r.f64()?, r.f64()?, r.f64()?, r.f64()?];
        let translation = [r.f64()?, r.f64()?, r.f64()?];
        let camera_id = r.u32()?;
        let mut name = Vec::new();
        loop {
            match r.u8()? {
                0 => break,
                byte => name.push(byte),
            }
        }
        let name = String::from_utf8_lossy(&name).into_owned();
        let n = r.count(24)?;
        let keypoints = (0..n).map(|_| Ok((r.f64()?, r.f64()?, r.u64()?.cast_signed()))).collect::<Result<_>>()?;
        model.images.push(Image { id, quaternion, translation, camera_id, name, keypoints });
    }
    r.end()?;

    let mut r = Reader { name: "points3D.bin", bytes: points, at: 0 };
    for _ in 0..r.count(51)? {
        let id = r.u64()?;
        let position = [r.f64()?, r.f64()?, r.f64()?];
        r.take(3 + 8)?; // colour and error: not kept
        let n = r.count(8)?;
        let track = (0..n).map(|_| Ok((r.u32()?, r.u32()?))).collect::<Result<_>>()?;
        model.points.push(Point { id, position, track });
    }
    r.end()?;
    Ok(model)
}

/// The three binary files, (cameras, images, points3D); colours are black and errors 0.
///
/// # Errors
/// A camera model that COLMAP does not number.
pub fn write(model: &Model) -> Result<(Vec<u8>, Vec<u8>, Vec<u8>)> {
    let count = |n: usize| (n as u64).to_le_bytes();
    let mut cameras = count(model.cameras.len()).to_vec();
    for c in &model.cameras {
        let kind = CAMERA_MODELS.iter().position(|m| m.0 == c.model && m.1 == c.params.len()).ok_or_else(|| {
            Error::failed(format!("COLMAP has no camera model {} of {} parameters", c.model, c.params.len()))
        })?;
        cameras.extend(c.id.to_le_bytes());
        cameras.extend((kind as u32).to_le_bytes());
        cameras.extend(c.width.to_le_bytes());
        cameras.extend(c.height.to_le_bytes());
        cameras.extend(c.params.iter().flat_map(|x| x.to_le_bytes()));
    }
    let mut images = count(model.images.len()).to_vec();
    for i in &model.images {
        images.extend(i.id.to_le_bytes());
        images.extend(i.quaternion.iter().chain(&i.translation).flat_map(|x| x.to_le_bytes()));
        images.extend(i.camera_id.to_le_bytes());
        images.extend(i.name.bytes().chain([0]));
        images.extend(count(i.keypoints.len()));
        for (u, v, id) in &i.keypoints {
            images.extend(u.to_le_bytes());
            images.extend(v.to_le_bytes());
            images.extend(id.to_le_bytes());
        }
    }
    let mut points = count(model.points.len()).to_vec();
    for p in &model.points {
        points.extend(p.id.to_le_bytes());
        points.extend(p.position.iter().flat_map(|x| x.to_le_bytes()));
        points.extend([0; 3 + 8]);
        points.extend(count(p.track.len()));
        points.extend(p.track.iter().flat_map(|(a, b)| [a.to_le_bytes(), b.to_le_bytes()]).flatten());
    }
    Ok((cameras, images, points))
}
