//! What commands that build many patches share: threads, stopping on signals, progress.

use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use std::cell::Cell;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::time::Duration;
use terrane_planet::planet::bake::Progress;

/// Time between two lines of progress where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// How many threads build.
#[derive(clap::Args, Clone, Copy, Default)]
pub(crate) struct Threads {
    /// Threads to build on [default: one a processor].
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl Threads {
    /// Their number.
    pub(crate) fn count(self) -> usize {
        self.threads.map_or_else(|| std::thread::available_parallelism().map_or(1, |n| n.get()), usize::from)
    }
}

/// A flag that is raised by Ctrl-C, SIGTERM and SIGHUP; a second signal ends the process at once, which the file survives.
pub(crate) fn stop_on_signals() -> anyhow::Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = stop.clone();
    let handler = move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    };
    ctrlc::set_handler(handler).context("cannot listen for Ctrl-C")?;
    Ok(stop)
}

/// Progress on stderr: a bar on a terminal, a line now and then otherwise.
pub(crate) struct Report {
    bar: Option<ProgressBar>,
    name: String,
    unit: &'static str,
    last_line: Cell<Duration>,
}

impl Report {
    /// Progress in patches under a planet's name.
    pub(crate) fn new(name: &str) -> Report {
        Report::counting(name, "patches")
    }

    /// Progress under a name, in some unit.
    pub(crate) fn counting(name: &str, unit: &'static str) -> Report {
        let template = format!("{{msg}} [{{elapsed_precise}}] {{wide_bar}} {{pos}}/{{len}} {unit}, {{eta}} left");
        let style = ProgressStyle::with_template(&template);
        let bar = std::io::stderr().is_terminal().then(|| ProgressBar::new(0).with_message(name.to_owned()));
        if let (Some(bar), Ok(style)) = (&bar, style) {
            bar.set_style(style);
        }
        Report { bar, name: name.to_owned(), unit, last_line: Cell::new(Duration::ZERO) }
    }

    /// Shows how far it has come.
    pub(crate) fn show(&self, p: Progress) {
        self.step(p.built, p.total, p.elapsed);
    }

    /// Shows how many of how many are done, and after what time.
    pub(crate) fn step(&self, done: usize, total: usize, elapsed: Duration) {
        if let Some(bar) = &self.bar {
            bar.set_length(total as u64);
            bar.set_position(done as u64);
        } else if elapsed >= self.last_line.get() + LINE_EVERY || done == total {
            self.last_line.set(elapsed);
            eprintln!("{}: {done}/{total} {}, {:.0} s", self.name, self.unit, elapsed.as_secs_f64());
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
