//! The corrections that make wanted roots of traced ones: what a person changed in another program.
//!
//! Every point of a traced root belongs to the wanted root nearest to it, or to none where none is within `NEAR_MM`; stretches
//! shorter than `LEAST_MM` go with their neighbours. In this order
//!
//! 1. roots are cut where they go over from one wanted root to another, and stretches that belong to none go;
//! 2. stretches of wanted roots that no traced root follows are added;
//! 3. pieces of one wanted root are joined in their order along it;
//! 4. roots that spring from another root than wanted are hung on theirs;
//! 5. what runs on past a wanted tip by `TIP_MM` goes;
//! 6. roots that belong to none go.
//!
//! Each step works on what the one before left, as the corrections will. What a place cannot tell apart (two roots as near) is tried a
//! little further along.

use super::nearest::nearest;
use super::tree::Tree;
use super::{Change, CorrectionParams, Spot, Tie, World, one};
use crate::error::Result;
use crate::optics::Vec3;
use crate::roots::strand::End;
use crate::roots::{Root, TracedRoot, curve};
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// A traced point this near to a wanted root may be of it, mm.
const NEAR_MM: f64 = 1.5;
/// Shorter stretches are not told from chance, mm.
const LEAST_MM: f64 = 4.0;
/// A tip this much farther than `NEAR_MM` from where it is wanted is another, mm.
const TIP_MM: f64 = 0.5;
/// Spacing of the points that wanted roots are sought by, mm.
const STEP_MM: f64 = 0.25;
/// Steps that a place is moved along a root until it tells it from others, and their length, mm.
const TRIES: usize = 12;
const TRY_MM: f64 = 0.5;

/// The wanted roots, by place.
struct Wanted<'a> {
    roots: &'a [Root],
    tree: RTree<GeomWithData<[f64; 3], usize>>,
}

/// A stretch of a traced root: of which wanted root, from which point to which.
type Run = (Option<usize>, usize, usize);

/// The corrections that turn `traced` into `wanted`, in the order in which they apply.
///
/// # Errors
/// None; as [`super::correct`].
pub fn difference(traced: &[TracedRoot], wanted: &[Root], params: CorrectionParams) -> Result<Vec<Change>> {
    let sampled = wanted.iter().enumerate().flat_map(|(n, root)| {
        let line = curve::resample(&root.points_mm, STEP_MM);
        line.into_iter().map(move |p| GeomWithData::new(p, n))
    });
    let wanted = Wanted { roots: wanted, tree: RTree::bulk_load(sampled.collect()) };
    let blind = |_: &super::Sighting| Ok(None);
    let world = World { ray: &blind, evidence: None, params: CorrectionParams { snap_mm: 0.0, ..params } };
    let mut state = State { tree: Tree::new(traced.to_vec()), world, changes: Vec::new() };
    state.part(&wanted)?;
    state.add(&wanted)?;
    state.join(&wanted)?;
    state.hang(&wanted)?;
    state.end(&wanted)?;
    state.remove(&wanted)?;
    Ok(state.changes)
}

/// The roots as the corrections so far leave them.
struct State<'a> {
    tree: Tree,
    world: World<'a>,
    changes: Vec<Change>,
}

impl State<'_> {
    /// Applies and keeps a correction, where it does apply.
    fn apply(&mut self, change: Change) -> Result<bool> {
        let applied = one(&mut self.tree, &change, &self.world)?.is_ok();
        if applied {
            self.changes.push(change);
        }
        Ok(applied)
    }

    fn at(&self, root: usize, point: usize) -> Vec3 {
        Vec3::from(self.tree.roots[root].root.points_mm[point])
    }

    /// Cuts and takes out until every root belongs to one wanted root or to none.
    fn part(&mut self, wanted: &Wanted<'_>) -> Result<()> {
        let mut n = 0;
        while n < self.tree.roots.len() {
            let id = self.tree.roots[n].root.id;
            let runs = wanted.runs(&self.tree.roots[n].root);
            let mut changed = false;
            if runs.len() > 1 {
                let (owner, from, to) = runs[runs.len() - 1];
                let before = from - 1;
                changed = match owner {
                    None => self.apply(Change::RemoveStretch { from: self.at(n, before), to: self.at(n, to) })?,
                    Some(_) => self.cut_near(n, before)?,
                };
                let (first_owner, _, first_to) = runs[0];
                if !changed && first_owner.is_none() {
                    changed = self.apply(Change::RemoveStretch { from: self.at(n, 0), to: self.at(n, first_to) })?;
                }
            }
            // Cut roots may have changed places in the list.
            n = self.tree.index(id).unwrap_or(n);
            n += usize::from(!changed);
        }
        Ok(())
    }

    /// Cuts a root at a point, or a little beside it.
    fn cut_near(&mut self, root: usize, point: usize) -> Result<bool> {
        let last = self.tree.roots[root].root.points_mm.len() - 2;
        for step in 0..TRIES {
            for at in [point.saturating_sub(step), point + step] {
                if (1..last).contains(&at) && self.apply(Change::Cut { at: self.at(root, at) })? {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// Adds what no traced root follows.
    fn add(&mut self, wanted: &Wanted<'_>) -> Result<()> {
        for (n, root) in wanted.roots.iter().enumerate() {
            let line = curve::resample(&root.points_mm, self.tree.step_mm);
            let own = self.of(wanted, n);
            let covered: Vec<bool> = line
                .iter()
                .map(|p| own.iter().any(|&r| nearest(&self.tree.roots[r].root.points_mm, &Vec3::from(*p)).1 <= NEAR_MM))
                .collect();
            let radius_mm = median(&root.radii_mm);
            for (from, to) in stretches(&covered) {
                let length = curve::chord_lengths(&line[from..=to]).last().copied().unwrap_or(0.0);
                let is_tip = to + 1 == line.len();
                if length < if is_tip { TIP_MM } else { LEAST_MM } {
                    continue;
                }
                let through: Vec<Spot> = line[from..=to].iter().map(|p| Spot::Place(Vec3::from(*p))).collect();
                let diameter_mm = Some(2.0 * radius_mm).filter(|d| *d > 0.0);
                for tie in self.ties(wanted, n, from, to + 1 == line.len()) {
                    if self.apply(Change::Add { through: through.clone(), diameter_mm, tie })? {
                        break;
                    }
                }
            }
        }
        Ok(())
    }

    /// What a stretch of a wanted root from its point `from` on may hang on, best first.
    fn ties(&self, wanted: &Wanted<'_>, n: usize, from: usize, is_tip: bool) -> Vec<Tie> {
        let mut ties = Vec::new();
        let root = &wanted.roots[n];
        let parent = wanted.roots.iter().position(|r| r.id == root.parent);
        if let (0, Some(parent)) = (from, parent) {
            let first = Vec3::from(root.points_mm[0]);
            for onto in self.of(wanted, parent) {
                let (point, mm) = nearest(&self.tree.roots[onto].root.points_mm, &first);
                if mm <= LEAST_MM {
                    ties.extend(self.beside(onto, point).into_iter().map(Tie::Parent));
                }
            }
        } else if let (true, Some(&last)) = (is_tip, self.of(wanted, n).last()) {
            ties.push(Tie::Continues(self.facing(wanted, n, last, End::Last)));
        }
        ties.push(Tie::Free);
        ties
    }

    /// The traced roots of a wanted one, in their order along it.
    fn of(&self, wanted: &Wanted<'_>, n: usize) -> Vec<usize> {
        let mut own: Vec<(usize, usize)> = Vec::new();
        for (k, r) in self.tree.roots.iter().enumerate() {
            if wanted.owner(&r.root) == Some(n) {
                let points = &r.root.points_mm;
                own.push((nearest(&wanted.roots[n].points_mm, &Vec3::from(points[points.len() / 2])).0, k));
            }
        }
        own.sort_unstable();
        own.into_iter().map(|(_, k)| k).collect()
    }

    /// Joins the pieces of each wanted root.
    fn join(&mut self, wanted: &Wanted<'_>) -> Result<()> {
        for n in 0..wanted.roots.len() {
            let mut skip = 0;
            loop {
                let own = self.of(wanted, n);
                let Some(pair) = own.get(skip..skip + 2) else { break };
                let (a, b) = (self.facing(wanted, n, pair[0], End::Last), self.facing(wanted, n, pair[1], End::First));
                if !self.apply(Change::Join { from: a, to: b })? {
                    skip += 1;
                }
            }
        }
        Ok(())
    }

    /// The end of a piece that lies farther towards the tip of its wanted root, or towards its base.
    fn facing(&self, wanted: &Wanted<'_>, n: usize, piece: usize, towards: End) -> Vec3 {
        let last = self.tree.roots[piece].root.points_mm.len() - 1;
        let along = |k: usize| nearest(&wanted.roots[n].points_mm, &self.at(piece, k)).0;
        let is_forwards = along(last) >= along(0);
        self.at(piece, if (towards == End::Last) == is_forwards { last } else { 0 })
    }

    /// Hangs the roots on their parents.
    fn hang(&mut self, wanted: &Wanted<'_>) -> Result<()> {
        for (n, root) in wanted.roots.iter().enumerate() {
            let Some(parent) = wanted.roots.iter().position(|r| r.id == root.parent) else { continue };
            let (Some(&own), onto) = (self.of(wanted, n).first(), self.of(wanted, parent)) else { continue };
            let now = self.tree.index(self.tree.roots[own].root.parent);
            if now.is_some_and(|p| onto.contains(&p)) || onto.is_empty() {
                continue;
            }
            let first = Vec3::from(root.points_mm[0]);
            let distance = |r: usize| nearest(&self.tree.roots[r].root.points_mm, &first).1;
            let Some(&onto) = onto.iter().min_by(|a, b| distance(**a).total_cmp(&distance(**b))) else { continue };
            let place = nearest(&self.tree.roots[onto].root.points_mm, &first).0;
            let middle = self.tree.roots[own].root.points_mm.len() / 2;
            let tries = self
                .beside(onto, place)
                .into_iter()
                .flat_map(|p| self.beside(own, middle).into_iter().map(move |at| Change::Parent { at, parent: p }));
            for change in tries.collect::<Vec<_>>() {
                if self.apply(change)? {
                    break;
                }
            }
        }
        Ok(())
    }

    /// Ends roots where their wanted ones do.
    fn end(&mut self, wanted: &Wanted<'_>) -> Result<()> {
        for (n, root) in wanted.roots.iter().enumerate() {
            let (Some(&piece), Some(tip)) = (self.of(wanted, n).last(), root.points_mm.last()) else { continue };
            let points = &self.tree.roots[piece].root.points_mm;
            let (at, mm) = nearest(points, &Vec3::from(*tip));
            let beyond_mm = curve::chord_lengths(&points[at..]).last().copied().unwrap_or(0.0);
            // Half of the root and more is no tip.
            if mm <= NEAR_MM && beyond_mm > NEAR_MM + TIP_MM && 2 * at > points.len() {
                let to = self.at(piece, points.len() - 1);
                self.apply(Change::RemoveStretch { from: self.at(piece, at), to })?;
            }
        }
        Ok(())
    }

    /// Places along a root from a point on, to both sides.
    fn beside(&self, root: usize, point: usize) -> Vec<Vec3> {
        let last = self.tree.roots[root].root.points_mm.len() - 1;
        let stride = (TRY_MM / self.tree.step_mm).round().max(1.0) as usize;
        let steps =
            (0..TRIES).flat_map(|step| [point.saturating_sub(step * stride), (point + step * stride).min(last)]);
        steps.map(|k| self.at(root, k)).collect()
    }

    /// Takes out what is of no wanted root, the latest orders first.
    fn remove(&mut self, wanted: &Wanted<'_>) -> Result<()> {
        let mut strangers: Vec<(u32, i64)> = self
            .tree
            .roots
            .iter()
            .filter(|r| wanted.owner(&r.root).is_none())
            .map(|r| (r.root.order, r.root.id))
            .collect();
        strangers.sort_unstable();
        for (_, id) in strangers.into_iter().rev() {
            let Some(root) = self.tree.index(id) else { continue };
            // A stranger on which a wanted root still hangs stays.
            let carries = (0..self.tree.roots.len())
                .any(|n| n != root && self.tree.descends(n, root) && wanted.owner(&self.tree.roots[n].root).is_some());
            let middle = self.tree.roots[root].root.points_mm.len() / 2;
            for at in if carries { Vec::new() } else { self.beside(root, middle) } {
                if self.apply(Change::Remove { at })? {
                    break;
                }
            }
        }
        Ok(())
    }
}

impl Wanted<'_> {
    /// The wanted root of a point.
    fn of(&self, p: &[f64; 3]) -> Option<usize> {
        self.tree
            .nearest_neighbor_iter_with_distance_2(*p)
            .next()
            .filter(|(_, d2)| *d2 <= NEAR_MM * NEAR_MM)
            .map(|(w, _)| w.data)
    }

    /// The stretches of a traced root.
    fn runs(&self, root: &Root) -> Vec<Run> {
        let arc = curve::chord_lengths(&root.points_mm);
        let mut runs: Vec<Run> = Vec::new();
        for (k, p) in root.points_mm.iter().enumerate() {
            let owner = self.of(p);
            match runs.last_mut() {
                Some(run) if run.0 == owner => run.2 = k,
                _ => runs.push((owner, k, k)),
            }
        }
        let length = |run: &Run| arc[run.2] - arc[run.1];
        while runs.len() > 1 {
            let Some(least) = (0..runs.len()).min_by(|&a, &b| length(&runs[a]).total_cmp(&length(&runs[b]))) else {
                break;
            };
            if length(&runs[least]) >= LEAST_MM {
                break;
            }
            let beside = [least.checked_sub(1), Some(least + 1).filter(|n| *n < runs.len())];
            let Some(into) =
                beside.into_iter().flatten().max_by(|&a, &b| length(&runs[a]).total_cmp(&length(&runs[b])))
            else {
                break;
            };
            runs[into] = (runs[into].0, runs[into].1.min(runs[least].1), runs[into].2.max(runs[least].2));
            runs.remove(least);
            runs.dedup_by(|b, a| {
                let same = a.0 == b.0;
                if same {
                    a.2 = b.2;
                }
                same
            });
        }
        runs
    }

    /// The wanted root that most of a traced root belongs to.
    fn owner(&self, root: &Root) -> Option<usize> {
        let longest = self.runs(root).into_iter().max_by_key(|run| run.2 - run.1);
        longest.and_then(|run| run.0)
    }
}

/// The stretches of points that are not covered, first and last.
fn stretches(covered: &[bool]) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize)> = Vec::new();
    for k in (0..covered.len()).filter(|&k| !covered[k]) {
        match found.last_mut() {
            Some(last) if last.1 + 1 == k => last.1 = k,
            _ => found.push((k, k)),
        }
    }
    found
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}
