//! Code that the tests of the command share.

#![allow(dead_code, reason = "every test program uses its own part")]

mod skipped;

pub(crate) use skipped::skipped;

use std::path::Path;
use std::process::{Command, Output, Stdio};
use terrane::vulkan::{Context, ContextOptions};

/// The command with arguments, to be run.
pub(crate) fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_terrane"));
    command.args(arguments).stdin(Stdio::null());
    command
}

/// Runs the command in a folder.
pub(crate) fn terrane(arguments: &[&str], folder: &Path) -> Output {
    command(arguments).current_dir(folder).output().expect("terrane runs")
}

/// Whether there is a device to render with; none prints "skipped", or fails where `TERRANE_REQUIRE_GPU=1`.
pub(crate) fn device() -> Option<String> {
    match Context::new(&ContextOptions::default()) {
        Ok(context) => {
            let info = context.device_info();
            Some(format!("{}, {} {}", info.name, info.driver, info.driver_info))
        }
        Err(error) => {
            skipped(&error);
            None
        }
    }
}

/// Bytes as text, for messages.
pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
