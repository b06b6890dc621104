//! Textbook numerics that no kept crate offers.

pub mod eigen3;
pub mod maxflow;
pub mod powell;
pub mod robust;
pub mod umeyama;

pub use robust::Loss;
