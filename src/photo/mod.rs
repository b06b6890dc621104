//! 2-D pictures: decoding, undistortion, colour, contrast against the background.

pub mod colour;
pub mod contrast;
pub mod decode;
pub mod focal;
pub mod graph_cut;
pub mod gray;
pub mod pyramid;
pub mod shrink;
pub mod undistort;

pub use decode::decode;
pub use focal::focal_px;
pub use gray::gray;
pub use pyramid::Pyramid;
pub use undistort::undistort;

/// A photograph: (y, x, rgb), 8 bits as encoded (sRGB).
pub type Picture = ndarray::Array3<u8>;
