//! Photographs: head, pixels, and what the camera wrote beside them.

use rootvox::photo::{self, Metadata};

/// Larger pictures are honest ones that take long.
const MOST_PX: usize = 1 << 20;

/// Reads it, whatever it is, and tells whether it could be.
pub fn run(data: &[u8]) -> bool {
    let _ = Metadata::of(data).map(|said| (said.orientation(), said.focal_px(640, 480), said.taken()));
    photo::head(data, "photograph").is_ok_and(|head| {
        head.size.0.saturating_mul(head.size.1) <= MOST_PX && photo::decode(data, "photograph").is_ok()
    })
}
