//! Plants beside plants, and one plant over days.

pub mod align;
pub mod by_roots;
pub mod compare;
pub mod follow;
pub mod motion;
pub mod pattern;
pub mod print;
pub mod recall;
