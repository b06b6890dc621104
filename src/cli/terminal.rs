//! What goes to the terminal, a pipe or a file behind it.
//!
//! Data that cannot be written is an error: the program ends at once. Talk that cannot be written (a log on a full disk) stops nothing.

use std::fmt::Arguments;
use std::io::Write;

/// Writes data to the standard output; ends the program with exit code 1 where that cannot be.
#[expect(clippy::exit, reason = "nothing is left to do, and drafts are swept by the next run")]
pub fn put(text: Arguments<'_>) {
    let mut out = std::io::stdout().lock();
    if let Err(error) = out.write_all(text.to_string().as_bytes()).and_then(|()| out.flush()) {
        tell(format_args!(
            "error: cannot write to the standard output: {error}\n  help: what was computed is kept; run the same again\n"
        ));
        std::process::exit(1);
    }
}

/// Writes talk to the standard error.
pub fn tell(text: Arguments<'_>) {
    let _ = std::io::stderr().lock().write_all(text.to_string().as_bytes());
}

/// `print!`, for data.
macro_rules! data {
    ($($text:tt)*) => { $crate::cli::terminal::put(format_args!($($text)*)) };
}

/// `println!`, for data.
macro_rules! dataln {
    ($($text:tt)*) => { $crate::cli::terminal::put(format_args!("{}\n", format_args!($($text)*))) };
}

/// `eprint!`, which never panics.
macro_rules! talk {
    ($($text:tt)*) => { $crate::cli::terminal::tell(format_args!($($text)*)) };
}

/// `eprintln!`, which never panics.
macro_rules! talkln {
    ($($text:tt)*) => { $crate::cli::terminal::tell(format_args!("{}\n", format_args!($($text)*))) };
}

pub(crate) use {data, dataln, talk, talkln};
