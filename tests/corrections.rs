//! Corrections on the roots of licorice-sim, reconstructed on a grid of 1 mm.
//!
//! Set `ROOTVOX_TEST_DATA` to the folder that holds licorice-sim/; without it the tests say that they skip.
//! `ROOTVOX_TEST_CACHE` names a store to take finished nodes from.

use rootvox::flow::{Engine, Graph};
use rootvox::optics::Vec3;
use rootvox::roots::correction::difference::difference;
use rootvox::roots::correction::nearest::nearest;
use rootvox::roots::correction::{Change, Correction, CorrectionParams, Outcome, Sighting, Spot, Tie, World, correct};
use rootvox::roots::{Root, RootSystem, TracedRoot, curve};
use rootvox::store::Store;
use rootvox::study::{graph, settings::Settings};
use rstar::RTree;
use rstar::primitives::GeomWithData;
use std::path::PathBuf;
use std::sync::OnceLock;

/// What was traced, and the truth.
struct Plant {
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
        let store = match std::env::var("ROOTVOX_TEST_CACHE").ok() {
            Some(cache) => store.over(&cache).expect("a store"),
            None => store,
        };
        let traced = |more: &[&str]| -> RootSystem {
            let set: Vec<String> = std::iter::once(dir.as_str()).chain(more.iter().copied()).map(str::to_owned).collect();
            let settings = Settings::load(&study, &set).expect("the study is sound");
            let mut graph = Graph::new();
            let nodes = graph::add(&mut graph, &settings).expect("the graph is sound");
            let report = Engine::new(&store).run(&graph, &[nodes.system]).expect("the study runs");
            report.artefact(nodes.system).and_then(|a| a.json("system.json")).expect("roots")
        };
        let (system, otherwise) = (traced(&[]), traced(&["trace.low=0.5"]));
        let text = std::fs::read_to_string(data.join("roots.json")).expect("the truth");
        let truth = rootvox::formats::roots_json::parse("roots.json", &text).expect("the truth");
        Some(Plant { traced: system, otherwise, truth })
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
    correct(system.clone(), &list, &World { ray: &blind, evidence: None, params }).expect("no sightings")
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

/// The share of the points near the truth that have the order of it.
fn order_share(plant: &Plant, found: &[Root]) -> f64 {
    let points = plant.truth.iter().flat_map(|root| {
        let line = curve::resample(&root.points_mm, 0.25);
        line.into_iter().map(|p| GeomWithData::new(p, root.order))
    });
    let tree = RTree::bulk_load(points.collect());
    let (mut near, mut right) = (0.0_f64, 0.0);
    for root in found {
        for p in root.points_mm.iter().filter(|p| p[2] > 28.0 && p[2] < 178.0) {
            let Some((n, d2)) = tree.nearest_neighbor_iter_with_distance_2(*p).next() else { continue };
            if d2 <= 1.0 {
                near += 1.0;
                right += f64::from(u8::from(n.data == root.order));
            }
        }
    }
    right / near.max(1.0)
}

fn tip(root: &Root) -> Vec3 {
    Vec3::from(root.points_mm[root.points_mm.len() - 1])
}

fn in_region(root: &Root) -> bool {
    (28.0..178.0).contains(&tip(root).z)
}

/// P and R of tips, one to one, nearest first, within 2 mm. Counted are those of the region; each may have its partner in the whole
/// tank, so that a tip at the region's rim is not lost for half a millimetre beside it.
fn tips(plant: &Plant, found: &[Root]) -> [f64; 2] {
    let sides = [found, &plant.truth];
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (n, a) in found.iter().enumerate() {
        let apart = |b: &Root| (tip(a) - tip(b)).norm();
        pairs.extend(plant.truth.iter().enumerate().map(|(m, b)| (apart(b), n, m)).filter(|pair| pair.0 <= 2.0));
    }
    pairs.sort_by(|x, y| x.0.total_cmp(&y.0));
    let mut matched = sides.map(|side| vec![false; side.len()]);
    for (_, n, m) in pairs {
        if !matched[0][n] && !matched[1][m] {
            (matched[0][n], matched[1][m]) = (true, true);
        }
    }
    [0, 1].map(|side| {
        let counted: Vec<bool> =
            sides[side].iter().zip(&matched[side]).filter(|(r, _)| in_region(r)).map(|(_, is)| *is).collect();
        counted.iter().filter(|is| **is).count() as f64 / counted.len().max(1) as f64
    })
}

#[test]
fn corrections_from_the_truth_mend_tips_and_orders() {
    let Some(plant) = plant() else { return };
    let changes = difference(&plant.traced.roots, &plant.truth, CorrectionParams::default()).expect("no sightings");
    let kinds: Vec<&str> = changes.iter().map(Change::kind).collect();
    let (system, outcomes) = corrected(&plant.traced, &changes);
    assert!(outcomes.iter().all(|o| o.applied), "{outcomes:?}");
    let (before, after) = (plant.traced.plain(), system.plain());
    let ([p, r], order) = (tips(plant, &after), order_share(plant, &after));
    eprintln!("{} corrections: {kinds:?}", kinds.len());
    eprintln!("tips P and R: {:.3?}, then {:.3?}", tips(plant, &before), [p, r]);
    eprintln!("order: {:.3}, then {order:.3}", order_share(plant, &before));
    assert!(p >= 0.97 && r >= 0.97, "tips: P {p} R {r}");
    assert!(order >= 0.97, "{order}");
}
