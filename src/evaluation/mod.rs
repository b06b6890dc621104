//! A reconstruction against the truth.
//!
//! Both sides are points: centrelines are sampled every 0.25 mm, voxels stay as they are. All counts
//! are taken inside a region of the tank (between two depths, and 1 mm off the inner wall).

mod bands;
pub mod cameras;
mod detail;
mod points;
mod score;
mod traits;

pub use bands::{BAND_MM, Band, Place, Sight, bands, sight};
pub use cameras::{CameraErrors, camera_errors};
pub use detail::{Class, Detail, Hits, Matched, detail, hits};
pub use points::{Found, Region, STEP_MM, resample};
pub use score::{AtTolerance, Score, ScoreParams, best_turn, score, turned};
pub use traits::{TraitError, trait_errors};
