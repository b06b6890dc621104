//! Parses the command line, dispatches, and turns errors into exit codes.

use std::process::ExitCode;

fn main() -> ExitCode {
    match rootvox::cli::run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            rootvox::cli::complaint::show(&error);
            ExitCode::from(error.exit_code())
        }
    }
}
