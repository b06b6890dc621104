//! What a root did between two days.

use super::{FollowParams, Track};
use crate::growth::overlap::{Overlap, Place, overlaps, places};
use crate::roots::Root;
use serde::{Deserialize, Serialize};

/// What became of a root.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// Seen on both days.
    Followed,
    /// Seen for the first time on the later day.
    Appeared,
    /// Seen on the earlier day, not on the later: hidden or dead.
    Vanished,
}

/// A root between two days. Of one that appeared or vanished, only the length on the day it was seen is known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Number of the root.
    pub root: i64,
    /// What became of it.
    pub state: State,
    /// Places of the two days in their order.
    pub days: [usize; 2],
    /// Length on either day, mm, where it is seen.
    pub length_mm: [Option<f64>; 2],
    /// Share of the earlier root that lies on the later, where it is seen on both.
    pub overlap: Option<f64>,
    /// What lies on the later day beyond the earlier's tip, mm, where three quarters of the root lie on its later self.
    pub elongation_mm: Option<f64>,
    /// Roots that spring from it on the later day for the first time.
    pub new_laterals: usize,
    /// Mean change of the diameter over what lies together, mm, where anything does.
    pub diameter_change_mm: Option<f64>,
}

/// Share of a root that has to lie on its later self for its growth to be told.
const TRUSTED: f64 = 0.75;

/// The intervals of all roots, day by day.
pub(super) fn all(tracks: &[Track], days: &[(f64, Vec<Root>)], params: &FollowParams) -> Vec<Interval> {
    let mut intervals = Vec::new();
    for day in 1..days.len() {
        for track in tracks {
            let before = (0..day).rev().find_map(|d| Some((d, track.seen[d]?)));
            let now = track.seen[day];
            let interval = match (before, now) {
                (Some(before), Some(now)) => followed(track, before, (day, now), days, params),
                (None, Some(now)) => {
                    lone(track, State::Appeared, [day - 1, day], [None, Some(length(&days[day].1[now]))])
                }
                // Told once, on the first day that misses it.
                (Some((d, place)), None) if d + 1 == day => {
                    lone(track, State::Vanished, [d, day], [Some(length(&days[d].1[place])), None])
                }
                _ => continue,
            };
            let born =
                |t: &&Track| t.parent == track.id && t.seen[..day].iter().all(Option::is_none) && t.seen[day].is_some();
            let new_laterals = tracks.iter().filter(born).count();
            intervals.push(Interval { new_laterals, ..interval });
        }
    }
    intervals
}

fn lone(track: &Track, state: State, days: [usize; 2], length_mm: [Option<f64>; 2]) -> Interval {
    Interval {
        root: track.id,
        state,
        days,
        length_mm,
        overlap: None,
        elongation_mm: None,
        new_laterals: 0,
        diameter_change_mm: None,
    }
}

fn followed(
    track: &Track,
    (from, earlier): (usize, usize),
    (to, later): (usize, usize),
    days: &[(f64, Vec<Root>)],
    params: &FollowParams,
) -> Interval {
    let (a, b) = (&days[from].1[earlier], &days[to].1[later]);
    let share = match overlaps(&[a], &[b], params.within_mm, false)[..] {
        [Overlap { share, .. }] => share,
        _ => 0.0,
    };
    let (ours, theirs) = (places(a), places(b));
    let [before_mm, now_mm] = [length(a), length(b)];
    let tip = ours.last().map(|tip| foot(tip, &theirs));
    let elongation_mm = tip.filter(|_| share >= TRUSTED).map(|arc| now_mm - arc);
    let within = ours.iter().filter_map(|place| {
        let arc = foot(place, &theirs);
        let near = theirs.iter().find(|p| p.arc_mm >= arc)?;
        let close = (near.point_mm - place.point_mm).norm() <= params.within_mm;
        close.then(|| 2.0 * (radius(b, arc) - radius(a, place.arc_mm)))
    });
    let changes: Vec<f64> = within.collect();
    let mean = changes.iter().sum::<f64>() / changes.len() as f64;
    Interval {
        root: track.id,
        state: State::Followed,
        days: [from, to],
        length_mm: [Some(before_mm), Some(now_mm)],
        overlap: Some(share),
        elongation_mm,
        new_laterals: 0,
        diameter_change_mm: (!changes.is_empty()).then_some(mean),
    }
}

fn length(root: &Root) -> f64 {
    places(root).last().map_or(0.0, |p| p.arc_mm)
}

/// Arc position on a root of the point nearest to a place.
pub(super) fn foot(place: &Place, on: &[Place]) -> f64 {
    let distance = |p: &Place| (p.point_mm - place.point_mm).norm_squared();
    let Some(k) = (0..on.len()).min_by(|&i, &j| distance(&on[i]).total_cmp(&distance(&on[j]))) else { return 0.0 };
    // Between the nearest place and its neighbours.
    let along = (place.point_mm - on[k].point_mm).dot(&on[k].direction);
    let (low, high) = (on[k.saturating_sub(1)].arc_mm, on[(k + 1).min(on.len() - 1)].arc_mm);
    (on[k].arc_mm + along).clamp(low, high)
}

/// The radius at an arc position.
fn radius(root: &Root, arc_mm: f64) -> f64 {
    let mut before = 0.0;
    for (k, pair) in root.points_mm.windows(2).enumerate() {
        let step = (0..3).map(|d| (pair[1][d] - pair[0][d]).powi(2)).sum::<f64>().sqrt();
        if before + step >= arc_mm {
            let share = if step > 0.0 { ((arc_mm - before) / step).clamp(0.0, 1.0) } else { 0.0 };
            return root.radii_mm[k] + share * (root.radii_mm[k + 1] - root.radii_mm[k]);
        }
        before += step;
    }
    root.radii_mm.last().copied().unwrap_or(f64::NAN)
}
