//! Parses the command line, dispatches, and turns errors into exit codes.

use std::process::ExitCode;

fn main() -> ExitCode {
    // `rootvox status STUDY | head` ends quietly, as programs in pipes do.
    sigpipe::reset();
    match rootvox::cli::run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            rootvox::cli::complaint::show(&error);
            ExitCode::from(error.exit_code())
        }
    }
}
