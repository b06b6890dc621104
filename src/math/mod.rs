//! Textbook numerics that no kept crate offers.
