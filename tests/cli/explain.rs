//! What would run and why, as a user reads it.

use super::capture::{Capture, rootvox};
use std::process::{Command, Stdio};

/// What `rootvox COMMAND study.toml ...` prints.
fn asked(capture: &Capture, command: &str, more: &[&str]) -> String {
    let output = rootvox().current_dir(capture.path("")).args([command, "study.toml"]).args(more).output();
    let output = output.expect("runs");
    assert!(output.status.success(), "{output:?}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn causes_come_first_with_old_and_new_value_and_what_they_cost() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    assert_eq!(asked(&capture, "status", &[]).lines().count(), 1, "nothing would run");

    let both = ["--set", "render.sampling=point", "--set", "extract.high=1.5"];
    let text = asked(&capture, "status", &both);
    let lines: Vec<&str> = text.lines().collect();
    assert!(
        lines[0].starts_with("render/* (6)") && lines[0].contains("`sampling`: \"footprint\" -> \"point\""),
        "{text}"
    );
    assert!(lines[0].contains(" s, ") && lines[0].contains("iB)"), "seconds and bytes: {text}");
    assert!(lines[1].starts_with("extract ") && lines[1].contains("`high`: 1.1 -> 1.5"), "{text}");
    assert!(lines[2].starts_with("merge ") && lines[2].contains("6 times input `render/*` has to be"), "{text}");
    assert!(lines.last().is_some_and(|l| l.starts_with("estimated: ") && l.contains(" s of work, ")), "{text}");
    let all = asked(&capture, "status", &[&both[..], &["--all"]].concat());
    assert!(all.contains("render/003.jpg ") && all.contains("photo/003.jpg "), "{all}");

    let json: serde_json::Value =
        serde_json::from_str(&asked(&capture, "status", &[&both[..], &["--json"]].concat())).expect("JSON");
    let extract = json.as_array().expect("nodes").iter().find(|node| node["label"] == "extract").expect("is planned");
    assert_eq!(extract["state"], "unknown", "its input may change too");
    let change = &extract["changes"][0];
    assert_eq!(
        (&change["name"], change["from"].as_f64().map(|from| from as f32), change["to"].as_f64()),
        (&"high".into(), Some(1.1f32), Some(1.5))
    );
    assert!(extract["seconds"].is_number() && extract["bytes"].is_number());
}

#[test]
fn why_leads_from_the_file_to_the_node() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    let mut picture = image::open(capture.path("images/002.jpg")).expect("a picture").to_rgb8();
    picture.put_pixel(80, 60, image::Rgb([255, 0, 0]));
    picture.save(capture.path("images/002.jpg")).expect("can save");
    let text = asked(&capture, "why", &["traits"]);
    let first = text.lines().next().expect("a line");
    assert!(first.starts_with("photo/002.jpg: content of `") && first.contains(" -> "), "{text}");
    assert!(text.lines().last().is_some_and(|line| line.starts_with("traits: ")), "{text}");
    let json: serde_json::Value = serde_json::from_str(&asked(&capture, "why", &["traits", "--json"])).expect("JSON");
    assert_eq!(json[0]["changes"][0]["kind"], "file");

    capture.run(&[]).assert().success();
    assert!(asked(&capture, "why", &["traits"]).starts_with("`traits` is in the store."));
}

/// As `rootvox status STUDY | head`.
#[cfg(unix)]
#[test]
fn a_reader_that_leaves_is_no_crash() {
    let capture = Capture::new();
    let mut child = Command::new(env!("CARGO_BIN_EXE_rootvox"))
        .current_dir(capture.path(""))
        .args(["status", "study.toml"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("ends");
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}
