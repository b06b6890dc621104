//! The commands that a result names: the one that made it, the one that makes it again.
//!
//! They hold no place of this machine: of an absolute path the last name alone is told.

use super::folder::LOCK;
use std::path::Path;

/// `rootvox run` of the study file with its overrides.
pub fn run(study: &Path, overrides: &[String]) -> String {
    let mut words = vec!["rootvox run".to_owned(), quoted(&portable(study))];
    for set in overrides {
        let (name, value) = set.split_once('=').unwrap_or((set, ""));
        let bare = Path::new(value.trim().trim_matches(['"', '\'']));
        let set = if bare.is_absolute() { format!("{name}={}", portable(bare)) } else { set.clone() };
        words.push(format!("--set {}", quoted(&set)));
    }
    words.join(" ")
}

/// `rootvox rerun` of the results of study `name` in `results_dir`.
pub fn rerun(results_dir: &Path, name: &str) -> String {
    let lock = results_dir.join(name).join(LOCK);
    let lock = if lock.is_absolute() { format!("{name}/{LOCK}") } else { lock.display().to_string() };
    format!("rootvox rerun {}", quoted(&lock))
}

fn portable(path: &Path) -> String {
    match path.file_name() {
        Some(last) if path.is_absolute() => format!(".../{}", last.to_string_lossy()),
        _ => path.display().to_string(),
    }
}

/// The word as a shell takes it.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./=:,+%@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_name_no_place_of_this_machine() {
        let set = ["photos.dir=/home/me/plant-7".to_owned(), "rootness.sigma=[1.0, 1.4]".to_owned()];
        assert_eq!(
            run(Path::new("pipelines/a.toml"), &set),
            "rootvox run pipelines/a.toml --set photos.dir=.../plant-7 --set 'rootness.sigma=[1.0, 1.4]'"
        );
        assert_eq!(run(Path::new("/tmp/my study.toml"), &[]), "rootvox run '.../my study.toml'");
        assert_eq!(rerun(Path::new("results"), "plant-7"), "rootvox rerun results/plant-7/study.lock");
        assert_eq!(rerun(Path::new("/data/results"), "plant-7"), "rootvox rerun plant-7/study.lock");
        assert_eq!(quoted("it's"), "'it'\\''s'");
    }
}
