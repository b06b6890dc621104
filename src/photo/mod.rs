//! 2-D pictures: decoding, undistortion, colour, evidence of roots against the background.

pub mod colour;
pub mod decode;
pub mod evidence;
mod foreign;
pub mod graph_cut;
pub mod gray;
mod jpeg_end;
pub mod metadata;
pub mod photograph;
pub mod pyramid;
pub mod sequence;
pub mod shrink;
pub mod undistort;

pub use decode::{decode, head};
pub use gray::gray;
pub use metadata::Metadata;
pub use photograph::{Depth, Photograph};
pub use pyramid::Pyramid;
pub use undistort::undistort;

/// A photograph: (y, x, rgb), 8 bits as encoded (sRGB).
pub type Picture = ndarray::Array3<u8>;
