//! Trials: a list of captures checked before anything runs, one graph, each capture by itself, results of all together.

use super::capture::{rootvox, stderr};
use super::runs::{computed, ran};
use assert_cmd::Command;
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

/// A trial of simulated plants: the tiny study without its name and seed.
struct Trial(TempDir);

impl Trial {
    fn new(table: &str) -> Self {
        let trial = Self(tempfile::tempdir().expect("a temporary folder"));
        let study = include_str!("../data/tiny.toml").replace("name = \"tiny\"", "name = \"peas\"");
        fs::write(trial.path("trial.toml"), format!("{study}[plants]\ntable = \"plants.csv\"\n")).expect("can write");
        trial.list(table);
        trial
    }

    fn list(&self, table: &str) {
        fs::write(self.path("plants.csv"), table).expect("can write");
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, verb: &str, more: &[&str]) -> Command {
        let mut command = rootvox();
        command.current_dir(self.0.path()).args([verb, "trial.toml"]).args(more);
        command
    }

    /// How many nodes the store holds.
    fn stored(&self) -> usize {
        let inside = |folder: PathBuf| fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let caches = inside(self.path("cache")).map(|cache| cache.join("nodes"));
        caches.flat_map(inside).flat_map(inside).count()
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }
}

#[test]
fn a_plant_that_is_added_costs_only_itself_and_one_that_fails_fails_alone() {
    let three = "plant,treatment,simulate.seed\n1,dry,3\n2,dry,4\n3,wet,5\n";
    let trial = Trial::new(three);
    let first = stderr(&mut trial.command("run", &[]));
    assert!(first.contains("peas: 3 captures, 0 failed; results of 3 written"), "{first}");
    assert!(ran(&first).contains(&"extract [2]"), "{first}");
    assert_eq!(computed(&stderr(&mut trial.command("run", &[]))), 0, "nothing changed");
    let traits = trial.text("results/peas/trial/traits.csv");
    assert!(traits.starts_with("plant,date,treatment,trait,value,spread\n1,,dry,total_root_length_mm,"), "{traits}");
    assert!(trial.text("results/peas/trial/roots.csv").lines().any(|l| l.starts_with("3,,wet,")));
    let page = trial.text("results/peas/trial/report.html");
    assert!(page.contains("../2/report.html") && page.contains("<h2>treatment</h2>"), "links and groups");
    assert!(
        trial.path("results/peas/2/report.html").is_file() && trial.path("results/peas/trial/analysis.R").is_file()
    );

    trial.list(&format!("{three}4,wet,6\n"));
    assert_eq!(trial.command("status", &["--stale"]).output().expect("runs").stdout, b"4\n");
    let more = stderr(&mut trial.command("run", &[]));
    assert!(ran(&more).iter().all(|name| name.ends_with("[4]")) && computed(&more) > 9, "{more}");

    // Called otherwise, in another order, one less: nothing is computed.
    trial.list("plant,treatment,simulate.seed\n3,wet,5\none,dry,3\n");
    let fewer = stderr(&mut trial.command("run", &[]));
    assert_eq!(computed(&fewer), 0, "{fewer}");
    assert!(trial.text("results/peas/trial/traits.csv").lines().any(|l| l.starts_with("one,,dry,")));

    // Cameras that look past the tank fail while they run.
    trial.list("plant,simulate.seed,simulate.capture.pan_deg\n1,3,0.3\nbad,4,85\n");
    let output = trial.command("run", &[]).output().expect("runs");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && text.contains("2 captures, 1 failed"), "{text}");
    let quality = trial.text("results/peas/trial/quality.csv");
    let lines: Vec<&str> = quality.lines().collect();
    assert!(lines[1].starts_with("1,,done,,6,") && lines[2].starts_with("bad,,failed,"), "{quality}");
    assert!(trial.text("results/peas/trial/report.html").contains("Failed"));
}

#[test]
fn a_list_is_checked_before_anything_runs_all_faults_at_once() {
    let trial = Trial::new(
        "plant,date,photos,tank.radius,tank.radus\n1,2026-05-01,a,30,1\n1,2026-05-01,a,30,1\n2,May,a,30,1\n3,2026-05-01,a,30 mm,1\n",
    );
    fs::create_dir_all(trial.path("a/images")).expect("can create");
    let text = stderr(&mut trial.command("run", &[]));
    for wanted in [
        "line 1, column 31",
        "radus",
        "line 3, column 1 (plant)",
        "2026-05-01 is in `plants.csv` line 2",
        "line 4, column 3 (date)",
        "line 5, column 16 (tank.radius)",
    ] {
        assert!(text.replace('\n', " ").contains(wanted), "`{wanted}` is not in\n{text}");
    }
    assert_eq!(text.matches("unknown field `radus`").count(), 1, "{text}");
    assert!(!trial.path("cache").exists());

    // From files: a folder that is not there.
    let study = trial.text("trial.toml");
    let cut = study.find("[simulate]").expect("is there")..study.find("[grid]").expect("is there");
    fs::write(trial.path("trial.toml"), study.replace(&study[cut], "")).expect("can write");
    trial.list("plant,photos\n1,nowhere\n2,a\n");
    let text = stderr(&mut trial.command("run", &[]));
    assert!(text.contains("`plants.csv` line 2: photos.dir: there is no folder `nowhere`"), "{text}");
    assert!(text.contains("line 3: photos.images: no photograph matches"), "{text}");
}

#[test]
fn some_captures_alone_and_sweeps_over_all() {
    let trial = Trial::new("plant,simulate.seed\n1,3\n2,4\n");
    let text = stderr(&mut trial.command("run", &["--only", "plant=2"]));
    assert!(text.contains("1 capture, 0 failed") && text.contains("left as they are"), "{text}");
    assert!(trial.path("results/peas/2").is_dir() && !trial.path("results/peas/1").exists());
    assert!(!trial.path("results/peas/trial").exists());
    let text = stderr(&mut trial.command("run", &["--only", "plant=3"]));
    assert!(text.contains("no capture is left by --only plant=3"), "{text}");
    let text = stderr(&mut trial.command("run", &["--only", "size=3"]));
    assert!(text.contains("the columns are plant, simulate.seed"), "{text}");

    trial.command("run", &["--set", "sweep.extract.high=[0.8, 1.0]", "--set", "study.name=swept"]).assert().success();
    let sweep = trial.text("results/swept/trial/sweep.csv");
    let lines: Vec<&str> = sweep.lines().collect();
    assert!(lines.len() == 5 && lines[0].starts_with("plant,date,point,extract.high,f1_0.5mm"), "{sweep}");
    assert!(lines[4].starts_with("2,,2,1.0,") && trial.path("results/swept/1/contact.svg").is_file(), "{sweep}");
}

#[test]
fn folders_are_captures_and_their_names_cost_nothing() {
    let trial = Trial::new("");
    let study = trial.text("trial.toml");
    let one = study.find("[plants]").expect("is there");
    fs::write(trial.path("trial.toml"), &study[..one]).expect("can write");
    trial.command("simulate", &["--out", "c/wild-1/2026-05-01"]).assert().success();
    trial.command("simulate", &["--out", "c/wild-1/2026-05-04", "--set", "simulate.seed=9"]).assert().success();
    let cut = study.find("[simulate]").expect("is there")..study.find("[grid]").expect("is there");
    let study = study
        .replace(&study[cut], "")
        .replace("table = \"plants.csv\"", "folders = \"c/{genotype}-{plant}/{date:%Y-%m-%d}\"");
    fs::write(trial.path("trial.toml"), study).expect("can write");
    let first = stderr(&mut trial.command("run", &[]));
    assert!(first.contains("2 captures, 0 failed"), "{first}");
    let traits = trial.text("results/peas/trial/traits.csv");
    assert!(traits.contains("\n1,2026-05-04,wild,"), "{traits}");
    fs::rename(trial.path("c/wild-1"), trial.path("c/tame-7")).expect("can rename");
    let again = stderr(&mut trial.command("run", &[]));
    assert_eq!(computed(&again), 0, "{again}");
    assert!(trial.path("results/peas/7-2026-05-04/report.html").is_file());
    // Each capture is made again from its own lock.
    let again = rootvox().current_dir(trial.0.path()).args(["rerun", "results/peas/7-2026-05-04/study.lock"]).output();
    let text = String::from_utf8_lossy(&again.expect("runs").stdout).into_owned();
    assert!(text.contains("bit-identical"), "{text}");
    let whole = rootvox().current_dir(trial.0.path()).args(["rerun", "results/peas/trial/study.lock"]).output();
    assert!(String::from_utf8_lossy(&whole.expect("runs").stderr).contains("the lock of a whole trial"));
}

/// A plant on days 5 and 7, turned by 50 degrees in between, and another whose belts were printed anew.
const DAYS: &str = "plant,date,simulate.seed,simulate.age.days,simulate.day.seed,simulate.day.start_deg,simulate.capture.belt_seed\n\
    1,5,3,5,11,0,1\n1,7,3,7,12,50,1\n2,5,3,5,11,0,1\n2,7,3,7,12,50,2\n";

/// Larger pictures than the tiny ones, two pixels per blot of the print; a main root that is not full grown on day 7.
const FINER: [&str; 12] = [
    "--set",
    "simulate.capture.width=400",
    "--set",
    "simulate.capture.height=300",
    "--set",
    "simulate.capture.views=12",
    "--set",
    "grid.spacing=0.5",
    "--set",
    "simulate.age.elongation_mm_per_day=[7, 5, 3]",
    "--set",
    "simulate.age.emergence_days=1",
];

#[test]
fn a_plant_is_followed_over_days_and_another_print_is_refused() {
    let trial = Trial::new(DAYS);
    let output = trial.command("run", &FINER).output().expect("runs");
    let text = String::from_utf8_lossy(&output.stderr).replace("\n  │ ", " ");
    assert!(!output.status.success() && text.contains("4 captures, 0 failed"), "{text}");
    assert!(text.contains("plant 2: align/2-7: the belts are not those of the plant's first day"), "{text}");
    let growth = trial.text("results/peas/trial/growth.csv");
    let header =
        "plant,root_id,parent_id,order,from_day,to_day,days,state,length_from_mm,length_to_mm,overlap,elongation_mm";
    assert!(growth.starts_with(header), "{growth}");
    assert!(!growth.contains("\n2,"), "{growth}");
    let days = trial.text("results/peas/trial/days/1-7.rsml");
    assert!(days.contains("<index>1</index><unified>true</unified></time-sequence>"), "a series");
    let scene = fs::read(trial.path("results/peas/trial/days/1.glb")).expect("a scene over days");
    let holds = |text: &[u8]| scene.windows(text.len()).any(|part| part == text);
    assert!(scene.starts_with(b"glTF") && holds(b"\"day-2\"") && holds(b"\"growth\""), "days and an animation");
    assert!(!trial.path("results/peas/trial/days/2.glb").exists(), "it was not followed");
    let page = trial.text("results/peas/trial/report.html");
    assert!(page.contains(" class=\"film-2\"") && page.contains("@keyframes film-2") && !page.contains("<script"));
    let traits = trial.text("results/peas/trial/traits.csv");
    assert!(traits.contains("\n1,7,elongation_mm_per_day,"), "{traits}");
    // The simulation's rate is 7 mm a day within a fifth.
    let main = growth.lines().find(|l| l.contains(",-1,0,0.0,2.0,2.0,followed,")).expect("the main root");
    let rate: f64 = main.split(',').nth(12).expect("a rate").parse().expect("a number");
    assert!(main.starts_with("1,") && (5.0..9.0).contains(&rate), "{rate} mm per day");

    assert!(growth.lines().next().is_some_and(|l| l.ends_with(",recalled")) && !growth.contains(",from\n"), "{growth}");
    assert!(days.contains("name=\"node_creation_time\""), "points know their day");

    // Days help each other only where they are asked to, and nothing else is computed for it.
    let helped = [&FINER[..], &["--set", "recall.enabled=true"]].concat();
    let text = stderr(&mut trial.command("run", &helped));
    assert!(ran(&text).iter().all(|name| name.starts_with("recall")) && computed(&text) == 3, "{text}");
    let recalled = trial.text("results/peas/trial/recalled.csv");
    assert!(recalled.starts_with("plant,root_id,day,by_day,length_mm,contrast,chance\n"), "{recalled}");
    let rows =
        |text: &str| text.lines().filter(|l| [",from", ",to", ",both"].iter().any(|end| l.ends_with(end))).count();
    assert_eq!(rows(&trial.text("results/peas/trial/growth.csv")) > 0, recalled.lines().count() > 1, "{recalled}");
    let blind = [&helped[..], &["--set", "contrast.enabled=false"]].concat();
    assert!(
        stderr(&mut trial.command("run", &blind)).contains("recall.enabled"),
        "there is no share of root to look at"
    );
    trial.command("run", &FINER).output().expect("runs");
    assert!(!trial.path("results/peas/trial/recalled.csv").exists());

    // A day less computes nothing but what it changes.
    trial.list(&DAYS.replace("2,7,3,7,12,50,2\n", "").replace("1,7,3,7,12,50,1\n", ""));
    assert_eq!(computed(&stderr(&mut trial.command("run", &FINER))), 0);
}

#[test]
fn a_day_too_faint_to_trace_is_read_with_the_help_of_others() {
    // Grey levels of noise on day 7: every photograph there is nearly nothing but noise.
    let trial = Trial::new(
        "plant,date,simulate.age.days,simulate.day.seed,simulate.day.start_deg,simulate.capture.noise_sigma\n\
        1,5,5,11,0,2\n1,7,7,12,50,45\n1,9,9,13,120,2\n",
    );
    let study = include_str!("../data/days.toml").replace("days.csv", "plants.csv").replace("seed = 3", "seed = 4");
    fs::write(trial.path("trial.toml"), study).expect("can write");
    trial.command("run", &[]).assert().success();
    // The true lengths on that day: of root 5, 1 mm on day 5, and of root 6, which was not there, nothing is invented.
    let there = [46.8, 11.6, 11.6, 16.9, 15.6, 10.3, 6.9];
    let table = trial.text("results/trial/trial/recalled.csv");
    let rows: Vec<Vec<f64>> =
        table.lines().skip(1).map(|l| l.split(',').map(|x| x.parse().expect("a number")).collect()).collect();
    assert!(rows.len() >= 3, "{table}");
    for row in &rows {
        let (day, by, length) = (row[2], row[3], row[4]);
        let near = there.iter().any(|true_mm| (length - true_mm).abs() < 0.05 * true_mm + 0.5);
        assert!(day == 2.0 && by == 4.0 && near && row[6] <= 0.03, "{table}");
    }
    let growth = trial.text("results/trial/trial/growth.csv");
    assert!(growth.lines().any(|l| l.ends_with(",to")) && growth.lines().any(|l| l.ends_with(",from")), "{growth}");
}

#[test]
fn a_simulated_trial_is_a_folder_per_capture() {
    let trial = Trial::new(DAYS);
    trial.command("simulate", &["--out", "made"]).assert().success();
    assert_eq!(trial.text("made/plants.csv"), "plant,date,photos\n1,5,1-5\n1,7,1-7\n2,5,2-5\n2,7,2-7\n");
    for name in ["1-5/roots.json", "1-7/cameras.json", "2-7/images/005.jpg"] {
        assert!(trial.path("made").join(name).is_file(), "{name}");
    }
    let roots = |name: &str| trial.text(&format!("made/{name}/roots.json")).len();
    assert!(roots("1-7") > roots("1-5"));
}

#[test]
fn a_trial_that_was_killed_goes_on_where_it_was() {
    let list = "plant,simulate.seed\n1,3\n2,4\n3,5\n";
    let (whole, killed) = (Trial::new(list), Trial::new(list));
    let all = computed(&stderr(&mut whole.command("run", &[])));
    assert_eq!(whole.stored(), all);
    // One kill early, one late.
    for share in [0.2, 0.7] {
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_rootvox"))
            .current_dir(killed.path(""))
            .args(["run", "trial.toml"])
            .env_remove("ROOTVOX_CACHE")
            .stderr(std::process::Stdio::null())
            .spawn()
            .expect("starts");
        while (killed.stored() as f64) < share * all as f64 {
            assert!(child.try_wait().expect("can ask").is_none(), "it ended before it was killed");
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        child.kill().expect("can kill");
        child.wait().expect("is gone");
        assert!(!killed.path("results/peas/trial").exists(), "half of the captures are no trial");
    }
    let before = killed.stored();
    assert!(before < all, "it was killed in the middle");
    assert_eq!(
        computed(&stderr(&mut killed.command("run", &[]))),
        all - before,
        "what is stored is not computed again"
    );
    let lock = |trial: &Trial| trial.text("results/peas/trial/study.lock");
    assert_eq!(lock(&whole), lock(&killed), "keys and digests of an undisturbed run");
}
