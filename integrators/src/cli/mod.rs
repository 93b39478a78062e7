//! The `aether` program: `render`, `compare`, `inspect`, `convergence` and `report`.
//!
//! - `arguments`: the command line and its limits.
//! - `plan`: a scene file with what the command line asks of it; `kernel`: from there to something that can be rendered.
//! - `render`, `compare`, `inspect`, `convergence`, `report`: one module for each command.
//! - `settings`: the options that an image depends on; `checkpoint`: what a render that goes on has to have in common with the
//!   one before.
//! - `output`: the files of a render; `summary`, `warnings`: what is said of it.
//! - `terminal`: the progress bar and Ctrl-C; `live`: the picture while it grows.
//!
//! Exit codes: 0 on success, 2 on wrong usage or input (with a message on stderr), 130 when a
//! render was interrupted, whose image is kept.

mod arguments;
mod checkpoint;
mod compare;
mod convergence;
mod inspect;
mod kernel;
mod live;
mod output;
mod plan;
mod render;
mod report;
mod settings;
mod summary;
mod terminal;
mod warnings;

#[cfg(test)]
mod tests;

use std::fmt;
use std::io::{self, Write};
use std::process::ExitCode;

use clap::Parser;

use arguments::{Arguments, Command};

/// Exit code for wrong usage or input.
const FAILURE: u8 = 2;
/// Exit code for an interrupted render: 128 plus the number of SIGINT, as shells have it.
const INTERRUPTED: u8 = 130;

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = match &arguments.command {
        Command::Render(arguments) => render::run(arguments),
        Command::Compare(arguments) => compare::run(arguments),
        Command::Inspect(arguments) => inspect::run(arguments),
        Command::Convergence(arguments) => convergence::run(arguments),
        Command::Report(arguments) => report::run(arguments),
    };
    result.unwrap_or_else(|failure| {
        warn(&format!("error: {failure}"));
        ExitCode::from(FAILURE)
    })
}

/// A message for the user: what is wrong, where, and what to do.
#[derive(Debug)]
pub struct Failure(String);

impl Failure {
    fn new(message: impl Into<String>) -> Self {
        Self(message.into())
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self(error.to_string())
    }
}

/// Prints a text and a newline to stdout. A reader that went away (`| head`) is no failure.
fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match writeln!(stdout, "{text}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure(format!("cannot write to stdout: {error}")))
        }
        _ => Ok(()),
    }
}

/// Prints a line to stderr. There is nowhere left to report a failure to do so.
fn warn(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}
