//! A score as a table for people.

use crate::evaluation::Score;
use std::fmt::Write;

/// The score as lines of text.
pub fn table(score: &Score) -> String {
    let mut text = String::from("tolerance  precision  recall     F1\n");
    for a in &score.at {
        let _ = writeln!(text, "{:6.1} mm  {:9.3}  {:6.3}  {:5.3}", a.tolerance_mm, a.precision, a.recall, a.f1);
    }
    let _ = write!(text, "{} points, {:.0} mm of true roots", score.points, score.true_length_mm);
    if let Some(rms) = score.rms_mm {
        let _ = write!(text, ", rms {rms:.3} mm");
    }
    if let Some(bias) = score.length_bias {
        let _ = write!(text, ", length {:+.1} %", bias * 100.0);
    }
    if let Some(turn) = score.turned_deg {
        let _ = write!(text, ", turned by {turn:.2}°");
    }
    text
}
