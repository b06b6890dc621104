//! Files of the outside world, one file each.
