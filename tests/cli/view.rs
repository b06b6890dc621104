//! `rootvox view`: who is served, what a change shows, what is written, and how it ends.

use super::capture::{Capture, rootvox};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Long enough for a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// A running `rootvox view study.toml`.
struct View {
    child: Child,
    /// `127.0.0.1:PORT`.
    host: String,
    token: String,
}

impl View {
    fn new(capture: &Capture, more: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_rootvox"))
            .current_dir(capture.path(""))
            .env_remove("ROOTVOX_CACHE")
            .args(["view", "study.toml", "--no-open"])
            .args(more)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("starts");
        let mut line = String::new();
        BufReader::new(child.stdout.take().expect("stdout")).read_line(&mut line).expect("an address");
        let rest = line.trim().strip_prefix("http://").unwrap_or_else(|| panic!("no address: {line}"));
        let (host, token) = rest.split_once('/').expect("a token");
        Self { child, host: host.to_owned(), token: token.trim_matches('/').to_owned() }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).expect("connects");
        stream.set_read_timeout(Some(PATIENCE)).expect("can be set");
        stream
    }

    /// Sends a request as it stands and hands back the whole answer.
    fn raw(&self, request: &str) -> String {
        let mut stream = self.connect();
        stream.write_all(request.as_bytes()).expect("can write");
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    fn get(&self, path: &str, more: &str) -> String {
        self.raw(&format!("GET {path} HTTP/1.1\r\nHost: {}\r\n{more}Connection: close\r\n\r\n", self.host))
    }

    fn post(&self, what: &str, body: &str, more: &str) -> String {
        self.raw(&format!(
            "POST /{}/{what} HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\n{more}Connection: close\r\n\r\n{body}",
            self.token,
            self.host,
            body.len()
        ))
    }

    fn events(&self) -> Events {
        let mut stream = self.connect();
        let request = format!("GET /{}/events HTTP/1.1\r\nHost: {}\r\n\r\n", self.token, self.host);
        stream.write_all(request.as_bytes()).expect("can write");
        Events { lines: BufReader::new(stream) }
    }

    #[cfg(unix)]
    fn interrupt(mut self) -> Option<i32> {
        let killed = Command::new("kill").args(["-INT", &self.child.id().to_string()]).status().expect("kill");
        assert!(killed.success());
        let status = self.child.wait().expect("ends");
        status.code()
    }
}

impl Drop for View {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

struct Events {
    lines: BufReader<TcpStream>,
}

impl Events {
    /// The next event of that kind whose text holds `what`.
    fn until(&mut self, kind: &str, what: &str) -> serde_json::Value {
        let begun = Instant::now();
        let mut is_kind = false;
        let mut line = String::new();
        while begun.elapsed() < PATIENCE {
            line.clear();
            assert!(self.lines.read_line(&mut line).expect("a line") > 0, "the stream ended before `{kind}`");
            if let Some(name) = line.strip_prefix("event: ") {
                is_kind = name.trim() == kind;
            }
            if let Some(text) = line.strip_prefix("data: ").filter(|text| is_kind && text.contains(what)) {
                return serde_json::from_str(text).expect("JSON");
            }
        }
        panic!("no `{kind}` with {what} came");
    }

    /// The turns of which `kind` is told from now on, up to the `last` whose end is told.
    fn turns(&mut self, kind: &str, last: u64) -> Vec<u64> {
        let begun = Instant::now();
        let (mut turns, mut now, mut line) = (Vec::new(), String::new(), String::new());
        while begun.elapsed() < PATIENCE {
            line.clear();
            assert!(self.lines.read_line(&mut line).expect("a line") > 0, "the stream ended before turn {last}");
            if let Some(name) = line.strip_prefix("event: ") {
                now = name.trim().to_owned();
            }
            let Some(text) = line.strip_prefix("data: ") else { continue };
            let number = text.split("\"turn\":").nth(1).and_then(|rest| rest.split([',', '}']).next()?.parse().ok());
            turns.extend(number.filter(|_| now == kind));
            if now == "ended" && number == Some(last) {
                return turns;
            }
        }
        panic!("turn {last} did not end");
    }
}

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap_or(answer)
}

fn turn(answer: &str) -> u64 {
    let body = answer.split("\r\n\r\n").nth(1).unwrap_or_default();
    let value: serde_json::Value = serde_json::from_str(body).unwrap_or_else(|_| panic!("no JSON: {answer}"));
    value["turn"].as_u64().unwrap_or_else(|| panic!("no turn: {answer}"))
}

#[test]
fn only_who_knows_the_token_is_served_and_only_from_here() {
    let capture = Capture::new();
    let view = View::new(&capture, &[]);
    let home = format!("/{}/", view.token);
    let page = view.get(&home, "");
    assert_eq!(status(&page), "200");
    let policy = page.lines().find(|l| l.starts_with("content-security-policy")).expect("a policy");
    let nonce = policy.split("'nonce-").nth(1).and_then(|rest| rest.split('\'').next()).expect("a nonce");
    assert!(page.contains(&format!("<script nonce=\"{nonce}\">")) && policy.contains("connect-src 'self'"), "{policy}");
    assert!(!view.get(&home, "").contains(nonce), "a nonce is used twice");

    for (name, path, more) in [
        ("no token", "/", ""),
        ("a wrong token", "/0123456789abcdef/", ""),
        ("a part of the token", &home[..20], ""),
        ("a foreign page", &home, "Origin: http://evil.example\r\n"),
        ("a page of nowhere", &home, "Origin: null\r\n"),
        ("another port", &home, "Origin: http://127.0.0.1:1\r\n"),
        ("a way around", "/../../etc/passwd", ""),
    ] {
        assert_eq!(status(&view.get(path, more)), "403", "{name}");
    }
    for host in ["evil.example", "evil.example:80", "127.0.0.1.evil.example", ""] {
        let answer = view.raw(&format!("GET {home} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"));
        assert_eq!(status(&answer), "403", "{host}");
    }
    for what in ["change", "keep", "correct", "undo"] {
        assert_eq!(status(&view.post(what, "{}", "Origin: http://evil.example\r\n")), "403", "{what}");
    }

    // With the token no path leads to a file.
    for path in [
        "../study.toml",
        "..%2fstudy.toml",
        "%2e%2e/study.toml",
        "overlay/..%2f..%2fstudy.toml",
        "study.toml",
        "overlay/99",
    ] {
        let answer = view.get(&format!("{home}{path}"), "");
        assert!(["400", "404", "422"].contains(&status(&answer)) && !answer.contains("[photos]"), "{path}: {answer}");
    }
    let through = view.get(&format!("/{}/../../../../etc/passwd", view.token), "");
    assert!(status(&through) == "404" && !through.contains("root:"), "{through}");

    // Settings that the panel does not have.
    let answer = view.post("change", r#"{"photos.dir": "/etc"}"#, "");
    assert!(status(&answer) == "422" && answer.contains("`photos.dir` cannot be set here"), "{answer}");
    let form = view.raw(&format!(
        "POST {home}change HTTP/1.1\r\nHost: {}\r\nContent-Type: text/plain\r\nContent-Length: 2\r\nConnection: close\r\n\r\n{{}}",
        view.host
    ));
    assert_eq!(status(&form), "415", "a form of a foreign page could send it");
}

#[test]
fn a_body_of_a_gigabyte_is_refused_unread() {
    let capture = Capture::new();
    let view = View::new(&capture, &[]);
    let head = |length: &str| {
        format!(
            "POST /{}/change HTTP/1.1\r\nHost: {}\r\nContent-Type: application/json\r\n{length}\r\n\r\n",
            view.token, view.host
        )
    };
    assert_eq!(status(&view.raw(&format!("{}x", head("Content-Length: 1000000000\r\nConnection: close")))), "413");

    // One that does not tell its length is cut off soon.
    let mut stream = view.connect();
    stream.write_all(head("Transfer-Encoding: chunked").as_bytes()).expect("can write");
    let chunk = [b"10000\r\n".to_vec(), vec![b' '; 1 << 16], b"\r\n".to_vec()].concat();
    let taken = (0..1 << 14).take_while(|_| stream.write_all(&chunk).is_ok()).count();
    assert!(taken < 1 << 9, "{taken} chunks of 64 KiB were taken");
    assert_eq!(status(&view.get(&format!("/{}/", view.token), "")), "200", "the server is alive");
}

#[test]
fn a_change_is_shown_kept_and_taken_back() {
    let capture = Capture::new();
    capture.edit("study.toml", "[grid]", "# as told\n[extract]\nhigh = 1.1  # by eye\n[grid]");
    let study = fs::read_to_string(capture.path("study.toml")).expect("can read");
    let view = View::new(&capture, &[]);
    let mut events = view.events();
    let first = events.until("voxels", "\"turn\":0");
    events.until("ended", "\"turn\":0");

    let two = r#"{"extract.high": 2.5, "trace.min_length_mm": 6}"#;
    let asked = turn(&view.post("change", two, ""));
    let shown = events.until("voxels", &format!("\"turn\":{asked}"));
    assert!(shown["count"].as_u64() < first["count"].as_u64(), "{} of {}", shown["count"], first["count"]);
    let roots = events.until("roots", &format!("\"turn\":{asked}"));
    let listed = roots["content"]["roots"].as_array().expect("roots").len();
    events.until("views", &format!("\"turn\":{asked}"));
    assert!(events.until("ended", &format!("\"turn\":{asked}"))["error"].is_null());
    assert_eq!(fs::read_to_string(capture.path("study.toml")).expect("can read"), study, "nothing is kept unasked");
    let slice = view.get(&format!("/{}/slice?of=rootness&turn=30&tilt=80&at=2", view.token), "");
    assert!(status(&slice) == "200" && slice.contains("\"png\""), "{slice}");
    let overlay = view
        .raw(&format!("GET /{}/overlay/0 HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n", view.token, view.host));
    assert!(overlay.contains("image/jpeg"));

    // A fault is told, and the server goes on.
    let asked = turn(&view.post("change", r#"{"extract.high": 0.1}"#, ""));
    let ended = events.until("ended", &format!("\"turn\":{asked}"));
    assert!(ended["error"].as_str().is_some_and(|e| e.contains("extract.low")), "{ended}");
    assert_eq!(status(&view.post("keep", r#"{"extract.high": 0.1}"#, "")), "422");

    let asked = turn(&view.post("keep", two, ""));
    events.until("ended", &format!("\"turn\":{asked}"));
    let kept = fs::read_to_string(capture.path("study.toml")).expect("can read");
    assert!(
        kept.contains("# as told\n[extract]\nhigh = 2.5  # by eye\n") && kept.contains("min_length_mm = 6.0"),
        "{kept}"
    );
    // The same result as a run of the file.
    capture.run(&[]).assert().success();
    let rows = fs::read_to_string(capture.path("results/tiny/root_voxels.csv")).expect("a table").lines().count() - 1;
    assert_eq!(Some(rows as u64), shown["count"].as_u64());
    let rows = fs::read_to_string(capture.path("results/tiny/per_root.csv")).expect("a table").lines().count() - 1;
    assert_eq!(rows, listed);

    let answer = view.post("undo", "{}", "");
    let asked = turn(&answer);
    events.until("ended", &format!("\"turn\":{asked}"));
    assert_eq!(fs::read_to_string(capture.path("study.toml")).expect("can read"), study);
    assert_eq!(status(&view.post("undo", "{}", "")), "422");
}

#[test]
fn a_correction_by_click_is_written_named_applied_and_taken_back() {
    let capture = Capture::new();
    let study = fs::read_to_string(capture.path("study.toml")).expect("can read");
    let view = View::new(&capture, &[]);
    let mut events = view.events();
    let first = events.until("roots", "\"turn\":0")["content"]["roots"].as_array().cloned().expect("roots");
    let gone = first.iter().rev().find(|root| root["order"].as_u64() > Some(0)).expect("a lateral");
    let xyz: Vec<f64> = serde_json::from_value(gone["xyz"].clone()).expect("numbers");
    let remove = format!(r#"{{"kind": "remove", "at": {:?}, "by": "Ada"}}"#, &xyz[xyz.len() - 3..]);
    let seen = r#"[{"photo": "../study.toml", "px": [1, 2]}, {"photo": "b.jpg", "px": [3, 4]}]"#;
    for wrong in [
        r#"{"kind": "remove"}"#,
        r#"{"kind": "burn", "at": [1, 2, 3]}"#,
        r#"{"kind": "remove", "at": [1, 2, 3], "file": "x"}"#,
        &format!(r#"{{"kind": "add", "clicks": [{seen}, {seen}]}}"#),
    ] {
        assert_eq!(status(&view.post("correct", wrong, "")), "422", "{wrong}");
    }
    assert!(!capture.path("corrections.toml").exists());
    let asked = turn(&view.post("correct", &remove, ""));
    let roots = events.until("roots", &format!("\"turn\":{asked}"));
    let outcome = &roots["sections"]["outcomes"][0];
    assert!(outcome["applied"] == true && outcome["by"] == "Ada", "{outcome}");
    assert!(roots["sections"]["corrections"].as_str().is_some_and(|html| html.contains("Ada")));
    let left = roots["content"]["roots"].as_array().expect("roots");
    assert!(left.len() < first.len() && left.iter().all(|root| first.contains(root)), "other roots changed");
    let text = fs::read_to_string(capture.path("corrections.toml")).expect("a file");
    assert!(text.contains("kind = \"remove\"") && text.contains("when = \"20"), "{text}");
    let now = fs::read_to_string(capture.path("study.toml")).expect("can read");
    assert!(now.starts_with(study.trim_end()) && now.contains("file = \"corrections.toml\""), "{now}");
    events.until("ended", &format!("\"turn\":{asked}"));

    // The same once more finds nothing there: written, told, not applied.
    let asked = turn(&view.post("correct", &remove, ""));
    let roots = events.until("roots", &format!("\"turn\":{asked}"));
    let outcome = &roots["sections"]["outcomes"][1];
    assert!(
        outcome["applied"] == false && outcome["found"].as_str().is_some_and(|f| f.contains("no root")),
        "{outcome}"
    );
    events.until("ended", &format!("\"turn\":{asked}"));

    turn(&view.post("undo", "{}", ""));
    let asked = turn(&view.post("undo", "{}", ""));
    let roots = events.until("roots", &format!("\"turn\":{asked}"));
    assert_eq!(roots["content"]["roots"].as_array(), Some(&first));
    assert!(!capture.path("corrections.toml").exists());
    assert_eq!(fs::read_to_string(capture.path("study.toml")).expect("can read"), study);

    // A file that the study does not name is nobody's to write into.
    fs::write(capture.path("corrections.toml"), "# mine\n").expect("can write");
    assert_eq!(status(&view.post("correct", &remove, "")), "422");
    assert_eq!(fs::read_to_string(capture.path("corrections.toml")).expect("can read"), "# mine\n");
}

#[test]
fn read_only_writes_nothing() {
    let capture = Capture::new();
    let view = View::new(&capture, &["--read-only"]);
    let answer = view.post("keep", r#"{"extract.high": 2.5}"#, "");
    assert!(status(&answer) == "422" && answer.contains("--read-only"), "{answer}");
    let answer = view.post("correct", r#"{"kind": "remove", "at": [0, 0, 30]}"#, "");
    assert!(status(&answer) == "422" && answer.contains("--read-only"), "{answer}");
    assert_eq!(status(&view.post("change", r#"{"extract.high": 2.5}"#, "")), "200");
}

#[test]
fn of_ten_changes_in_a_second_the_last_is_shown_and_the_cache_is_whole() {
    let capture = Capture::new();
    let view = View::new(&capture, &[]);
    let mut events = view.events();
    events.until("ended", "\"turn\":0");
    let mut last = 0;
    for n in 0..10 {
        last = turn(&view.post(
            "change",
            &format!(
                r#"{{"trace.high": {}, "extract.high": {}}}"#,
                0.6 + 0.05 * f64::from(n),
                1.2 + 0.1 * f64::from(n)
            ),
            "",
        ));
        std::thread::sleep(Duration::from_millis(100));
    }
    let shown = events.until("voxels", &format!("\"turn\":{last}"));
    events.until("ended", &format!("\"turn\":{last}"));
    // Of ten at once none but the last is computed to its end.
    let at_once = |n: u32| format!(r#"{{"trace.high": {}}}"#, 1.5 + 0.05 * f64::from(n));
    let asked: Vec<u64> = (0..10).map(|n| turn(&view.post("change", &at_once(n), ""))).collect();
    assert_eq!(events.turns("ended", asked[9]), [asked[9]], "of {asked:?}");
    #[cfg(unix)]
    assert_eq!(view.interrupt(), Some(0), "Ctrl-C is how it ends");
    rootvox().current_dir(capture.path("")).args(["cache", "verify"]).assert().success();
    // What a run finds is what was shown.
    capture.run(&["--set", "trace.high=1.05", "--set", "extract.high=2.1"]).assert().success();
    let rows = fs::read_to_string(capture.path("results/tiny/root_voxels.csv")).expect("a table").lines().count() - 1;
    assert_eq!(Some(rows as u64), shown["count"].as_u64());
}

#[test]
fn what_a_page_cannot_show_is_told() {
    let capture = Capture::new();
    let mut command = rootvox();
    command.current_dir(capture.path("")).args([
        "view",
        "study.toml",
        "--no-open",
        "--set",
        "sweep.extract.high=[1.0, 1.2]",
    ]);
    let said = super::capture::stderr(&mut command);
    assert!(said.contains("holds several studies, a page shows one"), "{said}");
}
