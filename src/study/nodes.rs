//! The nodes of a study whose results people look at.

use crate::error::{Error, Result};
use crate::flow::NodeId;
use std::sync::Arc;

/// The nodes of cameras found in the photographs.
#[derive(Debug, Clone)]
pub struct CalibrationNodes {
    /// The mask for structure from motion.
    pub mask: NodeId,
    /// Cameras, quality, uncertainties.
    pub pose: NodeId,
    /// Outlines and ring.
    pub pictures: NodeId,
}

/// The nodes of a corrected study.
#[derive(Debug, Clone)]
pub struct CorrectionNodes {
    /// The corrected roots, and what became of each correction.
    pub corrections: NodeId,
    /// The roots as they were traced.
    pub traced: NodeId,
    /// Their traits.
    pub traits: NodeId,
}

/// The nodes of a study whose results people look at.
#[derive(Debug, Clone)]
pub struct StudyNodes {
    /// Name of each photograph, in capture order.
    pub photos: Arc<[String]>,
    /// The photographs themselves.
    pub photo_nodes: Arc<[NodeId]>,
    /// Of each photograph the undistorted picture and its camera.
    pub seen: Arc<[(NodeId, NodeId)]>,
    /// Of each photograph its share of root, where that is asked for.
    pub evidence: Arc<[NodeId]>,
    /// What they say of themselves, where they are files.
    pub survey: Option<NodeId>,
    /// Lens and poses.
    pub cameras: NodeId,
    /// How they were found, where the photographs gave them.
    pub calibration: Option<CalibrationNodes>,
    /// The merged volume.
    pub merged: NodeId,
    /// Its rootness.
    pub rootness: NodeId,
    /// The extracted root voxels.
    pub extract: NodeId,
    /// The roots, corrected where a person did, with what is known of their points.
    pub system: NodeId,
    /// Roots, traits and their files.
    pub traits: NodeId,
    /// What a person corrected.
    pub corrections: Option<CorrectionNodes>,
    /// Pictures of a slice, where the study asks for one.
    pub slices: Option<NodeId>,
    /// The score of the root voxels, where the truth is known.
    pub score: Option<NodeId>,
    /// The score of the traced roots, where the truth is known.
    pub roots_score: Option<NodeId>,
    /// Errors of cameras and tank, where the capture was simulated.
    pub camera_errors: Option<NodeId>,
    /// What is shown of it; the points of a sweep show nothing.
    pub shown: Option<Shown>,
}

/// The nodes of a study that people look at and no number rests on.
#[derive(Debug, Clone)]
pub struct Shown {
    /// The OME-Zarr image.
    pub volume: NodeId,
    /// Its labels.
    pub labels: NodeId,
    /// What is seen of the water.
    pub sight: NodeId,
    /// One overlay per photograph.
    pub overlays: Vec<NodeId>,
    /// The traced roots on each photograph.
    pub root_overlays: Vec<NodeId>,
    /// Each photograph, small enough for the report.
    pub previews: Vec<NodeId>,
    /// The traced roots as lines on each photograph.
    pub root_lines: Vec<NodeId>,
    /// How the traits vary over resampled views, where the study asks for it.
    pub spread: Option<NodeId>,
    /// Pictures of what each photograph tells of roots, where the study asks for them.
    pub evidence_pictures: Arc<[NodeId]>,
}

impl StudyNodes {
    /// The nodes of the numbers: what a point of a sweep is compared by.
    pub fn numbers(&self) -> Vec<NodeId> {
        let truth = self.score.into_iter().chain(self.camera_errors);
        [self.cameras, self.extract].into_iter().chain(self.survey).chain(self.slices).chain(truth).collect()
    }

    /// The nodes of what is measured on traced roots.
    pub fn measures(&self) -> impl Iterator<Item = NodeId> {
        std::iter::once(self.traits).chain(self.roots_score).chain(self.corrections.as_ref().map(|c| c.traits))
    }

    /// What is shown of a study that is no point of a sweep.
    ///
    /// # Errors
    /// Of a point of a sweep.
    pub fn shown(&self) -> Result<&Shown> {
        self.shown.as_ref().ok_or_else(|| Error::failed("a point of a sweep has no pictures"))
    }

    /// The nodes that the report tells of, but for those of the photographs and of resampled views.
    ///
    /// # Errors
    /// Of a point of a sweep.
    pub fn told(&self) -> Result<Vec<NodeId>> {
        let mut told = vec![self.cameras, self.system, self.shown()?.sight];
        told.extend(self.measures());
        told.extend(self.score.into_iter().chain(self.camera_errors));
        told.extend(self.calibration.as_ref().map(|c| c.pose));
        told.extend(self.corrections.as_ref().map(|c| c.corrections));
        Ok(told)
    }

    /// All nodes that a run brings up to date.
    pub fn targets(&self) -> Vec<NodeId> {
        let mut targets = self.numbers();
        targets.extend(self.measures());
        if let Some(shown) = &self.shown {
            // Also what is read of nodes that others rest on: a store far away gives the values of targets only.
            targets.extend([self.system, shown.volume, shown.labels, shown.sight]);
            targets.extend(&shown.overlays);
            targets.extend(self.calibration.iter().flat_map(|c| [c.mask, c.pose, c.pictures]));
            targets.extend(self.corrections.as_ref().map(|c| c.corrections));
            targets.extend(&shown.root_overlays);
            targets.extend(&shown.previews);
            targets.extend(&shown.root_lines);
            targets.extend(&*shown.evidence_pictures);
            targets.extend(shown.spread);
        }
        targets
    }
}
