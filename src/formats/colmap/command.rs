//! COLMAP's command lines for a ring of photographs taken with one lens.
//!
//! One camera, of model `SIMPLE_RADIAL` (the adjustment that follows frees more, with the tank to hold it) unless its lens is known,
//! one mask for all photographs, the processor instead of the graphics card, a fixed seed. Options that
//! were renamed between versions are chosen by what the installed program's own help names.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::path::Path;

/// Where a run finds and leaves its files.
#[derive(Debug, Clone, Copy)]
pub struct Places<'a> {
    /// The database.
    pub database: &'a Path,
    /// Folder of the photographs.
    pub images: &'a Path,
    /// Mask: white where features may be taken.
    pub mask: &'a Path,
    /// List of pairs to match.
    pub pairs: &'a Path,
    /// Folder for the sparse models.
    pub sparse: &'a Path,
    /// Folder of a model whose poses are known: points alone are then looked for.
    pub known: Option<&'a Path>,
}

impl Places<'_> {
    /// The steps by their names among COLMAP's commands.
    pub fn steps(&self) -> [&'static str; 3] {
        let last = if self.known.is_some() { "point_triangulator" } else { "mapper" };
        ["feature_extractor", "matches_importer", last]
    }
}

/// How features are found and how the program draws lots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Features {
    /// Affine regions with pooled scales: some times slower, but they match over 30 degrees and more.
    pub affine: bool,
    /// Seed.
    pub seed: u32,
}

/// The camera of all photographs.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Intrinsics {
    /// What the photographs' EXIF data say is where to begin.
    #[default]
    Exif,
    /// Focal length, centre (COLMAP's px) and radial distortion are where to begin.
    Begin([f64; 4]),
    /// Name and parameters of the camera model are known, and stay.
    Known(String, Vec<f64>),
}

/// Arguments of one of [`Places::steps`]; `help` is what `colmap STEP -h` prints.
pub fn arguments(step: &str, places: &Places, features: Features, lens: &Intrinsics, help: &str) -> Vec<OsString> {
    let mut args: Vec<OsString> = vec![step.into()];
    let mut add = |names: &[&str], value: OsString| {
        // Options that no known name fits are left at the program's default.
        if let Some(name) = names.iter().find(|n| help.contains(&format!("--{n} "))) {
            args.push(format!("--{name}").into());
            args.push(value);
        }
    };
    add(&["random_seed", "default_random_seed"], features.seed.to_string().into());
    add(&["database_path"], places.database.into());
    match step {
        "feature_extractor" => {
            add(&["image_path"], places.images.into());
            let (model, params) = match lens {
                Intrinsics::Exif => ("SIMPLE_RADIAL", &[][..]),
                Intrinsics::Begin(params) => ("SIMPLE_RADIAL", &params[..]),
                Intrinsics::Known(model, params) => (model.as_str(), &params[..]),
            };
            add(&["ImageReader.camera_model"], model.into());
            add(&["ImageReader.single_camera"], "1".into());
            if !params.is_empty() {
                let params: Vec<String> = params.iter().map(f64::to_string).collect();
                add(&["ImageReader.camera_params"], params.join(",").into());
            }
            add(&["ImageReader.camera_mask_path"], places.mask.into());
            add(&["FeatureExtraction.use_gpu", "SiftExtraction.use_gpu"], "0".into());
            if features.affine {
                add(&["SiftExtraction.estimate_affine_shape"], "1".into());
                add(&["SiftExtraction.domain_size_pooling"], "1".into());
            }
            if places.known.is_some() {
                // In order, so that the program numbers the images as the known model does.
                add(&["FeatureExtraction.num_threads", "SiftExtraction.num_threads"], "1".into());
            }
        }
        "matches_importer" => {
            add(&["match_list_path"], places.pairs.into());
            add(&["match_type"], "pairs".into());
            add(&["FeatureMatching.use_gpu", "SiftMatching.use_gpu"], "0".into());
        }
        _ => {
            add(&["image_path"], places.images.into());
            add(&["output_path"], places.sparse.into());
            if let Some(known) = places.known {
                add(&["input_path"], known.into());
            }
            if let Intrinsics::Known(..) = lens {
                for kind in ["focal_length", "principal_point", "extra_params"] {
                    let option = format!("Mapper.ba_refine_{kind}");
                    add(&[option.as_str()], "0".into());
                }
            }
            add(&["Mapper.min_model_size"], "3".into());
            add(&["Mapper.extract_colors"], "0".into());
        }
    }
    args
}

/// The list of pairs for `matches_importer`: each photograph with its next `neighbours` ones around the
/// ring; all pairs where `neighbours` is at least half their number.
pub fn pairs(names: &[String], neighbours: usize) -> String {
    let n = names.len();
    let mut list = String::new();
    for i in 0..n {
        for j in i + 1..n {
            let apart = (j - i).min(n + i - j);
            if apart <= neighbours {
                let _ = writeln!(list, "{} {}", names[i], names[j]);
            }
        }
    }
    list
}

/// The program's version, `COLMAP 3.8` for one, from what `colmap help` prints.
pub fn version(help: &str) -> Option<String> {
    let line = help.lines().find(|l| l.starts_with("COLMAP"))?;
    let mut words = line.split_whitespace();
    Some(format!("{} {}", words.next()?, words.next()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(args: &[OsString]) -> String {
        args.iter().map(|a| a.to_string_lossy()).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn options_take_the_names_that_the_program_knows() {
        let p = Path::new("x");
        let places = Places { database: p, images: p, mask: p, pairs: p, sparse: p, known: None };
        let plain = Features { affine: false, seed: 1 };
        let exif = Intrinsics::Exif;
        let old = "--database_path arg\n --SiftExtraction.use_gpu arg (=1)";
        let new = "--database_path arg\n --FeatureExtraction.use_gpu arg (=1)";
        assert!(
            text(&arguments("feature_extractor", &places, plain, &exif, old)).contains("--SiftExtraction.use_gpu 0")
        );
        assert!(
            text(&arguments("feature_extractor", &places, plain, &exif, new)).contains("--FeatureExtraction.use_gpu 0")
        );
        assert!(!text(&arguments("feature_extractor", &places, plain, &exif, old)).contains("mask"));
        let help = "--ImageReader.camera_params arg";
        let lens = Intrinsics::Begin([1500.5, 960.0, 640.0, 0.0]);
        let args = text(&arguments("feature_extractor", &places, plain, &lens, help));
        assert!(args.contains("--ImageReader.camera_params 1500.5,960,640,0"), "{args}");
        assert!(!text(&arguments("feature_extractor", &places, plain, &exif, help)).contains("camera_params"));
    }

    #[test]
    fn a_known_lens_stays() {
        let p = Path::new("x");
        let places = Places { database: p, images: p, mask: p, pairs: p, sparse: p, known: None };
        let plain = Features { affine: false, seed: 1 };
        let known = Intrinsics::Known("OPENCV_FISHEYE".into(), vec![500.0, 501.5]);
        let of = |step: &str, help: &str| text(&arguments(step, &places, plain, &known, help));
        let args = of("feature_extractor", "--ImageReader.camera_params arg\n--ImageReader.camera_model arg");
        assert!(args.contains("OPENCV_FISHEYE") && args.contains("500,501.5"), "{args}");
        let args = of("mapper", "--Mapper.ba_refine_focal_length arg\n--Mapper.ba_refine_extra_params arg");
        assert!(args.contains("focal_length 0") && args.contains("extra_params 0"), "{args}");
    }

    #[test]
    fn pairs_close_the_ring() {
        let names: Vec<String> = (0..5).map(|k| k.to_string()).collect();
        assert_eq!(pairs(&names, 1), "0 1\n0 4\n1 2\n2 3\n3 4\n");
        assert_eq!(pairs(&names, 9).lines().count(), 10);
    }

    #[test]
    fn the_version_is_read() {
        let help = "COLMAP 3.8 -- Structure-from-Motion and Multi-View Stereo\n";
        assert_eq!(version(help).as_deref(), Some("COLMAP 3.8"));
        assert_eq!(version("nothing"), None);
    }
}
