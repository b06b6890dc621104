//! Overlays, figures, the HTML report: pictures and pages as values, no files.

pub mod contact;
pub mod curves;
pub mod hits;
pub mod overlay;
pub mod page;
pub mod palette;
