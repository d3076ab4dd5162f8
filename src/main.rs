//! The `caustica` program.

use caustica::cli;
use clap::Parser;
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    match cli::run(cli::Arguments::parse()) {
        Ok(exit) => exit.into(),
        Err(failure) => {
            // A closed stderr must not turn an error into a panic.
            let _ = writeln!(std::io::stderr(), "{:?}", failure.report);
            failure.exit.into()
        }
    }
}
