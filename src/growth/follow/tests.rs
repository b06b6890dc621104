use super::*;

/// A root of straight stretches through corners, a point per millimetre, 1 mm thick.
fn root(id: i64, parent: i64, corners: &[[f64; 3]]) -> Root {
    let mut points_mm = vec![corners[0]];
    for pair in corners.windows(2) {
        let length = (0..3).map(|d| (pair[1][d] - pair[0][d]).powi(2)).sum::<f64>().sqrt();
        let steps = length.ceil() as usize;
        let at = |k: usize| std::array::from_fn(|d| pair[0][d] + (pair[1][d] - pair[0][d]) * k as f64 / steps as f64);
        points_mm.extend((1..=steps).map(at));
    }
    let radii_mm = vec![0.5; points_mm.len()];
    Root { id, parent, order: u32::from(parent >= 0), points_mm, radii_mm }
}

fn main(to: f64) -> Root {
    root(0, -1, &[[0.0, 0.0, 20.0], [0.0, 0.0, to]])
}

/// A lateral of `length` from depth `z`, `off` mm beside where it was.
fn lateral(id: i64, z: f64, length: f64, off: f64) -> Root {
    root(id, 0, &[[0.0, off, z], [0.8 * length, off, z + 0.6 * length]])
}

fn traced(root: &Root) -> TracedRoot {
    TracedRoot {
        radius_sd_mm: vec![0.0; root.points_mm.len()],
        views: vec![1; root.points_mm.len()],
        confidence: vec![1.0; root.points_mm.len()],
        root: root.clone(),
    }
}

fn of(growth: &Growth, root: i64, day: usize) -> &Interval {
    growth.intervals.iter().find(|i| i.root == root && i.days[1] == day).unwrap()
}

#[test]
fn roots_keep_their_number_and_grow_at_their_tip() {
    let days = vec![
        (0.0, vec![main(60.0), lateral(1, 30.0, 10.0, 0.0)]),
        // In another order, beside themselves by half a millimetre, one more.
        (2.0, vec![main(72.0), lateral(5, 45.0, 4.0, 0.0), lateral(7, 30.0, 16.0, 0.5)]),
    ];
    let growth = tracked(&days, &FollowParams::default());
    let seen: Vec<_> = growth.tracks.iter().map(|t| t.seen.clone()).collect();
    assert_eq!(seen, [vec![Some(0), Some(0)], vec![Some(1), Some(2)], vec![None, Some(1)]]);
    assert_eq!(growth.tracks.iter().map(|t| t.parent).collect::<Vec<_>>(), [-1, 0, 0]);
    assert!((of(&growth, 0, 1).elongation_mm.unwrap() - 12.0).abs() < 0.1 && of(&growth, 0, 1).new_laterals == 1);
    assert!((of(&growth, 1, 1).elongation_mm.unwrap() - 6.0).abs() < 0.4, "{:?}", of(&growth, 1, 1));
    assert_eq!((of(&growth, 2, 1).state, of(&growth, 1, 1).state), (State::Appeared, State::Followed));
    assert!(of(&growth, 0, 1).diameter_change_mm.unwrap().abs() < 1e-9 && of(&growth, 2, 1).elongation_mm.is_none());
}

#[test]
fn points_know_the_day_they_came() {
    let mut days = [
        (0.0, vec![traced(&main(60.0))]),
        (2.0, vec![traced(&main(72.0)), traced(&lateral(5, 45.0, 4.0, 0.0))]),
        (5.0, vec![traced(&main(80.0)), traced(&lateral(3, 45.0, 9.0, 0.3))]),
    ];
    let growth = follow(&mut days, &FollowParams::default());
    let named: Vec<_> = days.iter().enumerate().map(|(n, (_, roots))| growth.day(n, roots)).collect();
    let times = emerged(&named, &[0.0, 2.0, 5.0], 2);
    // The main root starts at depth 20, a point per millimetre.
    let came = |time: f64| times[0].iter().filter(|t| **t == time).count();
    assert_eq!([came(0.0), came(2.0), came(5.0)], [41, 12, 8]);
    assert!(times[1].iter().all(|t| *t > 0.0) && times[1][2] == 2.0 && times[1][8] == 5.0, "{:?}", times[1]);
    assert_eq!(emerged(&named, &[0.0, 2.0, 5.0], 0), [vec![0.0; 41]]);
}

#[test]
fn what_vanishes_is_told_and_known_again_when_it_comes_back() {
    let days = vec![
        (0.0, vec![main(60.0), lateral(1, 30.0, 10.0, 0.0)]),
        (1.0, vec![main(65.0)]),
        (2.0, vec![main(70.0), lateral(3, 30.0, 14.0, 0.0)]),
    ];
    let growth = tracked(&days, &FollowParams::default());
    assert_eq!(growth.tracks.len(), 2);
    assert_eq!(of(&growth, 1, 1).state, State::Vanished);
    let back = of(&growth, 1, 2);
    assert!(
        back.state == State::Followed && back.days == [0, 2] && (back.elongation_mm.unwrap() - 4.0).abs() < 0.3,
        "{back:?}"
    );
    let again: Growth = serde_json::from_str(&serde_json::to_string(&growth).unwrap()).unwrap();
    assert_eq!(again.tracks, growth.tracks);
}

#[test]
fn a_lateral_on_its_parent_is_not_its_parent() {
    let days =
        vec![(0.0, vec![main(60.0), lateral(1, 30.0, 3.0, 0.0)]), (1.0, vec![main(65.0), lateral(2, 34.5, 3.0, 0.0)])];
    let growth = tracked(&days, &FollowParams::default());
    assert_eq!(growth.tracks.len(), 3, "{:?}", growth.tracks);
    assert_eq!(of(&growth, 1, 1).state, State::Vanished);
}

#[test]
fn a_day_speaks_in_common_numbers() {
    let days = vec![(0.0, vec![main(60.0)]), (1.0, vec![lateral(4, 30.0, 9.0, 0.0), main(66.0)])];
    let growth = tracked(&days, &FollowParams::default());
    let named = growth.day(1, &days[1].1.iter().map(traced).collect::<Vec<_>>());
    let numbers: Vec<_> = named.iter().map(|r| (r.root.id, r.root.parent)).collect();
    assert_eq!(numbers, [(1, 0), (0, -1)]);
}

/// The main root down to `to` and a lateral at depth 40, as a wrong day has them: the root goes on into the lateral.
fn swapped(to: f64, length: f64) -> Vec<Root> {
    let fork = [0.0, 0.0, 40.0];
    vec![
        root(0, -1, &[[0.0, 0.0, 20.0], fork, [0.8 * length, 0.0, 40.0 + 0.6 * length]]),
        root(1, 0, &[fork, [0.0, 0.0, to]]),
    ]
}

fn right(to: f64, length: f64) -> Vec<Root> {
    vec![main(to), lateral(1, 40.0, length, 0.0)]
}

#[test]
fn days_that_know_tell_which_branch_goes_on() {
    let day = |roots: Vec<Root>| roots.iter().map(traced).collect::<Vec<_>>();
    // The lateral was not there yet; both were there, and the later day counts.
    let cases = [(vec![main(55.0)], swapped(66.0, 12.0), 1), (swapped(60.0, 12.0), right(80.0, 20.0), 0)];
    for (first, second, wrong) in cases {
        let mut days = [(0.0, day(first)), (2.0, day(second))];
        let growth = follow(&mut days, &FollowParams::default());
        assert_eq!((growth.rehung.len(), growth.rehung[0].day), (1, wrong));
        let main = days[wrong].1.iter().find(|r| r.root.parent < 0).unwrap();
        assert!(main.root.points_mm.iter().all(|p| p[0] < 0.5) && main.views.len() == main.root.points_mm.len());
        let track = growth.tracks.iter().find(|t| t.parent < 0).unwrap();
        assert!(track.seen.iter().all(Option::is_some) && growth.tracks.len() == 2, "{:?}", growth.tracks);
    }
    // A root that was there alone stays, whatever a later day says.
    let mut days = [(0.0, day(vec![main(55.0)])), (1.0, day(right(60.0, 10.0))), (2.0, day(swapped(70.0, 16.0)))];
    let growth = follow(&mut days, &FollowParams::default());
    assert!(growth.rehung.iter().all(|r| r.day == 2) && growth.tracks.len() == 2, "{growth:?}");
}

#[test]
fn laterals_go_with_the_tail_that_bears_them() {
    let mut all = swapped(70.0, 20.0);
    // One on the lateral's tail, one on the main root's lower part.
    all.push(root(2, 0, &[[8.0, 0.0, 46.0], [8.0, 6.0, 46.0]]));
    all.push(root(3, 1, &[[0.0, 0.0, 60.0], [0.0, 6.0, 63.0]]));
    let mut days = [(0.0, vec![traced(&main(52.0))]), (1.0, all.iter().map(traced).collect())];
    follow(&mut days, &FollowParams::default());
    let parents: Vec<_> = days[1].1.iter().map(|r| (r.root.id, r.root.parent, r.root.order)).collect();
    assert_eq!(parents, [(0, -1, 0), (1, 0, 1), (2, 1, 2), (3, 0, 1)]);
}

#[test]
fn a_day_is_read_by_the_next() {
    let day = |roots: Vec<Root>| roots.iter().map(traced).collect::<Vec<_>>();
    // The lateral's tip runs backwards into the main root's lower part, as one root of its own.
    let wrong = vec![
        root(0, -1, &[[0.0, 0.0, 20.0], [0.0, 0.0, 39.0]]),
        root(1, 0, &[[12.0, 0.0, 49.0], [0.0, 0.0, 40.0], [0.0, 0.0, 62.0]]),
    ];
    let mut days = [(0.0, day(wrong)), (3.0, day(right(80.0, 25.0)))];
    let growth = follow(&mut days, &FollowParams::default());
    assert_eq!((growth.tracks.len(), growth.rehung.len(), days[0].1.len()), (2, 1, 2), "{:?}", growth.tracks);
    assert!((of(&growth, 0, 1).elongation_mm.unwrap() - 18.0).abs() < 0.5, "{:?}", growth.intervals);
    assert!((of(&growth, 1, 1).elongation_mm.unwrap() - 10.0).abs() < 0.6, "{:?}", growth.intervals);
    let lateral = &days[0].1[1].root;
    assert!(lateral.parent == days[0].1[0].root.id && lateral.points_mm[0][0] < lateral.points_mm[5][0]);
    // What no root of the next day explains stays as it is.
    let mut days = [(0.0, day(vec![main(60.0), lateral_at(5)])), (1.0, day(vec![main(66.0)]))];
    let growth = follow(&mut days, &FollowParams::default());
    assert!(growth.rehung.is_empty() && days[0].1[1].root == lateral_at(5), "{:?}", days[0].1);
}

fn lateral_at(id: i64) -> Root {
    lateral(id, 30.0, 15.0, 0.0)
}
