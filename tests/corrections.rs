//! Corrections on the roots of licorice-sim, reconstructed on a grid of 1 mm.
//!
//! Set `ROOTVOX_TEST_DATA` to the folder that holds licorice-sim/; without it the tests say that they skip.
//! `ROOTVOX_TEST_CACHE` names a store to take finished nodes from.

use rootvox::evaluation::{Found, ScoreParams, detail};
use rootvox::flow::{Engine, Graph};
use rootvox::optics::{Tank, Vec3};
use rootvox::roots::correction::difference::difference;
use rootvox::roots::correction::place::nearest;
use rootvox::roots::correction::{Change, Correction, CorrectionParams, Outcome, Sighting, Spot, Tie, World, correct};
use rootvox::roots::{Root, RootSystem, TracedRoot, curve};
use rootvox::store::Store;
use rootvox::study::{graph, settings::Settings};
use std::path::PathBuf;
use std::sync::OnceLock;

/// What was traced, and the truth.
struct Plant {
    tank: Tank,
    traced: RootSystem,
    /// With other thresholds of the tracing.
    otherwise: RootSystem,
    truth: Vec<Root>,
}

fn plant() -> Option<&'static Plant> {
    static PLANT: OnceLock<Option<Plant>> = OnceLock::new();
    let plant = PLANT.get_or_init(|| {
        let data = PathBuf::from(std::env::var_os("ROOTVOX_TEST_DATA")?).join("licorice-sim");
        let folder = tempfile::tempdir().expect("a temporary folder");
        let study = folder.path().join("study.toml");
        let text = "[photos]\nimages = \"images/*\"\n[tank]\nfile = \"tank.json\"\nbelts = [[0.0, 28.0], [214.6, 246.6]]\n\
                    [grid]\ndepth = 180\nspacing = 1.0\n";
        std::fs::write(&study, text).expect("can write");
        let dir = format!("photos.dir={}", data.display());
        let store = Store::open(&folder.path().join("cache")).expect("the store opens");
        let store = match std::env::var_os("ROOTVOX_TEST_CACHE") {
            Some(cache) => store.over(&PathBuf::from(cache)).expect("a store"),
            None => store,
        };
        let traced = |more: &[&str]| -> (Tank, RootSystem) {
            let set: Vec<String> = std::iter::once(dir.as_str()).chain(more.iter().copied()).map(str::to_owned).collect();
            let settings = Settings::load(&study, &set).expect("the study is sound");
            let mut graph = Graph::new();
            let nodes = graph::add(&mut graph, &settings).expect("the graph is sound");
            let report = Engine::new(&store).run(&graph, &[nodes.system]).expect("the study runs");
            let system = report.artefact(nodes.system).and_then(|a| a.json("system.json")).expect("roots");
            (settings.tank, system)
        };
        let (tank, system) = traced(&[]);
        let (_, otherwise) = traced(&["trace.low=0.5"]);
        let text = std::fs::read_to_string(data.join("roots.json")).expect("the truth");
        let truth = rootvox::formats::roots_json::parse("roots.json", &text).expect("the truth");
        Some(Plant { tank, traced: system, otherwise, truth })
    });
    if plant.is_none() {
        eprintln!("skipped: ROOTVOX_TEST_DATA is not set");
    }
    plant.as_ref()
}

fn corrected(system: &RootSystem, changes: &[Change]) -> (RootSystem, Vec<Outcome>) {
    let made = |change: &Change| Correction {
        change: change.clone(),
        by: "a test".into(),
        when: String::new(),
        note: String::new(),
    };
    let list: Vec<Correction> = changes.iter().map(made).collect();
    let blind = |_: &Sighting| Ok(None);
    let params = CorrectionParams { snap_mm: 0.0, ..CorrectionParams::default() };
    correct(system.clone(), &list, &World { ray: &blind, rootness: None, params }).expect("no sightings")
}

fn length_mm(root: &Root) -> f64 {
    curve::chord_lengths(&root.points_mm).last().copied().unwrap_or(0.0)
}

/// The point in the middle of a root.
fn middle(root: &Root) -> Vec3 {
    Vec3::from(root.points_mm[root.points_mm.len() / 2])
}

/// A place of every kind of correction on the plant: with the numbers of the roots that it may change.
fn one_of_each(roots: &[TracedRoot]) -> Vec<(Change, Vec<i64>)> {
    let alone = |p: &Vec3, id: i64| roots.iter().all(|r| r.root.id == id || nearest(&r.root.points_mm, p).1 > 3.0);
    let tip = |r: &Root| Vec3::from(r.points_mm[r.points_mm.len() - 1]);
    let leaf = |r: &Root| roots.iter().all(|o| o.root.parent != r.id);
    let mut leaves = roots
        .iter()
        .map(|r| &r.root)
        .filter(|r| leaf(r) && r.parent >= 0 && length_mm(r) > 20.0 && alone(&middle(r), r.id) && alone(&tip(r), r.id));
    let mut next = || leaves.next().expect("the plant has laterals");
    let (a, b, c, d, e, f, g) = (next(), next(), next(), next(), next(), next(), next());
    let base = roots.iter().find(|r| r.root.order == 0).map(|r| &r.root).expect("a base root");
    let further = |root: &Root, way: f64| tip(root) + Vec3::new(0.0, 0.0, way);
    // A place of the base root that no other root comes near to.
    let on_base =
        base.points_mm.iter().map(|p| Vec3::from(*p)).find(|p| alone(p, base.id)).expect("a place of its own");
    vec![
        (Change::Remove { at: middle(a) }, vec![a.id]),
        (Change::RemoveStretch { from: middle(b), to: tip(b) }, vec![b.id]),
        (Change::Cut { at: middle(c) }, vec![c.id]),
        (Change::Parent { at: middle(d), parent: on_base }, vec![d.id]),
        (Change::Order { at: middle(e), order: 4 }, vec![e.id]),
        (Change::Join { from: tip(f), to: tip(g) }, vec![f.id, g.id]),
        (Change::Base { at: Vec3::from(base.points_mm[0]) }, vec![]),
        (Change::Checked { at: middle(a) }, vec![]),
        (
            Change::Add {
                through: vec![Spot::Place(further(b, 30.0)), Spot::Place(further(b, 50.0))],
                diameter_mm: Some(0.7),
                tie: Tie::Free,
            },
            vec![],
        ),
    ]
}

#[test]
fn every_kind_changes_only_what_was_asked() {
    let Some(plant) = plant() else { return };
    let traced = &plant.traced.roots;
    for (change, may_change) in one_of_each(traced) {
        let (system, outcomes) = corrected(&plant.traced, std::slice::from_ref(&change));
        assert!(outcomes[0].applied, "{outcomes:?}");
        for was in traced.iter().filter(|r| !may_change.contains(&r.root.id)) {
            let is = system.roots.iter().find(|r| r.root.id == was.root.id);
            assert_eq!(is, Some(was), "{change:?}");
        }
        let new = system.roots.iter().filter(|r| traced.iter().all(|t| t.root.id != r.root.id)).count();
        assert_eq!(new, usize::from(matches!(change, Change::Cut { .. } | Change::Add { .. })), "{change:?}");
        for id in may_change {
            let of = |list: &[TracedRoot]| list.iter().find(|r| r.root.id == id).cloned();
            assert_ne!(of(&system.roots), of(traced), "{change:?}");
        }
    }
}

#[test]
fn with_other_thresholds_each_applies_or_says_why_not() {
    let Some(plant) = plant() else { return };
    let changes: Vec<Change> = one_of_each(&plant.traced.roots).into_iter().map(|c| c.0).collect();
    let changes: Vec<Change> = changes.into_iter().filter(|c| !matches!(c, Change::Base { .. })).collect();
    for change in &changes {
        let (system, outcomes) = corrected(&plant.otherwise, std::slice::from_ref(change));
        let outcome = &outcomes[0];
        eprintln!("{}: {} ({})", outcome.kind, if outcome.applied { "applied" } else { "reported" }, outcome.found);
        if !outcome.applied {
            assert!(!outcome.found.is_empty());
            assert_eq!(system.roots, plant.otherwise.roots, "what is not applied changes nothing");
        } else if let Some(at) = change.place_mm().filter(|_| !matches!(change, Change::Add { .. })) {
            let nearest_mm =
                plant.otherwise.roots.iter().map(|r| nearest(&r.root.points_mm, &at).1).fold(f64::MAX, f64::min);
            assert!(nearest_mm <= 1.0, "applied {nearest_mm} mm away from its place");
        }
    }
}

/// Tips P and R, and the share of the length of the right order.
fn quality(plant: &Plant, system: &RootSystem) -> [f64; 3] {
    let inside = |p: &[f64; 3]| p[2] > 28.0 && p[2] < 178.0;
    let tips = |roots: &[Root]| -> Vec<Vec3> {
        roots.iter().map(|r| r.points_mm[r.points_mm.len() - 1]).filter(inside).map(Vec3::from).collect()
    };
    let found = system.plain();
    let (a, b) = (tips(&found), tips(&plant.truth));
    // One to one, nearest first.
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (n, p) in a.iter().enumerate() {
        pairs.extend(b.iter().enumerate().map(|(m, q)| ((p - q).norm(), n, m)).filter(|pair| pair.0 <= 2.0));
    }
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0));
    let (mut of_a, mut of_b, mut matched) = (vec![false; a.len()], vec![false; b.len()], 0.0);
    for (_, n, m) in pairs {
        if !of_a[n] && !of_b[m] {
            (of_a[n], of_b[m]) = (true, true);
            matched += 1.0;
        }
    }
    let tree = truth_tree(&plant.truth);
    let (mut near, mut right) = (0.0_f64, 0.0);
    for root in &found {
        for p in root.points_mm.iter().filter(|p| inside(p)) {
            let Some((n, d2)) = tree.nearest_neighbor_iter_with_distance_2(*p).next() else { continue };
            if d2 <= 1.0 {
                near += 1.0;
                right += f64::from(u8::from(n.data == root.order));
            }
        }
    }
    [matched / a.len().max(1) as f64, matched / b.len().max(1) as f64, right / near.max(1.0)]
}

type Tree = rstar::RTree<rstar::primitives::GeomWithData<[f64; 3], u32>>;

fn truth_tree(truth: &[Root]) -> &'static Tree {
    static TREE: OnceLock<Tree> = OnceLock::new();
    TREE.get_or_init(|| {
        let points = truth.iter().flat_map(|root| {
            let line = curve::resample(&root.points_mm, 0.25);
            line.into_iter().map(|p| rstar::primitives::GeomWithData::new(p, root.order))
        });
        Tree::bulk_load(points.collect())
    })
}

/// Of the corrections that lead to the truth the ten that do most, chosen one or two at a time.
fn ten(plant: &Plant) -> Vec<Change> {
    let all = difference(&plant.traced.roots, &plant.truth, CorrectionParams::default()).expect("no sightings");
    let kinds: Vec<&str> = all.iter().map(Change::kind).collect();
    eprintln!("{} corrections lead to the truth: {kinds:?}", all.len());
    let of = |chosen: &[usize]| -> Vec<Change> { chosen.iter().map(|&n| all[n].clone()).collect() };
    let value = |chosen: &[usize]| {
        quality(plant, &corrected(&plant.traced, &of(chosen)).0).iter().map(|q| q.min(0.985)).sum::<f64>()
    };
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < 10 {
        let now = value(&chosen);
        let left: Vec<usize> = (0..all.len()).filter(|n| !chosen.contains(n)).collect();
        let singles = left.iter().map(|&n| vec![n]);
        // A cut alone mends nothing.
        let cuts = left.iter().filter(|&&n| matches!(all[n], Change::Cut { .. }));
        let pairs = cuts.flat_map(|&a| left.iter().filter(move |&&b| b > a).map(move |&b| vec![a, b]));
        let best = singles
            .chain(pairs.filter(|_| chosen.len() < 9))
            .map(|more| {
                let mut with: Vec<usize> = chosen.iter().chain(&more).copied().collect();
                with.sort_unstable();
                ((value(&with) - now) / more.len() as f64, with)
            })
            .max_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((gain, with)) if gain > 0.0 => chosen = with,
            _ => break,
        }
    }
    of(&chosen)
}

#[test]
fn ten_corrections_from_the_truth_mend_tips_and_orders() {
    let Some(plant) = plant() else { return };
    let before = quality(plant, &plant.traced);
    let ten = ten(plant);
    let (system, outcomes) = corrected(&plant.traced, &ten);
    let [_, _, order] = quality(plant, &system);
    let kinds: Vec<&str> = ten.iter().map(Change::kind).collect();
    let params = ScoreParams { z_max_mm: 178.0, ..ScoreParams::default() };
    let found = system.plain();
    let tips =
        detail(&plant.truth, &plant.tank, Found::Roots(&found), &params, None).expect("scored").tips.expect("tips");
    let (p, r) = (tips.precision(), tips.recall());
    eprintln!("before {before:.3?}; after {kinds:?}: tips P {p:.3} R {r:.3} ({tips:?}), order {order:.3}");
    assert!(outcomes.iter().all(|o| o.applied), "{outcomes:?}");
    assert!(ten.len() <= 10);
    let gain = quality(plant, &system).iter().sum::<f64>() - before.iter().sum::<f64>();
    assert!(order >= 0.97 && gain > 0.0, "order {order}, gain {gain}");
}
