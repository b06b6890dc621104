//! Cameras in other programs' formats, out and in again; a capture looked at before it is used.

use super::capture::{Capture, rootvox, stderr};
use std::fs;

fn done(capture: &Capture, more: &[&str]) {
    let output = capture.run(more).output().expect("runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

fn points(capture: &Capture) -> Vec<[f64; 3]> {
    let text = fs::read_to_string(capture.path("results/tiny/root_voxels.csv")).expect("can read");
    let row = |line: &str| {
        let mut numbers = line.split(',').map(|word| word.parse::<f64>().expect("a number"));
        std::array::from_fn(|_| numbers.next().expect("three numbers"))
    };
    text.lines().skip(1).map(row).collect()
}

#[test]
fn cameras_written_for_other_programs_give_the_same_roots() {
    let capture = Capture::new();
    done(&capture, &[]);
    let plain = points(&capture);
    assert!(plain.len() > 20);
    for (format, path) in
        [("colmap", "model"), ("transforms", "model/transforms.json"), ("cameras", "model/cameras.json")]
    {
        let (study, out) = (capture.path("study.toml"), capture.path("model"));
        let mut export = rootvox();
        export.args(["export", "cameras"]).arg(&study).args(["--format", format]).arg("-o").arg(&out);
        export.arg("--cache").arg(capture.path("cache"));
        assert!(export.output().expect("runs").status.success(), "{format}");
        done(&capture, &["--set", &format!("cameras.path={path}")]);
        // Rotations pass through quaternions or other axes, and differ in their last digits.
        let again = points(&capture);
        assert_eq!(plain.len(), again.len(), "{format}");
        for (a, b) in plain.iter().zip(&again) {
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.02), "{format}: {a:?} {b:?}");
        }
        fs::remove_dir_all(out).expect("can remove");
    }
}

#[test]
fn a_capture_is_looked_at() {
    let capture = Capture::new();
    let page = capture.path("check.html");
    let check = || {
        let mut command = rootvox();
        command.arg("check").arg(capture.path("")).arg("--page").arg(&page);
        command.output().expect("runs")
    };
    let output = check();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("FAULT  6 photographs only"), "{said}");
    let html = fs::read_to_string(&page).expect("can read");
    assert_eq!(html.matches("<figure").count(), 6, "{html}");
    fs::write(capture.path("images/003.jpg"), b"\xff\xd8 cut off").expect("can write");
    let said = String::from_utf8_lossy(&check().stdout).into_owned();
    assert!(said.contains("003.jpg"), "{said}");
    let mut nowhere = rootvox();
    nowhere.arg("check").arg(capture.path("nowhere")).arg("--page").arg(&page);
    assert!(stderr(&mut nowhere).contains("there is no folder"));
}
