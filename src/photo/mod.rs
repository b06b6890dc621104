//! 2-D pictures: load, undistort, colour, sampling.
