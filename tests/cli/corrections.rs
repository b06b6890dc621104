//! Corrections as an input of a study: from an RSML corrected elsewhere to the results.

use super::capture::{Capture, rootvox};
use std::fs;

/// The first rows of a table in the results.
fn table(capture: &Capture, name: &str) -> Vec<Vec<String>> {
    let text = fs::read_to_string(capture.path(&format!("results/tiny/{name}"))).expect("a table");
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn a_removed_root_of_an_rsml_becomes_a_correction_that_stands_in_the_results() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    let before = table(&capture, "per_root.csv");
    let gone = before.iter().rev().find(|row| row[3].parse::<f64>().is_ok_and(|mm| mm > 6.0)).expect("a root").clone();
    let rsml = fs::read_to_string(capture.path("results/tiny/roots.rsml")).expect("the RSML");
    let from = rsml.find(&format!("<root id=\"root-{}\"", gone[0])).expect("the root");
    let to = from + rsml[from..].find("</root>").expect("its end") + "</root>".len();
    fs::write(capture.path("corrected.rsml"), format!("{}{}", &rsml[..from], &rsml[to..])).expect("can write");

    let ask = || {
        let mut command = rootvox();
        command.current_dir(capture.path("")).args(["corrections", "from-rsml", "study.toml", "corrected.rsml"]);
        command.args(["-o", "corrections.toml", "--by", "Ada"]).output().expect("runs")
    };
    let output = ask();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(capture.path("corrections.toml")).expect("a file");
    assert_eq!(text.matches("[[correction]]").count(), 1, "{text}");
    assert!(text.contains("kind = \"remove\"") && text.contains("by = \"Ada\""), "{text}");
    assert_eq!(ask().status.code(), Some(2), "a file that is there is not overwritten");

    let output = capture.run(&["--set", "corrections.file=corrections.toml"]).output().expect("runs");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    // Nothing upstream of the roots runs again, and of the rest only what shows them.
    for stage in ["merge", "rootness", "trace", "hierarchy", "extract"] {
        assert!(!said.lines().any(|l| l.starts_with(&format!("{stage}: "))), "{said}");
    }
    let after = table(&capture, "per_root.csv");
    let others = |rows: &[Vec<String>]| -> Vec<Vec<String>> {
        // What hung on the root that went may not be counted there any more.
        rows.iter().filter(|r| r[0] != gone[0] && r[0] != gone[1]).cloned().collect()
    };
    assert_eq!(others(&after), others(&before));
    assert_eq!(after.len() + 1, before.len());
    let listed = table(&capture, "corrections.csv");
    assert_eq!((listed.len(), listed[0][1].as_str(), listed[0][2].as_str()), (1, "remove", "yes"));
    assert!(fs::read_to_string(capture.path("results/tiny/repairs.csv")).expect("a table").contains("corrected,"));
    let count =
        |name: &str| table(&capture, name).into_iter().find(|r| r[0] == "root_count").expect("a trait")[1].clone();
    assert_ne!(count("traits.csv"), count("traits_traced.csv"));

    // The lock knows the file.
    let mut again = rootvox();
    again.current_dir(capture.path("")).args(["rerun", "results/tiny/study.lock"]).assert().success();

    // A place where no root is: told, and nothing is changed.
    fs::write(capture.path("corrections.toml"), "[[correction]]\nkind = \"remove\"\nat = [0.0, 0.0, 900.0]\n")
        .expect("can write");
    let output = capture.run(&["--set", "corrections.file=corrections.toml"]).output().expect("runs");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.success() && said.contains("correction 1 was not applied: remove: no root within 1 mm"),
        "{said}"
    );
    assert_eq!(table(&capture, "per_root.csv"), before);
    assert!(
        fs::read_to_string(capture.path("results/tiny/report.html")).expect("a page").contains("id=\"corrections\"")
    );

    // A fault of the file names its line, one of its name the file.
    fs::write(capture.path("corrections.toml"), "\n[[correction]]\nkind = \"cut\"\n").expect("can write");
    for (set, want) in
        [("corrections.file=corrections.toml", "line 2: `cut` needs `at`"), ("corrections.file=no.toml", "no.toml")]
    {
        let output = capture.run(&["--set", set]).output().expect("runs");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.contains(want), "{said}");
    }
}
