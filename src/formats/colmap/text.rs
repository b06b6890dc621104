//! cameras.txt, images.txt, points3D.txt: one entry a line (two for an image), `#` opens a comment.

use super::{Camera, Image, Model, Point};
use crate::error::{Error, Result};
use std::fmt::Write as _;
use std::str::{FromStr, SplitWhitespace};

/// The words of one line, with its place for errors.
struct Line<'a> {
    file: &'a str,
    number: usize,
    words: SplitWhitespace<'a>,
}

impl Line<'_> {
    fn next<T: FromStr>(&mut self, what: &str) -> Result<T> {
        let (file, number) = (self.file, self.number);
        let word = self.words.next().ok_or_else(|| {
            Error::failed(format!("`{file}` line {number}: ends before its {what}"))
                .help("was the file cut off while being copied?")
        })?;
        word.parse().map_err(|_| Error::failed(format!("`{file}` line {number}: `{word}` is no {what}")))
    }

    fn numbers<const N: usize>(&mut self, what: &str) -> Result<[f64; N]> {
        let mut out = [0.0; N];
        for x in &mut out {
            *x = self.next(what)?;
        }
        Ok(out)
    }
}

fn lines<'a>(file: &'a str, text: &'a str) -> impl Iterator<Item = Line<'a>> {
    text.lines().enumerate().filter(|(_, l)| !l.starts_with('#')).map(move |(k, l)| Line {
        file,
        number: k + 1,
        words: l.split_whitespace(),
    })
}

/// Reads the three text files.
///
/// # Errors
/// Names file, line and word.
pub fn parse(cameras: &str, images: &str, points: &str) -> Result<Model> {
    let mut model = Model::default();
    for mut line in lines("cameras.txt", cameras).filter(|l| l.words.clone().next().is_some()) {
        let id = line.next("camera number")?;
        let name: String = line.next("camera model")?;
        let (width, height) = (line.next("width")?, line.next("height")?);
        let mut params = Vec::new();
        while line.words.clone().next().is_some() {
            params.push(line.next("parameter")?);
        }
        model.cameras.push(Camera { id, model: name, width, height, params });
    }
    // An image's second line may be empty, so that blank lines count once the first image is met.
    let mut rows = lines("images.txt", images).skip_while(|l| l.words.clone().next().is_none());
    while let Some(mut line) = rows.next() {
        if line.words.clone().next().is_none() {
            continue;
        }
        let id = line.next("image number")?;
        let quaternion = line.numbers("quaternion")?;
        let translation = line.numbers("translation")?;
        let camera_id = line.next("camera number")?;
        let name = line.words.clone().collect::<Vec<_>>().join(" ");
        if name.is_empty() {
            return Err(Error::failed(format!("`images.txt` line {}: ends before its file name", line.number)));
        }
        let mut keypoints = Vec::new();
        let mut line = rows.next().ok_or_else(|| {
            Error::failed(format!("`images.txt` line {}: the line with its keypoints is missing", line.number))
        })?;
        while line.words.clone().next().is_some() {
            keypoints.push((line.next("column")?, line.next("row")?, line.next("point number")?));
        }
        model.images.push(Image { id, quaternion, translation, camera_id, name, keypoints });
    }
    for mut line in lines("points3D.txt", points).filter(|l| l.words.clone().next().is_some()) {
        let id = line.next("point number")?;
        let position = line.numbers("position")?;
        let _: [f64; 4] = line.numbers("colour or error")?;
        let mut track = Vec::new();
        while line.words.clone().next().is_some() {
            track.push((line.next("image number")?, line.next("keypoint index")?));
        }
        model.points.push(Point { id, position, track });
    }
    Ok(model)
}

/// The three text files, (cameras, images, points3D); numbers read back to the last bit.
pub fn write(model: &Model) -> (String, String, String) {
    let mut cameras = String::from("# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n");
    for c in &model.cameras {
        let _ = write!(cameras, "{} {} {} {}", c.id, c.model, c.width, c.height);
        for p in &c.params {
            let _ = write!(cameras, " {p}");
        }
        cameras.push('\n');
    }
    let mut images = String::from("# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# (X, Y, POINT3D_ID)[]\n");
    for i in &model.images {
        let _ = write!(images, "{}", i.id);
        for x in i.quaternion.iter().chain(&i.translation) {
            let _ = write!(images, " {x}");
        }
        let _ = writeln!(images, " {} {}", i.camera_id, i.name);
        let words: Vec<String> = i.keypoints.iter().map(|(u, v, id)| format!("{u} {v} {id}")).collect();
        images.push_str(&words.join(" "));
        images.push('\n');
    }
    let mut points = String::from("# POINT3D_ID, X, Y, Z, R, G, B, ERROR, (IMAGE_ID, POINT2D_IDX)[]\n");
    for p in &model.points {
        let _ = write!(points, "{} {} {} {} 0 0 0 0", p.id, p.position[0], p.position[1], p.position[2]);
        for (a, b) in &p.track {
            let _ = write!(points, " {a} {b}");
        }
        points.push('\n');
    }
    (cameras, images, points)
}
