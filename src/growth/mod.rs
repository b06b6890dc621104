//! Plants beside plants, one plant over days, and results of one plant beside each other.

pub mod align;
pub mod by_roots;
pub mod compare;
pub mod follow;
pub mod motion;
mod overlap;
pub mod pattern;
pub mod print;
pub mod recall;
pub mod same_roots;
