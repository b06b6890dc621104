//! Roots grown in silico and photographed through a tank; the truth beside them.
