//! Textbook numerics that no kept crate offers.

pub mod robust;

pub use robust::Loss;
