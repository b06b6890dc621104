//! Roots grown in silico and photographed through a tank, with the truth beside them.
//!
//! [`grow`] makes a root system, [`capture`] places the camera and turns the table, and a
//! [`Scene`] photographs the one through the other by forward ray tracing: each sample of each
//! pixel is followed from the lens through air, wall and water to what it meets, with Fresnel's
//! shares reflected and transmitted at every surface. Everything is a function of its parameters
//! and seeds alone, equal to the bit at any thread count.
//!
//! Of the optics only the forward ray is used, never the inverse projection, and nothing of the
//! reconstruction: what judges a reconstruction shares no code with it.

mod belt;
mod bump;
mod bvh;
mod capture;
mod drifting;
mod gains;
mod growth;
mod marks;
mod mirror;
mod misjudge;
mod noise;
mod photograph;
mod room;
mod scene;
mod sway;
mod walk;

pub use belt::BeltPrint;
pub use capture::{CaptureParams, OtherLens, OtherLight, PictureFormat, capture};
pub use growth::{AgeParams, GrowthParams, LateralParams, MainParams, Preset, aged, grow};
pub use misjudge::{MisjudgeParams, misjudged};
pub use room::RoomParams;
pub use scene::Scene;
pub use sway::swayed;
