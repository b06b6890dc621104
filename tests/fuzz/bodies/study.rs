//! Study files: their sections as typed settings, checked.

use rootvox::roots::correction::CorrectionParams;
use rootvox::study::document::{Document, Sources};
use rootvox::study::inputs::{Cameras, CorrectionsSection, GridSection, Photos, StudySection, TankSection, Truth};
use rootvox::study::settings::{ReportSection, Simulate};
use std::path::Path;

/// Reads it, whatever it is, and tells whether it could be.
pub fn run(data: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(data) else { return false };
    let Ok(sources) = Sources::new("study.toml", text, &[]) else { return false };
    let Ok(mut file) = Document::parse(&sources) else { return false };
    let _: (StudySection, Photos, Cameras) = (file.section("study"), file.section("photos"), file.section("cameras"));
    let (mut tank, grid): (TankSection, GridSection) = (file.section("tank"), file.section("grid"));
    let _: (Simulate, ReportSection, Truth) = (file.section("simulate"), file.section("report"), file.section("truth"));
    let corrections: CorrectionsSection = file.section("corrections");
    let CorrectionParams { .. } = corrections.params();
    let _ = (corrections.check(), grid.spacing);
    // No file of this machine is read.
    tank.file = None;
    let _ = tank.resolve(Path::new(""));
    file.finish(&["study", "photos", "cameras", "tank", "grid", "simulate", "report", "truth", "corrections"]).is_ok()
}
