//! Overlays, figures, the HTML report.
