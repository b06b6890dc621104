//! Textbook numerics that no kept crate offers.

pub mod eigen3;
