//! Where cameras and tank are.
