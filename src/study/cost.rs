//! What a run will cost by its grids, before it starts: rough, to tell a minute from a night.
//!
//! The figures are those of `docs/rendering.md` (*licorice-sim* from 1 to 0.25 mm); time and store for the photographs
//! themselves are not counted.

use super::batch::Batch;
use super::render::Method;
use crate::flow::Stage;
use crate::flow::{NodeId, Plan};
use crate::stages::merge::Merge;
use crate::stages::rootness::Rootness;
use crate::volume::Grid;
use std::collections::BTreeSet;

/// Processor seconds that a voxel takes in every view, rendered by the exact inverse and merged.
const SECONDS_PER_VIEW: f64 = 35e-9;
/// The same by the paper's search.
const SECONDS_PER_VIEW_PATCH: f64 = 380e-9;
/// Processor seconds that a voxel takes from the merged volume to the results.
const SECONDS_PER_VOXEL: f64 = 430e-9;
/// Bytes of the store that a voxel takes.
const STORED_BYTES: u64 = 8;
/// Bytes of memory that a voxel takes: the dense rootness.
const DENSE_BYTES: u64 = 4;
/// Bytes of memory that a voxel takes in the slabs of all that runs at once, up to `MOST_SLAB_BYTES`.
const SLAB_BYTES: u64 = 40;
/// Bytes of those slabs.
const MOST_SLAB_BYTES: u64 = 7 << 28;

/// Longer runs are told of before they start.
pub const LONG_SECONDS: f64 = 3600.0;
/// Longer runs are refused unless the user insists.
pub const MOST_SECONDS: f64 = 8.0 * 3600.0;

/// A rough estimate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cost {
    /// Processor seconds of all that is to be computed.
    pub processor_seconds: f64,
    /// Memory at the peak.
    pub memory_bytes: u64,
    /// What is added to the store.
    pub store_bytes: u64,
    /// Voxels of the largest grid.
    pub voxels: usize,
}

/// What to do about a cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing.
    Run,
    /// Tell the user before it starts.
    Announce,
    /// Refuse, unless the user insists.
    Refuse,
}

impl Cost {
    /// What bringing a batch up to date costs: all of it, or only what `plan` says is to be computed.
    pub fn of(batch: &Batch, plan: Option<&Plan>) -> Self {
        let pending: Option<BTreeSet<NodeId>> = plan.map(|plan| plan.pending().map(|(node, _)| node).collect());
        let (mut cost, mut counted, mut walk) = (Self::default(), BTreeSet::new(), batch.graph.walk());
        for study in &batch.studies {
            for point in &study.points {
                let Ok((settings, _)) = &point.planned else { continue };
                for node in walk.upstream(&study.targets_of(point)) {
                    let is_pending = pending.as_ref().is_none_or(|pending| pending.contains(&node));
                    if !is_pending || !counted.insert(node) {
                        continue;
                    }
                    match batch.graph.stage(node) {
                        Some(Merge::NAME) => {
                            let views = batch.graph.inputs(node, "views").len();
                            cost.merge(&settings.grid, views, settings.render.method);
                        }
                        Some(Rootness::NAME) => cost.rootness(&settings.grid),
                        _ => {}
                    }
                }
            }
        }
        cost
    }

    fn merge(&mut self, grid: &Grid, views: usize, method: Method) {
        let seconds = match method {
            Method::Exact => SECONDS_PER_VIEW,
            Method::PatchRbf => SECONDS_PER_VIEW_PATCH,
        };
        self.processor_seconds += seconds * (grid.len() * views) as f64;
    }

    fn rootness(&mut self, grid: &Grid) {
        let voxels = grid.len() as u64;
        self.processor_seconds += SECONDS_PER_VOXEL * grid.len() as f64;
        self.store_bytes += STORED_BYTES * voxels;
        self.memory_bytes = self.memory_bytes.max(DENSE_BYTES * voxels + (SLAB_BYTES * voxels).min(MOST_SLAB_BYTES));
        self.voxels = self.voxels.max(grid.len());
    }

    /// Seconds by the clock on so many threads.
    pub fn seconds(&self, threads: usize) -> f64 {
        self.processor_seconds / threads.max(1) as f64
    }

    /// What to do about it on a machine of so many threads and so much memory.
    pub fn verdict(&self, threads: usize, machine_bytes: u64) -> Verdict {
        if self.memory_bytes > machine_bytes || self.seconds(threads) > MOST_SECONDS {
            Verdict::Refuse
        } else if self.seconds(threads) > LONG_SECONDS {
            Verdict::Announce
        } else {
            Verdict::Run
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cost(spacing_mm: f64, views: usize) -> Cost {
        let across = 2 * (85.0 / spacing_mm) as usize + 1;
        let grid = Grid { origin_mm: [0.0; 3], spacing_mm, shape: [(180.0 / spacing_mm) as usize, across, across] };
        let mut cost = Cost::default();
        cost.merge(&grid, views, Method::Exact);
        cost.rootness(&grid);
        cost
    }

    #[test]
    fn estimates_are_near_what_was_measured() {
        // docs/rendering.md: 270 s on two cores, 3.1 GiB, a store of 2.5 GB; 45 s and 2.1 GB.
        let fine = cost(0.25, 36);
        assert!((200.0..350.0).contains(&fine.seconds(2)), "{fine:?}");
        assert!((2.6..3.6).contains(&(fine.memory_bytes as f64 / f64::from(1 << 30))), "{fine:?}");
        assert!((2e9..4e9).contains(&(fine.store_bytes as f64)), "{fine:?}");
        let middle = cost(0.5, 36);
        assert!((25.0..50.0).contains(&middle.seconds(2)), "{middle:?}");
        assert!((1.6e9..2.4e9).contains(&(middle.memory_bytes as f64)), "{middle:?}");
    }

    #[test]
    fn long_runs_are_announced_and_endless_ones_refused() {
        let (small, large) = (16 << 30, 1 << 40);
        assert_eq!(cost(1.0, 36).verdict(1, 1 << 30), Verdict::Run);
        assert_eq!(cost(0.25, 36).verdict(2, small), Verdict::Run);
        // 0.06 mm of the paper's tank: 10 hours.
        assert_eq!(cost(0.06, 36).verdict(2, large), Verdict::Announce);
        assert_eq!(cost(0.06, 36).verdict(1, large), Verdict::Refuse);
        assert_eq!(cost(0.06, 36).verdict(2, small), Verdict::Refuse);
        assert_eq!(cost(0.25, 36).verdict(2, 2 << 30), Verdict::Refuse);
    }
}
