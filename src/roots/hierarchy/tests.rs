use super::*;
use crate::roots::Root;
use crate::roots::repair::Kind;
use crate::roots::strand::End;
use crate::roots::tie::Tie;
use crate::roots::trace::{Looks, OutOfSight};
use proptest::prelude::*;

/// A piece through the corners with a point every 0.5 mm; each corner with its radius.
fn piece(corners: &[([f64; 3], f64)]) -> TracedRoot {
    let (mut points_mm, mut radii_mm) = (vec![corners[0].0], vec![corners[0].1]);
    for pair in corners.windows(2) {
        let (a, b) = (Vec3::from(pair[0].0), Vec3::from(pair[1].0));
        let n = ((b - a).norm() / 0.5).round() as usize;
        points_mm.extend((1..=n).map(|k| <[f64; 3]>::from(a + (b - a) * (k as f64 / n as f64))));
        radii_mm.extend((1..=n).map(|_| pair[1].1));
    }
    let n = points_mm.len();
    TracedRoot {
        root: Root { id: 0, parent: -1, order: 0, points_mm, radii_mm },
        radius_sd_mm: vec![0.05; n],
        views: vec![9; n],
        confidence: vec![0.9; n],
    }
}

fn pieces(pieces: Vec<TracedRoot>, ties: Vec<Tie>) -> Pieces {
    Pieces {
        step_mm: 0.5,
        smooth_mm: 6.0,
        link_mm: 2.0,
        looks: vec![Looks { unhindered: 100, showing: 90 }; pieces.len()],
        spread_px: None,
        strengths: vec![1.0; pieces.len()],
        pieces,
        ties,
        out_of_sight: Vec::new(),
        repairs: Vec::new(),
        explained: false,
    }
}

fn tie(strand: usize, end: End, onto: usize, knot: usize, distance_mm: f64) -> Tie {
    Tie { strand, end, onto, knot, distance_mm, cosine: 1.0, support: 1.0 }
}

fn tip(root: &TracedRoot) -> Vec3 {
    Vec3::from(*root.root.points_mm.last().unwrap())
}

/// The ridge of a taproot runs on into a lateral at z = 60; the taproot's lower half begins below.
fn junction() -> Pieces {
    let upper = piece(&[([0.0, 0.0, 20.0], 1.5), ([0.0, 0.0, 60.0], 1.5), ([20.0, 0.0, 75.0], 0.5)]);
    let lower = piece(&[([0.0, 0.0, 61.5], 1.4), ([0.0, 0.0, 110.0], 1.0)]);
    let second = piece(&[([12.0, 0.5, 69.0], 0.3), ([12.0, 10.0, 72.0], 0.3)]);
    let at = 80;
    pieces(vec![upper, lower, second], vec![tie(1, End::First, 0, at, 1.5), tie(2, End::First, 0, at + 30, 0.5)])
}

#[test]
fn a_root_goes_on_straight_and_thick() {
    let system = arrange(&junction(), &HierarchyParams::default()).unwrap();
    let orders: Vec<(i64, u32)> = system.roots.iter().map(|r| (r.root.parent, r.root.order)).collect();
    assert_eq!(orders, [(-1, 0), (0, 1), (1, 2)]);
    assert!((tip(&system.roots[0]) - Vec3::new(0.0, 0.0, 110.0)).norm() < 0.5);
    assert!((tip(&system.roots[1]) - Vec3::new(20.0, 0.0, 75.0)).norm() < 0.5);
    let length = *super::super::curve::chord_lengths(&system.roots[0].root.points_mm).last().unwrap();
    assert!((length - 90.0).abs() < 1.0, "{length}");
    // Laterals start on their parent's line.
    for root in &system.roots[1..] {
        let parent = &system.roots[root.root.parent as usize].root.points_mm;
        let start = Vec3::from(root.root.points_mm[0]);
        assert!(parent.iter().any(|p| (Vec3::from(*p) - start).norm() < 1e-9));
    }
}

#[test]
fn what_photographs_do_not_show_is_left_out() {
    let mut all = junction();
    all.looks[2].showing = 20;
    let system = arrange(&all, &HierarchyParams::default()).unwrap();
    assert_eq!(system.roots.len(), 2);
    assert!(system.repairs.iter().any(|r| r.kind == Kind::Pruned && r.reason.contains("20 %")));
    // Few looks count, no look speaks against it, and without photographs nothing is known.
    all.looks[2] = Looks { unhindered: 3, showing: 2 };
    assert_eq!(arrange(&all, &HierarchyParams::default()).unwrap().roots.len(), 3);
    all.looks[2] = Looks::default();
    assert_eq!(arrange(&all, &HierarchyParams::default()).unwrap().roots.len(), 2);
    all.looks.clear();
    assert_eq!(arrange(&all, &HierarchyParams::default()).unwrap().roots.len(), 3);
}

#[test]
fn a_root_does_not_hang_on_a_tip_that_touches_it() {
    let base = piece(&[([0.0, 0.0, 20.0], 1.5), ([0.0, 0.0, 110.0], 1.0)]);
    // From the crown, out of sight; the lateral of the base touches it with its tip.
    let other = piece(&[([10.0, 0.0, 20.0], 0.6), ([20.0, 0.0, 90.0], 0.4)]);
    let lateral = piece(&[([0.0, 0.0, 50.0], 0.4), ([14.0, 0.0, 52.0], 0.3)]);
    let touch = (other.root.points_mm.len() - 1) * 32 / 70;
    let mut all =
        pieces(vec![base, other, lateral], vec![tie(2, End::First, 0, 60, 1.0), tie(2, End::Last, 1, touch, 0.5)]);
    all.out_of_sight = vec![OutOfSight { piece: 1, end: End::First, way_mm: 1.0, below: false }];
    let system = arrange(&all, &HierarchyParams::default()).unwrap();
    assert_eq!(system.roots.iter().map(|r| r.root.order).collect::<Vec<_>>(), [0, 1, 1]);
    assert!(system.repairs.iter().any(|r| r.kind == Kind::Inferred));
    assert!(system.repairs.iter().any(|r| r.kind == Kind::Opened));
}

#[test]
fn the_base_begins_at_its_uppermost_piece() {
    let mut all = junction();
    all.pieces.push(piece(&[([0.0, 0.0, 19.0], 1.6), ([0.5, 0.0, 8.0], 1.6)]));
    all.looks.push(all.looks[0]);
    all.ties.push(tie(3, End::First, 0, 0, 1.0));
    let system = arrange(&all, &HierarchyParams::default()).unwrap();
    assert_eq!(system.roots.len(), 3);
    assert!((system.roots[0].root.points_mm[0][2] - 8.0).abs() < 0.5);
}

#[test]
fn what_springs_where_two_roots_run_side_by_side_is_the_older_ones() {
    let base = piece(&[([0.0, 0.0, 20.0], 1.0), ([0.0, 0.0, 110.0], 0.8)]);
    // Leaves the base at z = 40, runs along it for 8 mm, and goes away.
    let beside = piece(&[([1.0, 0.0, 40.0], 0.5), ([2.0, 0.0, 48.0], 0.5), ([22.0, 0.0, 60.0], 0.4)]);
    let third = piece(&[([2.5, 0.0, 46.0], 0.3), ([2.5, 20.0, 50.0], 0.2)]);
    let far = piece(&[([12.0, 0.3, 54.0], 0.3), ([12.0, 20.0, 60.0], 0.2)]);
    let system = arrange(
        &pieces(
            vec![base, beside, third, far],
            vec![tie(1, End::First, 0, 40, 1.0), tie(2, End::First, 1, 12, 0.6), tie(3, End::First, 1, 39, 0.5)],
        ),
        &HierarchyParams::default(),
    )
    .unwrap();
    let orders: Vec<(i64, u32)> = system.roots.iter().map(|r| (r.root.parent, r.root.order)).collect();
    assert_eq!(orders, [(-1, 0), (0, 1), (0, 1), (1, 2)]);
    assert!(system.repairs.iter().any(|r| r.kind == Kind::Repaired && r.reason.contains("older")));
}

#[test]
fn a_lateral_hangs_rather_on_the_thicker_of_two_roots_that_it_touches() {
    let base = piece(&[([0.0, 0.0, 20.0], 0.8), ([0.0, 0.0, 110.0], 0.8)]);
    let other = piece(&[([0.0, 0.0, 30.0], 0.4), ([30.0, 0.0, 40.0], 0.3), ([3.4, 0.0, 59.0], 0.2)]);
    let lateral = piece(&[([3.0, 0.0, 60.0], 0.6), ([3.0, 40.0, 75.0], 0.4)]);
    let end = other.root.points_mm.len() - 1;
    let ties = vec![tie(1, End::First, 0, 20, 0.5), tie(2, End::First, 1, end, 0.5), tie(2, End::First, 0, 80, 3.0)];
    let all = pieces(vec![base, other, lateral], ties);
    let orders = |thicker_mm: f64| -> Vec<u32> {
        let params = HierarchyParams { thicker_mm, ..HierarchyParams::default() };
        arrange(&all, &params).unwrap().roots.iter().map(|r| r.root.order).collect()
    };
    assert_eq!(orders(1.0), [0, 1, 1]);
    assert_eq!(orders(0.0), [0, 1], "the nearer one, which then goes on in it");
}

#[test]
fn tips_that_few_photographs_show_are_taken_back() {
    let mut all = junction();
    let lower = &mut all.pieces[1];
    let last = lower.confidence.len();
    lower.confidence[last - 20..].fill(0.2);
    let tip_z =
        |all: &Pieces| arrange(all, &HierarchyParams::default()).unwrap().roots[0].root.points_mm.last().unwrap()[2];
    assert!((tip_z(&all) - 100.0).abs() < 1.0, "{}", tip_z(&all));
    // Nobody was asked.
    all.looks.clear();
    assert!((tip_z(&all) - 110.0).abs() < 0.5);
    // What carries a lateral stays.
    all.looks = vec![Looks { unhindered: 100, showing: 90 }; 4];
    all.pieces.push(piece(&[([0.0, 1.0, 106.0], 0.3), ([0.0, 20.0, 106.0], 0.3)]));
    all.ties.push(tie(3, End::First, 1, 89, 1.0));
    assert!((tip_z(&all) - 106.0).abs() < 1.0, "{}", tip_z(&all));
}

#[test]
fn what_few_photographs_see_past_others_is_left_out() {
    let mut all = junction();
    all.pieces[2].views.fill(2);
    let roots = |all: &Pieces| arrange(all, &HierarchyParams::default()).unwrap().roots.len();
    assert_eq!(roots(&all), 2, "2 of 9 in the median");
    all.pieces[2].views.fill(3);
    assert_eq!(roots(&all), 3);
    // What carries others stays, and where nothing was measured nothing is known.
    all.pieces[1].views.fill(0);
    assert_eq!(roots(&all), 3);
    all.pieces.iter_mut().for_each(|p| p.views.fill(0));
    assert_eq!(roots(&all), 3);
}

#[test]
fn a_root_that_ends_on_another_goes_on_beyond_it() {
    let base = piece(&[([0.0, 0.0, 20.0], 1.0), ([0.0, 0.0, 110.0], 0.8)]);
    let ends = piece(&[([0.0, 0.0, 40.0], 0.5), ([19.0, 0.0, 50.0], 0.5)]);
    let crossed = piece(&[([0.0, 0.0, 30.0], 0.5), ([20.0, 0.0, 30.0], 0.5), ([20.0, 0.0, 90.0], 0.5)]);
    let beyond = |to: [f64; 3], radius: f64| piece(&[([21.0, 0.0, 51.0], radius), (to, radius)]);
    let run = |beyond: TracedRoot| {
        let ties = vec![tie(1, End::First, 0, 40, 0.0), tie(2, End::First, 0, 20, 0.0), tie(3, End::First, 2, 82, 1.0)];
        arrange(&pieces(vec![base.clone(), ends.clone(), crossed.clone(), beyond], ties), &HierarchyParams::default())
    };
    let system = run(beyond([40.0, 0.0, 61.0], 0.45)).unwrap();
    assert_eq!(system.roots.iter().map(|r| r.root.order).collect::<Vec<_>>(), [0, 1, 1]);
    assert!(system.roots.iter().any(|r| (tip(r) - Vec3::new(40.0, 0.0, 61.0)).norm() < 0.5));
    assert!(system.repairs.iter().any(|r| r.kind == Kind::Repaired && r.reason.contains("goes on in another")));
    // Within 75 degrees; more, or much thicker, and it is another root.
    assert_eq!(run(beyond([40.0, 0.0, 36.0], 0.45)).unwrap().roots.len(), 3);
    assert_eq!(run(beyond([15.0, 30.0, 40.0], 0.45)).unwrap().roots.len(), 4);
    assert_eq!(run(beyond([40.0, 0.0, 61.0], 0.9)).unwrap().roots.len(), 4);
}

#[test]
fn a_root_goes_on_in_a_tip_that_it_meets_and_in_a_lateral_at_its_tip() {
    let base = piece(&[([0.0, 0.0, 20.0], 1.0), ([0.0, 0.0, 110.0], 0.8)]);
    let other = piece(&[([0.0, 0.0, 30.0], 0.6), ([60.0, 0.0, 30.0], 0.6)]);
    // What meets the tip of the first hangs by its far end; a lateral springs just before that end, and goes on beyond.
    let first = piece(&[([0.0, 0.0, 50.0], 0.5), ([20.0, 0.0, 50.0], 0.5)]);
    let met = piece(&[([45.0, 0.0, 31.0], 0.5), ([40.0, 0.0, 48.0], 0.5), ([21.5, 0.0, 50.0], 0.5)]);
    let ties = vec![tie(1, End::First, 0, 20, 0.0), tie(2, End::First, 0, 60, 0.0), tie(3, End::First, 1, 90, 0.5)];
    let system =
        arrange(&pieces(vec![base.clone(), other.clone(), first.clone(), met], ties), &HierarchyParams::default())
            .unwrap();
    assert_eq!(system.roots.iter().map(|r| r.root.order).collect::<Vec<_>>(), [0, 1, 1]);
    assert!(system.roots.iter().any(|r| (tip(r) - Vec3::new(45.0, 0.0, 31.0)).norm() < 0.5));

    // Tips that pass each other side by side are two.
    let aside = piece(&[([45.0, 0.0, 31.0], 0.5), ([40.0, 2.5, 48.0], 0.5), ([19.0, 2.5, 50.0], 0.5)]);
    let ties = vec![tie(1, End::First, 0, 20, 0.0), tie(2, End::First, 0, 60, 0.0), tie(3, End::First, 1, 90, 0.5)];
    let all = pieces(vec![base.clone(), other, first, aside], ties);
    assert_eq!(arrange(&all, &HierarchyParams::default()).unwrap().roots.len(), 4);

    let hook = piece(&[([0.0, 0.0, 50.0], 0.5), ([20.0, 0.0, 50.0], 0.5), ([20.5, 2.2, 50.0], 0.5)]);
    let on = piece(&[([20.3, 0.6, 50.2], 0.4), ([40.0, 0.0, 54.0], 0.4)]);
    let run = |at: usize| {
        let ties = vec![tie(1, End::First, 0, 60, 0.0), tie(2, End::First, 1, at, 0.3)];
        arrange(&pieces(vec![base.clone(), hook.clone(), on.clone()], ties), &HierarchyParams::default()).unwrap()
    };
    let system = run(41);
    assert_eq!(system.roots.len(), 2);
    assert!((tip(&system.roots[1]) - Vec3::new(40.0, 0.0, 54.0)).norm() < 0.5);
}

#[test]
fn a_line_through_a_thicker_root_is_two_laterals() {
    let base = piece(&[([0.0, 0.0, 20.0], 1.5), ([0.0, 0.0, 110.0], 1.5)]);
    let thin = piece(&[([0.0, 0.0, 40.0], 0.15), ([-9.0, 0.0, 58.0], 0.15), ([-9.0, 20.0, 70.0], 0.15)]);
    // Its end, thinner than its middle, touches the thin one.
    let through = piece(&[([-8.5, 0.0, 58.5], 0.3), ([0.0, 0.0, 60.0], 0.3), ([30.0, 0.0, 70.0], 0.8)]);
    let ties = vec![tie(1, End::First, 0, 40, 0.0), tie(2, End::First, 1, 40, 0.5)];
    let system = arrange(&pieces(vec![base, thin, through], ties), &HierarchyParams::default()).unwrap();
    let parent_of = |to: Vec3| system.roots.iter().find(|r| (tip(r) - to).norm() < 1.0).map(|r| r.root.parent);
    assert_eq!(parent_of(Vec3::new(30.0, 0.0, 70.0)), Some(0));
    assert_eq!(parent_of(Vec3::new(-8.5, 0.0, 58.5)), Some(0));
}

#[test]
fn spurs_and_specks_go_and_nothing_gives_nothing() {
    let mut all = junction();
    all.pieces.push(piece(&[([-1.5, 0.0, 40.0], 0.3), ([-3.0, 0.0, 40.0], 0.3)]));
    all.ties.push(tie(3, End::First, 0, 40, 1.5));
    all.pieces.push(piece(&[([40.0, 0.0, 40.0], 0.3), ([43.0, 0.0, 40.0], 0.3)]));
    all.looks.extend([all.looks[0]; 2]);
    let system = arrange(&all, &HierarchyParams::default()).unwrap();
    assert_eq!(system.roots.len(), 3);
    assert_eq!(system.repairs.iter().filter(|r| r.kind == Kind::Pruned).count(), 2);
    assert!(arrange(&pieces(Vec::new(), Vec::new()), &HierarchyParams::default()).unwrap().roots.is_empty());
    let faulty = HierarchyParams { bend_deg: f64::NAN, ..HierarchyParams::default() };
    assert!(arrange(&junction(), &faulty).is_err());
}

#[test]
fn a_root_that_comes_back_to_the_one_that_it_hangs_on_is_no_spur() {
    let mut all = junction();
    let back = [[-1.0, 0.0, 40.0], [-20.0, 0.0, 45.0], [-20.0, 0.0, 55.0], [-1.5, 0.0, 60.0]];
    all.pieces.push(piece(&back.map(|p| (p, 0.3))));
    all.ties.push(tie(3, End::First, 0, 40, 1.0));
    all.looks.push(all.looks[0]);
    let system = arrange(&all, &HierarchyParams::default()).unwrap();
    assert_eq!(system.roots.len(), 4);
}

#[test]
fn what_hangs_on_a_stub_is_not_lost() {
    // The lateral springs 1.5 mm before the piece's end, on which the taproot's long rest hangs.
    let top = piece(&[([0.0, 0.0, 20.0], 1.0), ([0.0, 0.0, 60.0], 1.0)]);
    let lateral = piece(&[([0.0, 0.8, 58.5], 0.4), ([0.0, 15.0, 60.0], 0.4)]);
    let rest = piece(&[([0.0, 0.0, 61.0], 0.9), ([0.0, 0.0, 110.0], 0.7)]);
    let ties = vec![tie(1, End::First, 0, 77, 0.8), tie(2, End::First, 0, 80, 1.0)];
    let system = arrange(&pieces(vec![top, lateral, rest], ties), &HierarchyParams::default()).unwrap();
    assert_eq!(system.roots.len(), 2);
    assert!((tip(&system.roots[0]) - Vec3::new(0.0, 0.0, 110.0)).norm() < 0.5);
}

proptest! {
    #[test]
    fn every_piece_is_in_a_root(
        lengths in prop::collection::vec(2.0f64..40.0, 2..9),
        hung in prop::collection::vec((0usize..9, 0.0f64..1.0, 0usize..4, 0.0f64..1.0), 9),
    ) {
        let straight = |(n, &mm): (usize, &f64)| {
            let (sin, cos) = (2.4 * n as f64).sin_cos();
            piece(&[([n as f64, 0.0, 20.0], 0.5), ([n as f64 + 0.6 * mm * cos, 0.6 * mm * sin, 20.0 + 0.8 * mm], 0.5)])
        };
        let all = pieces(lengths.iter().enumerate().map(straight).collect(), Vec::new());
        let lines: Vec<Line<'_>> = all.pieces.iter().map(Line::new).collect();
        // Many hang near ends.
        let at = |line: &Line<'_>, share: f64| ((line.last() as f64) * share.powi(4)).round() as usize;
        let hangs: Vec<attach::Hang> = (0..lines.len())
            .map(|n| {
                let (parent, share, side, own) = hung[n];
                if n == 0 {
                    return attach::Hang::Free;
                }
                let parent = parent % n;
                let (knot, point) = (at(&lines[parent], share), at(&lines[n], own));
                let parent_point = if side & 1 == 0 { knot } else { lines[parent].last() - knot };
                let point = if side & 2 == 0 { point } else { lines[n].last() - point };
                attach::Hang::On { parent, parent_point, point }
            })
            .collect();
        let grown = walk::walk(&lines, 0, &hangs, &all, &HierarchyParams::default());
        for n in 0..lines.len() {
            prop_assert!(grown.iter().any(|g| g.parts.iter().any(|p| p.piece == n)), "piece {n} of {hangs:?}");
        }
    }
}

/// Four roots out of sight upwards, the first of them as thick as given, and one that parts from the second at 30 mm.
fn bush(base_mm: f64) -> Pieces {
    let down = |x: f64, radius: f64| piece(&[([x, 0.0, 20.0], radius), ([4.0 * x, 0.0, 120.0], radius)]);
    let parting = piece(&[([11.0, 0.0, 30.0], 0.5), ([11.0, 40.0, 100.0], 0.5)]);
    let all = vec![down(0.0, base_mm), down(10.0, 0.5), down(-10.0, 0.5), parting, down(-14.0, 0.5)];
    let mut bush = pieces(all, vec![tie(3, End::First, 1, 20, 1.0)]);
    let above = |piece: usize| OutOfSight { piece, end: End::First, way_mm: 0.0, below: false };
    bush.out_of_sight = [0, 1, 2, 4].map(above).to_vec();
    bush
}

fn orders(pieces: &Pieces) -> Vec<(i64, u32)> {
    arrange(pieces, &HierarchyParams::default()).unwrap().roots.iter().map(|r| (r.root.parent, r.root.order)).collect()
}

#[test]
fn a_plant_without_a_taproot_stands_on_several_roots() {
    assert_eq!(orders(&bush(0.55)), [(-1, 0); 5]);
    // One or two of them may as well be laterals.
    let mut few = bush(0.55);
    few.out_of_sight.pop();
    assert_eq!(orders(&few).iter().filter(|o| **o == (-1, 0)).count(), 1);
}

#[test]
fn beside_a_taproot_crown_roots_are_laterals() {
    assert_eq!(orders(&bush(0.85)), [(-1, 0), (0, 1), (0, 1), (0, 1), (1, 2)]);
}

#[test]
fn what_springs_below_the_crown_or_is_thin_is_a_lateral_in_a_bush() {
    let mut low = bush(0.55);
    low.pieces[3] = piece(&[([22.0, 0.0, 60.0], 0.5), ([22.0, 40.0, 100.0], 0.5)]);
    low.ties[0].knot = 80;
    let mut thin = bush(0.55);
    thin.pieces[3].root.radii_mm.fill(0.3);
    for bush in [low, thin] {
        assert_eq!(orders(&bush).iter().filter(|o| o.1 == 0).count(), 4);
        assert!(orders(&bush).iter().any(|o| o.1 == 1 && o.0 >= 0));
    }
}
