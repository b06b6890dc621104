//! Each kind of correction on a small plant, held root by root against what was asked.

use super::*;
use crate::roots::{Field, Root, TracedRoot};

fn root(id: i64, parent: i64, order: u32, points: &[[f64; 3]]) -> TracedRoot {
    let points_mm = crate::roots::curve::resample(points, 0.5);
    let n = points_mm.len();
    TracedRoot {
        root: Root { id, parent, order, radii_mm: vec![0.4; n], points_mm },
        radius_sd_mm: vec![0.05; n],
        views: vec![7; n],
        confidence: vec![0.9; n],
    }
}

/// A taproot down the axis; 1 springs from it at z = 20, 2 at z = 40, and 3 from 1 at x = 20; 4 stands alone.
fn plant() -> Vec<TracedRoot> {
    vec![
        root(0, -1, 0, &[[0.0, 0.0, 0.0], [0.0, 0.0, 80.0]]),
        root(1, 0, 1, &[[0.0, 0.0, 20.0], [40.0, 0.0, 20.0]]),
        root(2, 0, 1, &[[0.0, 0.0, 40.0], [-40.0, 0.0, 40.0]]),
        root(3, 1, 2, &[[20.0, 0.0, 20.0], [20.0, 30.0, 20.0]]),
        root(4, -1, 1, &[[43.0, 0.0, 20.0], [60.0, 0.0, 20.0]]),
    ]
}

fn at(x: f64, y: f64, z: f64) -> Vec3 {
    Vec3::new(x, y, z)
}

fn blind(_: &Sighting) -> Result<Option<WaterRay>> {
    Ok(None)
}

fn made(change: Change) -> Correction {
    Correction { change, by: "Ada".into(), when: "2026-05-01T12:00:00Z".into(), note: String::new() }
}

/// The corrected roots, and what became of the correction.
fn after(change: Change) -> (Vec<TracedRoot>, Outcome) {
    let system = RootSystem { roots: plant(), spread_px: Some(1.0), repairs: Vec::new() };
    let world = World { ray: &blind, evidence: None, params: CorrectionParams::default() };
    let (system, outcomes) = correct(system, &[made(change)], &world).unwrap();
    let entry = &system.repairs[0];
    assert_eq!(entry.kind, if outcomes[0].applied { Kind::Corrected } else { Kind::Uncorrected });
    assert!(entry.reason.contains("by Ada; on 2026-05-01T12:00:00Z"), "{}", entry.reason);
    for r in &system.roots {
        let n = r.root.points_mm.len();
        assert!(n > 1 && [r.root.radii_mm.len(), r.radius_sd_mm.len(), r.views.len(), r.confidence.len()] == [n; 4]);
        assert!(r.root.parent < 0 || system.roots.iter().any(|p| p.root.id == r.root.parent), "an orphan");
    }
    (system.roots, outcomes[0].clone())
}

/// (number, parent, order, length rounded to mm) of each root.
fn table(roots: &[TracedRoot]) -> Vec<(i64, i64, u32, i64)> {
    let length = |r: &TracedRoot| crate::roots::curve::chord_lengths(&r.root.points_mm).last().copied().unwrap_or(0.0);
    let mut rows: Vec<_> =
        roots.iter().map(|r| (r.root.id, r.root.parent, r.root.order, length(r).round() as i64)).collect();
    rows.sort_unstable();
    rows
}

/// Roots of these numbers are as they were.
fn unchanged(roots: &[TracedRoot], ids: &[i64]) {
    let plant = plant();
    for id in ids {
        let of = |list: &[TracedRoot]| list.iter().find(|r| r.root.id == *id).cloned();
        assert_eq!(of(roots), of(&plant), "root {id} changed");
    }
}

#[test]
fn a_removed_root_goes_with_what_springs_from_it() {
    let (roots, outcome) = after(Change::Remove { at: at(10.0, 0.2, 20.0) });
    assert!(
        outcome.applied && outcome.found.contains("40.0 mm long, 0.20 mm from the place, and 1 springing"),
        "{outcome:?}"
    );
    unchanged(&roots, &[0, 2, 4]);
    assert_eq!(roots.len(), 3);
}

#[test]
fn a_stretch_is_taken_out_of_the_middle_the_tip_or_the_base() {
    let (roots, outcome) = after(Change::RemoveStretch { from: at(10.0, 0.0, 20.0), to: at(25.0, 0.0, 20.0) });
    assert!(outcome.applied, "{outcome:?}");
    unchanged(&roots, &[0, 2, 4]);
    // The lateral sprang from the stretch that went; what lies beyond is a root of its own.
    assert_eq!(table(&roots)[1..], [(1, 0, 1, 10), (2, 0, 1, 40), (3, -1, 2, 30), (4, -1, 1, 17), (5, -1, 1, 15)]);
    let (roots, _) = after(Change::RemoveStretch { from: at(25.0, 0.0, 20.0), to: at(40.0, 0.0, 20.0) });
    unchanged(&roots, &[0, 2, 3, 4]);
    assert_eq!(table(&roots)[1], (1, 0, 1, 25));
    let (roots, _) = after(Change::RemoveStretch { from: at(0.0, 0.0, 0.0), to: at(0.0, 0.0, 10.0) });
    unchanged(&roots, &[1, 2, 3, 4]);
    assert_eq!(table(&roots)[0], (0, -1, 0, 70));
}

#[test]
fn a_cut_leaves_the_far_part_as_a_root() {
    let (roots, outcome) = after(Change::Cut { at: at(0.0, 0.0, 30.0) });
    assert!(outcome.applied);
    unchanged(&roots, &[1, 3, 4]);
    assert_eq!(
        table(&roots),
        [(0, -1, 0, 30), (1, 0, 1, 40), (2, 5, 1, 40), (3, 1, 2, 30), (4, -1, 1, 17), (5, -1, 0, 50)]
    );
    assert!(!after(Change::Cut { at: at(40.0, 0.0, 20.0) }).1.applied, "nothing lies beyond a tip");
}

#[test]
fn ends_are_joined_whichever_is_named_first() {
    let (tip, base) = (at(40.0, 0.0, 20.0), at(43.0, 0.0, 20.0));
    for (from, to) in [(tip, base), (base, tip)] {
        let (roots, outcome) = after(Change::Join { from, to });
        assert!(outcome.applied && outcome.found.contains("3.0 mm between"), "{outcome:?}");
        unchanged(&roots, &[0, 2, 3]);
        assert_eq!(table(&roots)[1], (1, 0, 1, 60));
        assert_eq!(roots.len(), 4);
    }
    // Tip to tip: the second is turned round.
    let (roots, _) = after(Change::Join { from: tip, to: at(60.0, 0.0, 20.0) });
    assert_eq!(table(&roots)[1], (1, 0, 1, 40 + 20 + 17));
    // What would run in a ring is refused.
    let (_, outcome) = after(Change::Join { from: at(20.0, 30.0, 20.0), to: at(40.0, 0.0, 20.0) });
    assert!(!outcome.applied && outcome.found.contains("springs from"), "{outcome:?}");
}

#[test]
fn a_root_takes_another_parent_and_its_laterals_follow_its_order() {
    let (roots, outcome) = after(Change::Parent { at: at(50.0, 0.0, 20.0), parent: at(20.0, 25.0, 20.0) });
    assert!(outcome.applied, "{outcome:?}");
    unchanged(&roots, &[0, 1, 2, 3]);
    assert_eq!(table(&roots)[4], (4, 3, 3, 17), "too far to be led");
    let (roots, _) = after(Change::Parent { at: at(50.0, 0.0, 20.0), parent: at(39.0, 0.0, 20.0) });
    assert_eq!(table(&roots)[4], (4, 1, 2, 21), "led from its parent over 4 mm");
    unchanged(&roots, &[0, 1, 2, 3]);
    let (roots, _) = after(Change::Parent { at: at(30.0, 0.0, 20.0), parent: at(-1.0, 0.0, 40.0) });
    let of = |id: i64| table(&roots).into_iter().find(|r| r.0 == id).map(|r| (r.1, r.2));
    assert_eq!((of(1), of(3)), (Some((2, 2)), Some((1, 3))));
    let (_, outcome) = after(Change::Parent { at: at(30.0, 0.0, 20.0), parent: at(20.0, 20.0, 20.0) });
    assert!(!outcome.applied && outcome.found.contains("springs from it"), "{outcome:?}");
}

#[test]
fn an_order_is_set_and_followed() {
    let (roots, outcome) = after(Change::Order { at: at(30.0, 0.0, 20.0), order: 2 });
    assert!(outcome.applied);
    unchanged(&roots, &[0, 2, 4]);
    assert_eq!(table(&roots)[1..4], [(1, 0, 2, 40), (2, 0, 1, 40), (3, 1, 3, 30)]);
}

#[test]
fn the_base_may_be_any_end() {
    // From the lateral's tip: it leads to the taproot, which is cut where the lateral sprang.
    let (roots, outcome) = after(Change::Base { at: at(40.0, 0.0, 20.0) });
    assert!(outcome.applied, "{outcome:?}");
    unchanged(&roots, &[4]);
    assert_eq!(
        table(&roots),
        [(0, 1, 1, 20), (1, -1, 0, 40), (2, 5, 2, 40), (3, 1, 1, 30), (4, -1, 1, 17), (5, 1, 1, 60)]
    );
    let up = roots.iter().find(|r| r.root.id == 0).unwrap();
    assert_eq!((up.root.points_mm[0], up.root.points_mm[up.root.points_mm.len() - 1][2]), ([0.0, 0.0, 20.0], 0.0));
    // From the taproot's own tip: only its direction changes.
    let (roots, _) = after(Change::Base { at: at(0.0, 0.0, 80.0) });
    unchanged(&roots, &[1, 2, 3, 4]);
    assert_eq!(roots[0].root.points_mm[0], [0.0, 0.0, 80.0]);
    // Of another root the old base is no base any more.
    let (roots, _) = after(Change::Base { at: at(60.0, 0.0, 20.0) });
    let order = |id: i64| roots.iter().find(|r| r.root.id == id).map(|r| r.root.order);
    assert_eq!([0, 1, 2, 3, 4].map(order), [1, 2, 2, 3, 0].map(Some));
}

#[test]
fn of_ends_at_one_place_the_free_one_is_meant() {
    let mut roots = plant();
    roots.push(root(5, 0, 1, &[[0.0, 0.0, 0.0], [30.0, 0.0, 5.0]]));
    let system = RootSystem { roots, spread_px: Some(1.0), repairs: Vec::new() };
    let world = World { ray: &blind, evidence: None, params: CorrectionParams::default() };
    let base = |x| vec![made(Change::Base { at: at(x, 0.0, 0.0) })];
    let (_, outcomes) = correct(system.clone(), &base(0.0), &world).unwrap();
    assert!(outcomes[0].applied && outcomes[0].found.contains("80.0 mm long"), "{outcomes:?}");
    // Two free ends are told apart by nothing.
    let mut both = system;
    both.roots[5].root.parent = -1;
    let (_, outcomes) = correct(both, &base(0.0), &world).unwrap();
    assert!(!outcomes[0].applied && outcomes[0].found.contains("two ends of roots"), "{outcomes:?}");
}

#[test]
fn a_checked_root_stays_as_it_is() {
    let (roots, outcome) = after(Change::Checked { at: at(30.0, 0.0, 20.0) });
    assert!(outcome.applied);
    unchanged(&roots, &[0, 1, 2, 3, 4]);
}

#[test]
fn what_finds_no_place_or_two_is_reported_and_changes_nothing() {
    let changes = [
        (Change::Remove { at: at(10.0, 5.0, 20.0) }, "the nearest is 5.0 mm away"),
        (Change::Remove { at: at(0.0, 0.0, 20.0) }, "two roots are"),
        (Change::Join { from: at(30.0, 0.0, 20.0), to: at(43.0, 0.0, 20.0) }, "no end of a root within 1 mm"),
        (Change::RemoveStretch { from: at(10.0, 0.0, 20.0), to: at(0.0, 0.0, 10.0) }, "two roots"),
        (Change::Parent { at: at(30.0, 0.0, 20.0), parent: at(30.0, 9.0, 9.0) }, "no root within"),
        (Change::Base { at: at(0.0, 0.0, 50.0) }, "no end"),
        (
            Change::Add {
                through: vec![Spot::Place(at(5.0, 0.2, 20.0)), Spot::Place(at(30.0, 0.2, 20.0))],
                diameter_mm: None,
                tie: Tie::Free,
            },
            "already runs",
        ),
    ];
    for (change, why) in changes {
        let (roots, outcome) = after(change);
        assert!(!outcome.applied && outcome.found.contains(why), "{outcome:?}");
        unchanged(&roots, &[0, 1, 2, 3, 4]);
        assert_eq!(roots.len(), 5);
    }
}

#[test]
fn a_root_is_added_through_places_and_hangs_on_its_parent() {
    let through = [at(1.0, 2.0, 60.0), at(1.0, 20.0, 62.0)].map(Spot::Place).to_vec();
    let add = Change::Add { through, diameter_mm: Some(0.6), tie: Tie::Parent(at(0.0, 0.0, 60.0)) };
    let (roots, outcome) = after(add);
    assert!(outcome.applied, "{outcome:?}");
    unchanged(&roots, &[0, 1, 2, 3, 4]);
    let added = &roots[5].root;
    assert_eq!((added.id, added.parent, added.order, added.points_mm[0]), (5, 0, 1, [0.0, 0.0, 60.0]));
    assert!(added.radii_mm.iter().all(|r| (r - 0.3).abs() < 1e-12));
}

#[test]
fn a_root_goes_on_in_what_is_added() {
    let through = [at(20.0, 31.0, 20.0), at(20.0, 50.0, 20.0)].map(Spot::Place).to_vec();
    let add = |end: Vec3| Change::Add { through: through.clone(), diameter_mm: None, tie: Tie::Continues(end) };
    let (roots, outcome) = after(add(at(20.0, 30.0, 20.0)));
    assert!(outcome.applied, "{outcome:?}");
    unchanged(&roots, &[0, 1, 2, 4]);
    assert_eq!((roots.len(), table(&roots)[3]), (5, (3, 1, 2, 50)));
    let (roots, outcome) = after(add(at(20.0, 20.0, 20.0)));
    assert!(!outcome.applied && outcome.found.contains("no end"), "{outcome:?}");
    unchanged(&roots, &[0, 1, 2, 3, 4]);
}

#[test]
fn an_added_root_is_triangulated_and_moved_onto_the_evidence() {
    use crate::optics::{Index, Tank, trace};
    use crate::volume::Grid;
    let tank = Tank {
        radius_mm: 90.0,
        height_mm: 200.0,
        wall_mm: 5.0,
        water_level_mm: 5.0,
        index: Index::default(),
        belts_mm: vec![],
    };
    // Rays of two cameras, right angles apart, aimed by bisection at the true places shifted 0.5 mm upwards.
    let camera = [at(480.0, 0.0, 100.0), at(0.0, 480.0, 100.0)];
    let aim = |n: usize, to: &Vec3| -> WaterRay {
        let mut target = *to;
        for _ in 0..60 {
            let ray = trace(&tank, &camera[n], &(target - camera[n]).normalize()).unwrap();
            target += (to - ray.p2_mm) - ray.v2 * (to - ray.p2_mm).dot(&ray.v2);
        }
        trace(&tank, &camera[n], &(target - camera[n]).normalize()).unwrap()
    };
    let places = [at(-20.0, -30.0, 60.0), at(-20.0, -30.0, 90.0), at(-20.0, -30.0, 120.0)];
    let ray = |s: &Sighting| {
        let place = places[s.px[0] as usize] + at(0.5, 0.0, 0.0);
        let beside = at(0.0, 0.0, if s.px[1] > 0.0 { 3.0 } else { 0.0 });
        Ok(Some(aim(usize::from(s.photo == "b"), &(place + beside))))
    };
    let grid = Grid { origin_mm: [-30.0, -40.0, 50.0], spacing_mm: 0.5, shape: [160, 41, 41] };
    let rootness = ndarray::Array3::from_shape_fn((160, 41, 41), |(k, j, i)| {
        let p = grid.point_mm(k as f64, j as f64, i as f64);
        (-((p.x + 20.0).powi(2) + (p.y + 30.0).powi(2))).exp() as f32
    });
    let world = World {
        ray: &ray,
        evidence: Some(Evidence { field: Field { grid, rootness: rootness.view() }, floor: 0.2 }),
        params: CorrectionParams::default(),
    };
    let through = |beside: f64| -> Vec<Spot> {
        let seen = |n: usize, photo: &str, beside| Sighting { photo: photo.into(), px: [n as f64, beside] };
        (0..3).map(|n| Spot::Seen(vec![seen(n, "a", 0.0), seen(n, "b", beside)])).collect()
    };
    let added = |beside: f64| {
        let change = Change::Add { through: through(beside), diameter_mm: None, tie: Tie::Free };
        let system = RootSystem { roots: plant(), spread_px: None, repairs: Vec::new() };
        correct(system, &[made(change)], &world).unwrap()
    };
    let (system, outcomes) = added(0.0);
    assert!(outcomes[0].applied, "{outcomes:?}");
    let root = &system.roots.last().unwrap().root;
    let off = |p: &[f64; 3]| (p[0] + 20.0).hypot(p[1] + 30.0);
    assert!(root.points_mm.iter().all(|p| off(p) < 0.15), "moved onto the crest: {:?}", root.points_mm);
    assert!(outcomes[0].found.contains("100 % of it along evidence"), "{outcomes:?}");
    let ids: Vec<i64> = system.roots.iter().map(|r| r.root.id).collect();
    assert_eq!(ids, [0, 1, 2, 3, 4, 5], "the others keep their places");
    let (system, outcomes) = added(1.0);
    assert!(!outcomes[0].applied && outcomes[0].found.contains("beside each other"), "{outcomes:?}");
    assert_eq!(system.roots.len(), 5);
}

/// The wanted roots, and what becomes of the plant by the corrections that are read off.
fn led_to(wanted: &[TracedRoot]) -> (Vec<TracedRoot>, Vec<Change>) {
    let plain: Vec<Root> = wanted.iter().map(|r| r.root.clone()).collect();
    let changes = difference::difference(&plant(), &plain, CorrectionParams::default()).unwrap();
    let list: Vec<Correction> = changes.iter().cloned().map(made).collect();
    let system = RootSystem { roots: plant(), spread_px: None, repairs: Vec::new() };
    let world = World { ray: &blind, evidence: None, params: CorrectionParams { snap_mm: 0.0, ..Default::default() } };
    let (system, outcomes) = correct(system, &list, &world).unwrap();
    assert!(outcomes.iter().all(|o| o.applied), "{outcomes:?}");
    (system.roots, changes)
}

#[test]
fn corrections_read_off_lead_to_what_is_wanted() {
    assert!(led_to(&plant()).1.is_empty(), "nothing to correct");
    // Another program numbers as it likes: the wanted roots are known by place alone.
    let wanted = vec![
        root(10, -1, 0, &[[0.0, 0.0, 0.0], [0.0, 0.0, 80.0]]),
        // Goes on in what stood alone.
        root(11, 10, 1, &[[0.0, 0.0, 20.0], [60.0, 0.0, 20.0]]),
        // Ends earlier, and what lay beyond hangs on a new root.
        root(12, 10, 1, &[[0.0, 0.0, 40.0], [-20.0, 0.0, 40.0]]),
        root(13, 10, 1, &[[0.0, 0.0, 60.0], [-24.0, 0.0, 60.0], [-24.0, 0.0, 38.0]]),
        root(14, 13, 2, &[[-24.0, 0.0, 40.0], [-40.0, 0.0, 40.0]]),
    ];
    let (roots, changes) = led_to(&wanted);
    let kinds: Vec<&str> = changes.iter().map(Change::kind).collect();
    for kind in ["cut", "add", "join", "parent", "remove"] {
        assert!(kinds.contains(&kind), "{kinds:?}");
    }
    assert_eq!(roots.len(), wanted.len(), "{:?}", table(&roots));
    for want in &wanted {
        let tip = Vec3::from(want.root.points_mm[want.root.points_mm.len() - 1]);
        let near = |r: &&TracedRoot| (Vec3::from(r.root.points_mm[r.root.points_mm.len() - 1]) - tip).norm() < 2.1;
        let have = roots.iter().find(near).unwrap_or_else(|| panic!("{want:?}: {:?}", table(&roots)));
        let parent = |r: &TracedRoot, all: &[TracedRoot]| {
            let of = all.iter().find(|p| p.root.id == r.root.parent);
            of.map(|p| p.root.points_mm[p.root.points_mm.len() - 1].map(|x| (x / 5.0).round() as i64))
        };
        assert_eq!(
            (have.root.order, parent(have, &roots)),
            (want.root.order, parent(want, &wanted)),
            "{:?}",
            table(&roots)
        );
    }
}

#[test]
fn a_tip_that_ran_on_is_ended_and_one_that_is_near_is_left() {
    let led = |length: f64| {
        let mut wanted = plant();
        wanted[3] = root(3, 1, 2, &[[20.0, 0.0, 20.0], [20.0, length, 20.0]]);
        let (roots, changes) = led_to(&wanted);
        let tip = roots.iter().find(|r| r.root.id == 3).and_then(|r| r.root.points_mm.last().copied()).unwrap();
        (tip[1], changes.iter().map(Change::kind).collect::<Vec<_>>())
    };
    let (tip, kinds) = led(27.0);
    assert!(kinds == ["remove-stretch"] && (tip - 27.0).abs() < 0.6, "{kinds:?}: {tip}");
    assert_eq!(led(28.5), (30.0, vec![]));
    // The other way round what is missing is added.
    let (tip, kinds) = led(33.0);
    assert!(kinds == ["add"] && (tip - 33.0).abs() < 0.6, "{kinds:?}: {tip}");
}

#[test]
fn a_new_start_of_the_base_root_takes_its_order() {
    let mut wanted = plant();
    wanted[0] = root(0, -1, 0, &[[0.0, 0.0, -20.0], [0.0, 0.0, 80.0]]);
    let (roots, changes) = led_to(&wanted);
    let kinds: Vec<&str> = changes.iter().map(Change::kind).collect();
    assert_eq!(kinds, ["add", "join"]);
    let mut orders: Vec<u32> = roots.iter().map(|r| r.root.order).collect();
    orders.sort_unstable();
    assert_eq!(orders, [0, 1, 1, 1, 2]);
}
