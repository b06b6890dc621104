//! Overlays, figures, the HTML report: pictures and pages as values, no files.

pub mod capture_page;
pub mod compare;
pub mod contact;
pub mod curves;
pub mod figure;
pub mod hits;
pub mod lines;
pub mod outline;
pub mod overlay;
pub mod page;
pub mod palette;
pub mod ring;
pub mod trial;
