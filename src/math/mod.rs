//! Textbook numerics that no kept crate offers.

pub mod eigen3;
pub mod maxflow;
pub mod powell;
pub mod robust;

pub use robust::Loss;
