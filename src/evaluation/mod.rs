//! A reconstruction against the truth.
