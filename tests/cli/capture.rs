//! A tiny capture, photographed once by the program itself, and copies of it to spoil.

use assert_cmd::Command;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use tempfile::TempDir;

/// The study that the capture is made from; small enough for a second.
const SIMULATED: &str = include_str!("../data/tiny.toml");

/// A study over a folder of the form that `rootvox simulate` writes.
const FROM_FILES: &str = r#"
[study]
name = "tiny"
[photos]
images = "images/*.jpg"
[cameras]
path = "cameras.json"
[tank]
file = "tank.json"
[grid]
spacing = 1.0
depth = 60.0
"#;

/// The program, with nothing of the caller's environment that could change it.
pub fn rootvox() -> Command {
    let mut command = Command::cargo_bin("rootvox").expect("the program is built");
    command.env_remove("ROOTVOX_CACHE").env("RUST_BACKTRACE", "0");
    command
}

fn original() -> &'static Path {
    static CAPTURE: OnceLock<TempDir> = OnceLock::new();
    let folder = CAPTURE.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let study = folder.path().join("simulated.toml");
        fs::write(&study, SIMULATED).expect("can write");
        rootvox()
            .current_dir(folder.path())
            .args(["simulate", "simulated.toml", "--out", "capture"])
            .assert()
            .success();
        folder
    });
    folder.path()
}

/// A folder of its own with a copy of the capture and a study over it.
pub struct Capture {
    folder: TempDir,
}

impl Capture {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let from = original().join("capture");
        fs::create_dir(folder.path().join("images")).expect("can create");
        for name in ["cameras.json", "tank.json", "roots.json"] {
            fs::copy(from.join(name), folder.path().join(name)).expect("can copy");
        }
        for entry in fs::read_dir(from.join("images")).expect("images") {
            let path = entry.expect("entry").path();
            fs::copy(&path, folder.path().join("images").join(path.file_name().expect("name"))).expect("can copy");
        }
        fs::write(folder.path().join("study.toml"), FROM_FILES).expect("can write");
        Self { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `rootvox run study.toml` with more arguments.
    pub fn run(&self, more: &[&str]) -> Command {
        let mut command = rootvox();
        command.current_dir(self.folder.path()).args(["run", "study.toml"]).args(more);
        command
    }

    /// Replaces text in a file of the capture.
    pub fn edit(&self, name: &str, from: &str, to: &str) {
        let path = self.path(name);
        let text = fs::read_to_string(&path).expect("can read");
        assert!(text.contains(from), "`{name}` holds no `{from}`");
        fs::write(&path, text.replacen(from, to, 1)).expect("can write");
    }
}

/// What a command wrote to stderr.
pub fn stderr(command: &mut Command) -> String {
    String::from_utf8_lossy(&command.output().expect("runs").stderr).into_owned()
}
