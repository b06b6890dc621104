//! Paths as a person would write them: without `.` and without steps into a folder and out again.

use std::fs;
use std::path::{Component, Path, PathBuf};

/// `x/../x/./photos` as `x/photos`; where a link makes that another place, only `.` goes.
pub(super) fn clean(path: &Path) -> PathBuf {
    let mut clean = PathBuf::new();
    for part in path.components() {
        let steps_back = part == Component::ParentDir
            && matches!(clean.components().next_back(), Some(Component::Normal(_) | Component::RootDir));
        match part {
            Component::CurDir => {}
            _ if steps_back => drop(clean.pop()),
            _ => clean.push(part),
        }
    }
    let or_here = |path: PathBuf| if path.as_os_str().is_empty() { PathBuf::from(".") } else { path };
    let clean = or_here(clean);
    match (fs::canonicalize(path), fs::canonicalize(&clean)) {
        (Ok(meant), Ok(found)) if meant != found => {
            or_here(path.components().filter(|p| *p != Component::CurDir).collect())
        }
        (Ok(_), Err(_)) => path.to_owned(),
        _ => clean,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detours_go() {
        for (path, want) in [
            ("x/../x/./photos", "x/photos"),
            ("./photos", "photos"),
            ("../x/./photos/", "../x/photos"),
            ("x/..", "."),
            (".", "."),
            ("", "."),
            ("../../a/b/../c", "../../a/c"),
            ("/a/./b/../../c", "/c"),
            ("/../a", "/a"),
        ] {
            assert_eq!(clean(Path::new(path)).to_str(), Some(want), "{path}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_are_not_misread() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::create_dir_all(at("far/away")).unwrap();
        fs::create_dir_all(at("far/photos")).unwrap();
        std::os::unix::fs::symlink(at("far/away"), at("near")).unwrap();
        let through = at("near/.././photos");
        assert_eq!(clean(&through), at("near/../photos"));
        fs::create_dir(at("photos")).unwrap();
        assert_eq!(clean(&through), at("near/../photos"));
        assert_eq!(clean(&at("far/away/../photos")), at("far/photos"));
    }
}
