//! How well roots are followed over five days: the figures of docs/trials.md. `cargo bench --bench following`.
//!
//! Plants of some forty roots on the last day grow over five days, two days apart. Every day sways otherwise, [`SWAY_MM`] at the most,
//! and lists its roots in another order under other numbers. What is judged is the following alone: nothing is photographed or
//! traced, and days stand in one frame.
//!
//! - identity: of the roots that are there on a day and on the one before, the share that has one number on both;
//! - elongation: median of the error relative to the true elongation, of roots that elongated by [`TOLD_MM`] at least;
//! - false births: roots that are said to appear and were there before, false deaths: roots that are said to vanish (none does), both
//!   of the roots that are there on both days.

#![allow(clippy::print_stdout, reason = "the figures are what it is for")]

use rootvox::growth::follow::{FollowParams, Growth, State, follow};
use rootvox::optics::{Index, Tank};
use rootvox::roots::{Root, TracedRoot};
use rootvox::simulation::{AgeParams, GrowthParams, aged, grow, swayed};
use std::collections::BTreeMap;

/// Greatest distance of a point from where it grew, mm.
const SWAY_MM: f64 = 0.5;
/// When the plant is looked at, days since its main root set out.
const DAYS: [f64; 5] = [8.0, 10.0, 12.0, 14.0, 16.0];
/// Less elongation than this has no relative error worth telling.
const TOLD_MM: f64 = 1.0;
const PLANTS: u64 = 50;

fn main() {
    let tank = Tank {
        radius_mm: 60.0,
        height_mm: 200.0,
        wall_mm: 4.0,
        water_level_mm: 10.0,
        index: Index::default(),
        belts_mm: vec![],
    };
    let mut plant = GrowthParams::default();
    plant.main.length_mm = 150.0;
    (plant.first_order.count, plant.first_order.length_mm) = (28, 70.0);
    (plant.second_order.count, plant.second_order.length_mm) = (32, 20.0);
    let mut all = Judged::default();
    let mut last = Vec::new();
    for seed in 1..=PLANTS {
        let full = grow(&plant, &tank, seed).expect("it grows");
        let true_days =
            DAYS.map(|day| aged(full.clone(), &AgeParams { days: Some(day), ..AgeParams::default() }, seed));
        last.push(true_days[4].len());
        let mut seen: Vec<(f64, Vec<TracedRoot>)> = (0..DAYS.len())
            .map(|n| (DAYS[n], listed_otherwise(&swayed(&true_days[n], &tank, SWAY_MM, seed, n), seed + n as u64)))
            .collect();
        let growth = follow(&mut seen, &FollowParams::default());
        all.add(&growth, &seen, &true_days);
    }
    last.sort_unstable();
    println!("{PLANTS} plants of {} to {} roots on the last of {} days", last[0], last[last.len() - 1], DAYS.len());
    all.print();
}

/// The roots in an order that the day draws, each numbered by its place.
fn listed_otherwise(roots: &[Root], seed: u64) -> Vec<TracedRoot> {
    let mut order: Vec<usize> = (0..roots.len()).collect();
    order.sort_by_key(|&n| {
        (n as u64 + 1).wrapping_mul(seed.wrapping_mul(2).wrapping_add(0x9E37_79B9_7F4A_7C15)).rotate_left(23)
    });
    let number = |id: i64| roots.iter().position(|r| r.id == id).and_then(|n| order.iter().position(|&o| o == n));
    let one = |&n: &usize| {
        let root = &roots[n];
        let parent = number(root.parent).map_or(-1, |n| n as i64);
        let count = root.points_mm.len();
        TracedRoot {
            root: Root { id: number(root.id).map_or(-1, |n| n as i64), parent, ..root.clone() },
            radius_sd_mm: vec![0.0; count],
            views: vec![1; count],
            confidence: vec![1.0; count],
        }
    };
    order.iter().map(one).collect()
}

#[derive(Default)]
struct Judged {
    both: usize,
    kept: usize,
    born: usize,
    died: usize,
    told: usize,
    errors: Vec<f64>,
}

impl Judged {
    fn add(&mut self, growth: &Growth, seen: &[(f64, Vec<TracedRoot>)], truth: &[Vec<Root>; 5]) {
        // On each day, of which true root every track is: the one that shares its base and most points. Days may be read anew by each
        // other, so that places in the lists say nothing.
        let true_of: Vec<BTreeMap<usize, i64>> =
            seen.iter().zip(truth).map(|((_, roots), truth)| nearest_of_all(roots, truth)).collect();
        let track_of = |day: usize, id: i64| {
            let place = true_of[day].iter().find(|(_, of)| **of == id).map(|(place, _)| *place)?;
            growth.tracks.iter().find(|t| t.seen[day] == Some(place)).map(|t| t.id)
        };
        for day in 1..truth.len() {
            for before in &truth[day - 1] {
                let Some(now) = truth[day].iter().find(|r| r.id == before.id) else { continue };
                self.both += 1;
                let (was, is) = (track_of(day - 1, before.id), track_of(day, before.id));
                if was.is_none() || was != is {
                    continue;
                }
                self.kept += 1;
                let grown = length(now) - length(before);
                let of = growth.intervals.iter().find(|i| Some(i.root) == is && i.days == [day - 1, day]);
                if grown >= TOLD_MM {
                    self.told += 1;
                    self.errors.extend(of.and_then(|i| i.elongation_mm).map(|told| (told / grown - 1.0).abs()));
                }
            }
            let was_there = |track: i64| {
                let place = growth.tracks.iter().find(|t| t.id == track).and_then(|t| t.seen[day]);
                let of = place.and_then(|place| true_of[day].get(&place));
                of.is_none_or(|id| truth[day - 1].iter().any(|r| r.id == *id))
            };
            let of_day = || growth.intervals.iter().filter(|i| i.days[1] == day);
            self.born += of_day().filter(|i| i.state == State::Appeared && was_there(i.root)).count();
            self.died += of_day().filter(|i| i.state == State::Vanished).count();
        }
    }

    fn print(mut self) {
        let share = |n: usize, of: usize| 100.0 * n as f64 / of as f64;
        self.errors.sort_by(f64::total_cmp);
        println!("keep their identity  {:.1} % of {}", share(self.kept, self.both), self.both);
        println!(
            "elongation           median error {:.1} %; told of {} of {}",
            100.0 * self.errors[self.errors.len() / 2],
            self.errors.len(),
            self.told
        );
        println!("false births         {:.1} %", share(self.born, self.both));
        println!("false deaths         {:.1} %", share(self.died, self.both));
    }
}

/// Of each root's place the number of the true root that it is: pairs by the mean distance of the shorter from the longer, each once.
fn nearest_of_all(roots: &[TracedRoot], truth: &[Root]) -> BTreeMap<usize, i64> {
    let mut pairs = Vec::new();
    for (place, root) in roots.iter().enumerate() {
        for other in truth {
            let far = mean_distance(&root.root, other) + mean_distance(other, &root.root);
            pairs.push((far, place, other.id));
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut of = BTreeMap::new();
    for (far, place, id) in pairs {
        if far < 4.0 * SWAY_MM && !of.contains_key(&place) && !of.values().any(|known| *known == id) {
            of.insert(place, id);
        }
    }
    of
}

fn mean_distance(root: &Root, from: &Root) -> f64 {
    let distance = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|d| (a[d] - b[d]).powi(2)).sum::<f64>().sqrt();
    let near = |p| from.points_mm.iter().map(|q| distance(p, q)).fold(f64::INFINITY, f64::min);
    root.points_mm.iter().map(near).sum::<f64>() / root.points_mm.len() as f64
}

fn length(root: &Root) -> f64 {
    let step = |p: &[[f64; 3]]| (0..3).map(|d| (p[1][d] - p[0][d]).powi(2)).sum::<f64>().sqrt();
    root.points_mm.windows(2).map(step).sum()
}
