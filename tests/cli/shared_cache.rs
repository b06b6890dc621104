//! Stores of packed nodes: pushed to, read through over HTTP, and hostile ones.

use super::capture::{Capture, rootvox};
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// How a server answers.
#[derive(Clone, Copy, PartialEq)]
enum Manner {
    Well,
    /// 403 to everything.
    Refusing,
    /// Closes in the middle of its tenth object, and never answers again.
    Dying,
}

/// A web server over a folder; it ends with the process.
fn serve(folder: &Path, manner: Manner) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = format!("http://{}", listener.local_addr().expect("an address"));
    let (folder, served) = (folder.to_owned(), Arc::new(AtomicUsize::new(0)));
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let (folder, served) = (folder.clone(), served.clone());
            std::thread::spawn(move || answer(stream, &folder, manner, &served));
        }
    });
    address
}

fn answer(mut stream: TcpStream, folder: &Path, manner: Manner, served: &AtomicUsize) {
    let Ok(copy) = stream.try_clone() else { return };
    let mut lines = BufReader::new(copy).lines();
    while let Some(Ok(request)) = lines.next() {
        while lines.next().is_some_and(|line| line.is_ok_and(|line| !line.is_empty())) {}
        let path = request.split(' ').nth(1).unwrap_or("/").trim_start_matches('/').to_owned();
        let body = fs::read(folder.join(path));
        let turn = served.fetch_add(usize::from(body.is_ok()), Ordering::SeqCst);
        let (status, body) = match (manner, body) {
            (Manner::Refusing, _) => ("403 Forbidden", Vec::new()),
            (_, Ok(body)) => ("200 OK", body),
            (_, Err(_)) => ("404 Not Found", Vec::new()),
        };
        if manner == Manner::Dying && turn > 9 {
            return;
        }
        let is_last = manner == Manner::Dying && turn == 9;
        let sent = if is_last { &body[..body.len() / 2] } else { &body };
        let head = format!("HTTP/1.1 {status}\r\nContent-Length: {}\r\n\r\n", body.len());
        if stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(sent)).is_err() || is_last {
            return;
        }
    }
}

/// A capture that was run and pushed into `pushed`, and its lock.
fn pushed() -> (Capture, String) {
    let capture = Capture::new();
    capture.run(&["--cache", "lab"]).assert().success();
    let lock = fs::read_to_string(capture.path("results/tiny/study.lock")).expect("is there");
    fs::remove_dir_all(capture.path("results")).expect("can remove");
    let text = push(&capture, "pushed");
    assert!(text.contains("; 0 were there"), "{text}");
    (capture, lock)
}

fn push(capture: &Capture, to: &str) -> String {
    let mut push = rootvox();
    let output =
        push.current_dir(capture.path("")).args(["cache", "push", "study.toml", to, "--cache", "lab"]).output();
    let output = output.expect("runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// What a run in an empty store over that upstream says; its results are right whatever that does.
fn run_over(capture: &Capture, lock: &str, upstream: &str) -> String {
    for folder in ["fresh", "results"] {
        let _ = fs::remove_dir_all(capture.path(folder));
    }
    let output = capture.run(&["--cache", "fresh", "--cache-upstream", upstream]).output().expect("runs");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{text}");
    assert_eq!(fs::read_to_string(capture.path("results/tiny/study.lock")).expect("is there"), lock, "{text}");
    let verdict = rootvox().current_dir(capture.path("")).args(["cache", "verify", "--cache", "fresh"]).output();
    assert!(verdict.expect("runs").status.success());
    assert_eq!(fs::read_dir(capture.path("fresh/v1/tmp")).expect("is there").count(), 0);
    text
}

/// The object of the stage's one node; of a stage whose values results read: those of others are not fetched.
fn object(capture: &Capture, stage: &str) -> PathBuf {
    let mut objects = fs::read_dir(capture.path(&format!("pushed/packed-v1/{stage}"))).expect("objects");
    objects.next().expect("an object").expect("entry").path()
}

#[test]
fn what_was_pushed_is_not_computed_again() {
    let (capture, lock) = pushed();
    assert!(push(&capture, "pushed").starts_with("0 nodes sent"), "a second push sends nothing");
    for upstream in [serve(&capture.path("pushed"), Manner::Well), "pushed".to_owned()] {
        let text = run_over(&capture, &lock, &upstream);
        assert_eq!(super::runs::computed(&text), 0, "{text}");
        assert!(!text.contains("warning"), "{text}");
    }
    // Pulled, all of it is at hand without the upstream, and is not fetched twice.
    let pull = || {
        let output = rootvox()
            .current_dir(capture.path(""))
            .args(["cache", "pull", "study.toml", "pushed", "--cache", "pulled"])
            .output()
            .expect("runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    assert!(!pull().starts_with("0 nodes") && pull().starts_with("0 nodes"));
    let output = capture.run(&["--cache", "pulled"]).output().expect("runs");
    assert_eq!(super::runs::computed(&String::from_utf8_lossy(&output.stderr)), 0);
}

#[test]
fn objects_that_are_damaged_cut_or_missing_are_computed_here() {
    let (capture, lock) = pushed();
    let address = serve(&capture.path("pushed"), Manner::Well);
    let volume = object(&capture, "volume");
    let sound = fs::read(&volume).expect("can read");
    let find = |word: &[u8]| sound.windows(word.len()).position(|w| w == word).expect("is in it") + 1;
    let flips = [sound.len() / 2, find(b"chunk_shape"), find(b"seconds")];
    for at in flips {
        let mut flipped = sound.clone();
        flipped[at] ^= 1;
        fs::write(&volume, &flipped).expect("can write");
        let text = run_over(&capture, &lock, &address);
        assert!(text.contains("is not used") && text.contains("computed here"), "bit at {at}: {text}");
        assert!(super::runs::computed(&text) > 0, "{text}");
    }
    for keep in [0, 100, 700, sound.len() / 3, sound.len() - 2000] {
        fs::write(&volume, &sound[..keep]).expect("can write");
        let text = run_over(&capture, &lock, &address);
        assert!(text.contains("is not used"), "cut to {keep}: {text}");
    }
    fs::remove_file(&volume).expect("can remove");
    let text = run_over(&capture, &lock, &address);
    assert!(super::runs::computed(&text) > 0 && !text.contains("warning"), "{text}");
}

#[test]
fn a_promise_of_ten_terabytes_and_names_that_lead_out_are_refused() {
    let (capture, lock) = pushed();
    let address = serve(&capture.path("pushed"), Manner::Well);
    let volume = object(&capture, "volume");
    let sound = fs::read(&volume).expect("can read");
    let text = String::from_utf8_lossy(&sound).into_owned();
    // The sizes in the manifest, digit for digit, so that the archive stays one.
    let at = text.find("\"bytes\": ").expect("a size") + 9;
    let digits = text[at..].find(|c: char| !c.is_ascii_digit()).expect("an end");
    let mut vast = sound.clone();
    vast[at..at + digits].copy_from_slice("9".repeat(digits).as_bytes());
    fs::write(&volume, &vast).expect("can write");
    let said = run_over(&capture, &lock, &address);
    assert!(said.contains("is not used"), "{said}");

    // A whole archive that promises 10 TB, made anew.
    let promise = |name: &str, bytes: &str| {
        let manifest = capture.path("lab/v1/nodes/volume");
        let folder = fs::read_dir(manifest).expect("nodes").next().expect("a node").expect("entry").path();
        let mut json: serde_json::Value =
            serde_json::from_slice(&fs::read(folder.join("manifest.json")).expect("can read")).expect("JSON");
        json["members"][0]["bytes"] = bytes.parse::<u64>().expect("a number").into();
        let mut archive = tar::Builder::new(Vec::new());
        let mut add = |name: &str, bytes: &[u8]| {
            let mut header = tar::Header::new_ustar();
            header.as_ustar_mut().expect("ustar").name[..name.len()].copy_from_slice(name.as_bytes());
            header.set_size(bytes.len() as u64);
            header.set_mode(0o644);
            header.set_entry_type(tar::EntryType::Regular);
            header.set_cksum();
            archive.append(&header, bytes).expect("can append");
        };
        add("manifest.json", json.to_string().as_bytes());
        add(name, b"evil");
        fs::write(&volume, archive.into_inner().expect("an archive")).expect("can write");
        run_over(&capture, &lock, &address)
    };
    let said = promise("volume.ome.zarr/zarr.json", "10000000000000");
    assert!(said.contains("its manifest promises 1000000"), "{said}");
    for name in ["../../evil", "/tmp/rootvox-evil", "volume.ome.zarr/../../evil", "manifest.json"] {
        let said = promise(name, "4");
        assert!(said.contains("does not belong into it"), "{name}: {said}");
    }
    assert!(!capture.path("evil").exists() && !Path::new("/tmp/rootvox-evil").exists());
}

#[test]
fn a_server_that_refuses_dies_or_is_not_there_costs_time_only() {
    let (capture, lock) = pushed();
    let text = run_over(&capture, &lock, &serve(&capture.path("pushed"), Manner::Refusing));
    assert!(text.contains("refuses our credentials"), "{text}");
    let text = run_over(&capture, &lock, &serve(&capture.path("pushed"), Manner::Dying));
    assert!(text.contains("warning"), "{text}");
    let gone = TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("an address");
    let text = run_over(&capture, &lock, &format!("http://{gone}"));
    assert!(text.contains("cannot be read"), "{text}");
    assert_eq!(text.matches("warning").count(), 1, "said once: {text}");
}

#[test]
fn what_is_packed_is_repeated_elsewhere() {
    let capture = Capture::new();
    let packed = |more: &[&str]| {
        let mut pack = rootvox();
        pack.current_dir(capture.path("")).args(["pack", "study.toml", "-o", "tiny.rootvox.zip"]).args(more);
        pack
    };
    let early = packed(&[]).output().expect("runs");
    assert_eq!(early.status.code(), Some(2), "nothing was run yet");
    capture.run(&[]).assert().success();
    let elsewhere = tempfile::tempdir().expect("a folder");
    for (more, again, is_cached) in [
        (&[][..], &[][..], false),
        (&["--nodes"], &[], true),
        (&["--no-photographs"], &["--photos-dir", "photographs"], false),
    ] {
        packed(more).assert().success();
        let folder = elsewhere.path().join(more.join(""));
        fs::create_dir_all(&folder).expect("can create");
        fs::copy(capture.path("tiny.rootvox.zip"), folder.join("tiny.rootvox.zip")).expect("can copy");
        if !again.is_empty() {
            let mut copied = std::process::Command::new("cp");
            copied.arg("-r").arg(capture.path("")).arg(folder.join("photographs"));
            assert!(copied.status().expect("cp runs").success());
        }
        let output = rootvox().current_dir(&folder).args(["rerun", "tiny.rootvox.zip"]).args(again).output();
        let output = output.expect("runs");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{more:?}: {said}");
        let verdict = String::from_utf8_lossy(&output.stdout).into_owned();
        let words: Vec<&str> = verdict.split(' ').collect();
        assert!(words[0] == words[2] && words[0].parse::<usize>().expect("a number") > 20, "{verdict}");
        assert_eq!(super::runs::computed(&said) == 0, is_cached, "{said}");
    }
}
