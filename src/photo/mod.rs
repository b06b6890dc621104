//! 2-D pictures: load, undistort, colour, sampling.

pub mod colour;
