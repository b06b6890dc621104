//! The program as its users meet it: exit codes, messages, and what is left on disk.

mod bad_input;
mod cameras;
mod capture;
mod care;
mod compare;
mod corrections;
mod explain;
mod explained;
mod faults;
mod figure6;
mod figures;
mod init;
mod kill;
mod photos;
mod reruns;
mod runs;
mod shared_cache;
mod simulation;
mod sweeps;
mod trials;
mod view;
mod workers;
