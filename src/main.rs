//! The `caustica` program.

use cap::Cap;
use caustica::cli;
use caustica::stats::{AllocationCounter, set_allocation_counter};
use clap::Parser;
use std::alloc::System;
use std::process::ExitCode;

/// The system allocator, which also counts the bytes in use. It sets no limit.
#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

fn main() -> ExitCode {
    set_allocation_counter(AllocationCounter {
        bytes_in_use: || ALLOCATOR.allocated() as u64,
        peak_bytes: || ALLOCATOR.max_allocated() as u64,
    });
    match cli::run(cli::Arguments::parse()) {
        Ok(exit) => exit.into(),
        Err(failure) => {
            failure.print_reports();
            failure.exit.into()
        }
    }
}
