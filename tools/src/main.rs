//! The terrane command: parses, calls, prints. The one place where the process ends.
//!
//! Exit codes: 0 done, 1 failed (the whole chain of errors is on stderr), 2 wrong usage, 130 interrupted.

mod commands;
mod compare;
mod log;
mod network;
mod study;
mod svg;

use clap::Parser;
use std::process::ExitCode;

/// Whole planets from orbit to the ground.
#[derive(Parser)]
#[command(name = "terrane", version, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: commands::Command,
}

/// How a command ended, if nothing failed.
enum Outcome {
    /// All done.
    Done,
    /// Stopped by the user; what was finished is kept.
    Interrupted,
}

fn main() -> ExitCode {
    // `terrane info … | head` ends quietly, as other commands do, instead of panicking.
    sigpipe::reset();
    log::begin();
    match Cli::parse().command.run() {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Interrupted) => ExitCode::from(130),
        Err(error) => {
            eprintln!("terrane: {error}");
            // A transparent error repeats its source's words: say them once.
            let mut said = error.to_string();
            for cause in error.chain().skip(1).map(ToString::to_string) {
                if !said.contains(&cause) {
                    eprintln!("  because: {cause}");
                }
                said = cause;
            }
            ExitCode::FAILURE
        }
    }
}
