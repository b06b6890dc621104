//! The program as its users meet it: exit codes, messages, and what is left on disk.

mod bad_input;
mod capture;
mod kill;
mod runs;
mod sweeps;
