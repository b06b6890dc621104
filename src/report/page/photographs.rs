//! The photographs, each once as JPEG, with the roots drawn over it by the script.

use super::html::escape;
use crate::report::lines::RootLine;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

/// A photograph of the page.
pub struct Photograph {
    /// Name of its file.
    pub name: String,
    /// Size as taken, px: what the lines are in.
    pub size_px: [usize; 2],
    /// Direction that it was taken from, seen from the tank's axis: degrees from x towards y, 0..360.
    pub from_deg: f64,
    /// The picture, perhaps smaller.
    pub jpeg: Vec<u8>,
    /// The roots on it.
    pub lines: Vec<RootLine>,
}

impl Photograph {
    /// Its direction in whole degrees, 0 to 359.
    pub fn whole_degrees(&self) -> u32 {
        self.from_deg.round().rem_euclid(360.0) as u32
    }
}

/// The section with all photographs.
pub fn section(photographs: &[Photograph], t: &mut String) {
    t.push_str(
        "<section id=\"photographs\" aria-labelledby=\"photographs-title\">\n\
         <div class=\"bar\"><h2 id=\"photographs-title\">Photographs</h2>\n\
         <label class=\"check\"><input type=\"checkbox\" id=\"gallery-roots\" checked> Draw the roots</label></div>\n\
         <p>The traced roots drawn back through the refraction, in the colours of the 3D view. A line beside its root shows a wrong pose. \
         Click to see one large, with a slider between the bare photograph and the drawn one.</p>\n<ul class=\"gallery\">\n",
    );
    for (n, photo) in photographs.iter().enumerate() {
        let [width, height] = photo.size_px;
        let from_deg = photo.whole_degrees();
        let name = escape(&photo.name);
        let _ = write!(
            t,
            "<li><button type=\"button\" class=\"photo\" data-view=\"{n}\" aria-label=\"Photograph {name}: open large\">\
             <img width=\"{width}\" height=\"{height}\" decoding=\"async\" alt=\"\" src=\"data:image/jpeg;base64,"
        );
        STANDARD.encode_string(&photo.jpeg, t);
        let _ = writeln!(t, "\"></button><span class=\"caption\">{name}, from {from_deg}°</span></li>");
    }
    t.push_str("</ul>\n</section>\n");
}

/// The dialog that shows one large.
pub const VIEWER: &str = include_str!("viewer.html");
