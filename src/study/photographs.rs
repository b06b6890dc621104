//! Finds the photographs that `photos.images` names.

use super::inputs::Photos;
use crate::error::{Error, Result};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// What matches `photos.images`.
#[derive(Debug, Clone, Default)]
pub struct Found {
    /// The photographs, in capture order.
    pub paths: Vec<PathBuf>,
    /// Names of files that match but that no camera wrote (`is_dropping`).
    pub left_out: Vec<String>,
}

impl Found {
    /// What was left out, for people.
    pub fn note(&self) -> Option<String> {
        let first = self.left_out.first()?;
        Some(format!(
            "photos.images: {} left out that operating systems leave in folders, such as `{first}`",
            files(self.left_out.len())
        ))
    }
}

/// The photographs below `input_dir`.
///
/// # Errors
/// A pattern that is none, a folder that is missing, or no photograph found: then what is there instead.
pub(super) fn find(input_dir: &Path, photos: &Photos) -> Result<Found> {
    if !input_dir.is_dir() {
        return Err(Error::usage(format!("photos.dir: there is no folder `{}`", input_dir.display()))
            .help("name the folder of the capture: --set photos.dir=PATH"));
    }
    let images = either_case(&photos.images);
    let pattern = if Path::new(&images).is_absolute() {
        images
    } else {
        // The folder's own name is meant as it is written.
        format!("{}/{images}", glob::Pattern::escape(&input_dir.display().to_string()))
    };
    let matches = glob::glob(&pattern)
        .map_err(|e| Error::usage(format!("photos.images: `{}` is no pattern: {e}", photos.images)))?;
    let mut found = Found::default();
    for entry in matches {
        let path = entry.map_err(|e| Error::io("read", e.path(), e.error()))?;
        match path.file_name().map(|name| name.to_string_lossy().into_owned()) {
            Some(name) if is_dropping(&name) => found.left_out.push(name),
            _ if path.is_file() => found.paths.push(path),
            _ => {}
        }
    }
    if found.paths.is_empty() {
        return Err(nothing(input_dir, photos, &found.left_out));
    }
    found.paths.sort_by_key(|p| natural(&p.display().to_string()));
    Ok(found)
}

/// The photographs of a folder without a study: those of the most frequent format in it, or in its folder `images`.
///
/// # Errors
/// No photograph found: then what is there instead.
pub fn in_folder(folder: &Path) -> Result<Found> {
    let patterns = PICTURES.iter().flat_map(|ending| [format!("*.{ending}"), format!("images/*.{ending}")]);
    let found = patterns.filter_map(|images| find(folder, &Photos { images, ..Photos::default() }).ok());
    // Of equally many the first.
    found.reduce(|a, b| if b.paths.len() > a.paths.len() { b } else { a }).ok_or_else(|| {
        let (_, held) = holds(folder, &[]);
        Error::usage(format!("no photograph in `{}`: the folder holds {held}", folder.display()))
            .help(format!("name the folder of the photographs; they end in .{}", PICTURES.join(", .")))
    })
}

/// Whether a file of that name is something that an operating system left: `._DSC01.jpg`, `.DS_Store`, `Thumbs.db`.
fn is_dropping(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    name.starts_with('.') || ["thumbs.db", "ehthumbs.db", "desktop.ini"].contains(&lower.as_str())
}

/// The pattern with its ending in either case: `*.jpg` as `*.[jJ][pP][gG]`.
fn either_case(images: &str) -> String {
    let Some((stem, ending)) = images.rsplit_once('.') else { return images.to_owned() };
    if !ending.chars().all(|c| c.is_ascii_alphanumeric()) {
        return images.to_owned();
    }
    let either = |c: char| match c.is_ascii_alphabetic() {
        true => format!("[{}{}]", c.to_ascii_lowercase(), c.to_ascii_uppercase()),
        false => c.to_string(),
    };
    format!("{stem}.{}", ending.chars().map(either).collect::<String>())
}

/// Kinds of files that a message lists.
const MOST_KINDS: usize = 5;

/// Endings of pictures, in the order in which they are suggested where a folder holds as many of each.
const PICTURES: [&str; 6] = ["jpg", "jpeg", "tif", "tiff", "png", "webp"];

/// No photograph matches: says what the folder holds instead.
fn nothing(input_dir: &Path, photos: &Photos, left_out: &[String]) -> Error {
    let images = Path::new(&photos.images);
    let plain = |part: &Path| !part.to_string_lossy().contains(['*', '?', '[']);
    let below = images.ancestors().skip(1).find(|part| plain(part)).unwrap_or(Path::new(""));
    let folder = if below.as_os_str().is_empty() { input_dir.to_owned() } else { input_dir.join(below) };
    let none = format!("photos.images: no photograph matches `{}` in `{}`", photos.images, input_dir.display());
    let help = "give the pattern of your photographs, relative to photos.dir, such as";
    if !folder.is_dir() {
        return Error::usage(format!("{none}: there is no folder `{}`", folder.display()))
            .help(format!("{help} images = \"*.jpg\""));
    }
    let (kinds, held) = holds(&folder, left_out);
    let counted = |picture: &&str| -> usize {
        let same = |kind: &str| kind.strip_prefix('.').is_some_and(|k| k.eq_ignore_ascii_case(picture));
        kinds.iter().filter(|(kind, _)| same(kind)).map(|(_, count)| count).sum()
    };
    let likely = PICTURES.iter().rev().max_by_key(|picture| counted(picture)).unwrap_or(&"jpg");
    let likely = below.join(format!("*.{likely}"));
    Error::usage(format!("{none}: the folder `{}` holds {held}", folder.display()))
        .help(format!("{help} images = \"{}\"", likely.display()))
}

/// Endings in a folder with their counts, most frequent first, and the same for people.
fn holds(folder: &Path, left_out: &[String]) -> (Vec<(String, usize)>, String) {
    let (mut kinds, mut folders) = (BTreeMap::<String, usize>::new(), 0);
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let (name, path) = (entry.file_name().to_string_lossy().into_owned(), entry.path());
        if path.is_dir() {
            folders += usize::from(!name.starts_with('.'));
        } else if !is_dropping(&name) {
            let ending = path.extension().map(|e| format!(".{}", e.to_string_lossy()));
            *kinds.entry(ending.unwrap_or_else(|| "without ending".into())).or_default() += 1;
        }
    }
    let mut kinds: Vec<(String, usize)> = kinds.into_iter().collect();
    kinds.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let mut held: Vec<String> = kinds.iter().take(MOST_KINDS).map(|(kind, count)| format!("{count} {kind}")).collect();
    let more: usize = kinds.iter().skip(MOST_KINDS).map(|(_, count)| count).sum();
    held.extend((more > 0).then(|| format!("{more} others")));
    held.extend((folders > 0).then(|| if folders == 1 { "1 folder".into() } else { format!("{folders} folders") }));
    if held.is_empty() {
        held.push(if left_out.is_empty() { "nothing".into() } else { format!("nothing but `{}`", left_out[0]) });
    }
    (kinds, held.join(", "))
}

fn files(count: usize) -> String {
    if count == 1 { "1 file".into() } else { format!("{count} files") }
}

/// Key under which `img2` comes before `img10`.
fn natural(name: &str) -> Vec<(u64, String)> {
    let mut parts = Vec::new();
    let mut text = String::new();
    let mut chars = name.chars().peekable();
    while let Some(&c) = chars.peek() {
        if c.is_ascii_digit() {
            let mut number = 0_u64;
            while let Some(d) = chars.peek().and_then(|c| c.to_digit(10)) {
                number = number.saturating_mul(10).saturating_add(u64::from(d));
                chars.next();
            }
            parts.push((u64::MAX, std::mem::take(&mut text)));
            parts.push((number, String::new()));
        } else {
            text.push(c);
            chars.next();
        }
    }
    parts.push((u64::MAX, text));
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Finds `images` in a folder that holds empty files of those names, whose own name is a pattern too.
    fn find_in(names: &[&str], images: &str) -> Result<(Vec<String>, Found)> {
        let dir = tempfile::tempdir().unwrap();
        let dir = dir.path().join("plant [7]*");
        fs::create_dir_all(dir.join("images")).unwrap();
        names.iter().for_each(|name| fs::write(dir.join("images").join(name), "").unwrap());
        let found = find(&dir, &Photos { images: images.into(), ..Photos::default() })?;
        let names = found.paths.iter().map(|p| p.file_name().unwrap().to_string_lossy().into_owned()).collect();
        Ok((names, found))
    }

    #[test]
    fn a_folder_alone_gives_its_most_frequent_format() {
        let dir = tempfile::tempdir().unwrap();
        assert!(in_folder(dir.path()).unwrap_err().message.contains("holds nothing"));
        fs::create_dir(dir.path().join("images")).unwrap();
        for name in ["images/1.TIF", "images/2.tif", "sheet.jpg", "notes.txt"] {
            fs::write(dir.path().join(name), "").unwrap();
        }
        fs::write(dir.path().join("images/._1.TIF"), "").unwrap();
        let found = in_folder(dir.path()).unwrap();
        assert!(found.note().is_some_and(|note| note.contains("1 file left out")), "{found:?}");
        let names = found.paths;
        assert!(names.len() == 2 && names[0].ends_with("images/1.TIF"), "{names:?}");
    }

    #[test]
    fn numbers_sort_as_numbers() {
        let (names, _) = find_in(&["img10.jpg", "img2.jpg", "img1.jpg"], "images/*.jpg").unwrap();
        assert_eq!(names, ["img1.jpg", "img2.jpg", "img10.jpg"]);
    }

    #[test]
    fn endings_match_in_either_case() {
        for images in ["images/*.jpg", "images/*.JPG", "images/DSC*.Jpg", "*/DSC?.jpg"] {
            let (names, _) = find_in(&["DSC1.JPG", "DSC2.jpg", "DSC3.jpeg", "DSC4.png"], images).unwrap();
            assert_eq!(names, ["DSC1.JPG", "DSC2.jpg"], "{images}");
        }
        assert_eq!(find_in(&["DSC1.JPG", "dsc2.jpg"], "images/DSC*.jpg").unwrap().0, ["DSC1.JPG"]);
        assert_eq!(find_in(&["a.jp2", "a.JP2"], "images/*.jp2").unwrap().0.len(), 2);
    }

    #[test]
    fn droppings_of_operating_systems_are_left_out_and_told_of() {
        let names = ["DSC1.jpg", "._DSC1.jpg", ".DS_Store", "Thumbs.db", "DESKTOP.INI", "DSC2.jpg"];
        let (kept, found) = find_in(&names, "images/*").unwrap();
        assert_eq!((kept, found.left_out.len()), (vec!["DSC1.jpg".to_owned(), "DSC2.jpg".to_owned()], 4));
        assert!(found.note().unwrap().contains("4 files left out"), "{:?}", found.note());
        let (_, found) = find_in(&names, "images/*.jpg").unwrap();
        assert!(
            found
                .note()
                .unwrap()
                .ends_with("1 file left out that operating systems leave in folders, such as `._DSC1.jpg`")
        );
        assert_eq!(find_in(&["DSC1.jpg"], "images/*").unwrap().1.note(), None);
    }

    #[test]
    fn where_nothing_matches_it_says_what_is_there() {
        let said = |names: &[&str], images: &str| find_in(names, images).unwrap_err().to_string();
        let e = said(&["a.JPG", "b.JPG", "c.tif", "notes.txt", "d.JPG", "README", ".DS_Store"], "images/*.png");
        assert!(e.contains("images` holds 3 .JPG, 1 .tif, 1 .txt, 1 without ending"), "{e}");
        assert!(e.contains("images = \"images/*.jpg\""), "{e}");
        assert!(said(&[], "images/*.jpg").contains("images` holds nothing ("));
        assert!(said(&["._a.jpg"], "images/*.jpg").contains("holds nothing but `._a.jpg`"));
        assert!(said(&["a.jpg"], "*.jpg").contains("plant [7]*` holds 1 folder ("));
        assert!(said(&["a.jpg"], "photos/*.jpg").contains("there is no folder"));
        let many: Vec<String> = (0..9).map(|n| format!("a.{n}")).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        assert!(said(&many, "images/*.jpg").contains(", 4 others"));
    }
}
