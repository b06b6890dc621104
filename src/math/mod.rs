//! Textbook numerics that no kept crate offers.

pub mod eigen3;
pub mod robust;

pub use robust::Loss;
