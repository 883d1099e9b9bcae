//! Where the words of the libraries go: lines on stderr and, with the feature `tracy`, the Tracy profiler.
//!
//! Spans tell how long a step of the CPU takes: at level debug what is done for a patch, at trace what is done every frame. Events of the
//! target `terrane::gpu` tell the same of the GPU. Nobody pays for what no level asks for.

use std::io::IsTerminal;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::format::FmtSpan;
use tracing_subscriber::prelude::*;

/// Begins to listen. Call it once.
pub(crate) fn begin() {
    let lines = tracing_subscriber::fmt::layer().with_ansi(std::io::stderr().is_terminal()).with_writer(std::io::stderr);
    let lines = lines.with_span_events(FmtSpan::CLOSE).with_filter(levels());
    let listeners = tracing_subscriber::registry().with(lines);
    #[cfg(feature = "tracy")]
    let listeners = listeners.with(tracy::listener());
    listeners.init();
}

/// RUST_LOG chooses levels, as in "info,terrane=debug".
fn levels() -> Targets {
    std::env::var("RUST_LOG").ok().and_then(|levels| levels.parse().ok()).unwrap_or_else(|| {
        // A clipboard manager that is not there is no trouble of the user's.
        let quiet = [("winit", LevelFilter::ERROR), ("arboard", LevelFilter::ERROR)];
        Targets::new().with_default(LevelFilter::WARN).with_targets(quiet)
    })
}

#[cfg(feature = "tracy")]
mod tracy {
    //! All spans and events of Terrane for the profiler, whatever RUST_LOG says.

    use tracing::Subscriber;
    use tracing_subscriber::filter::{LevelFilter, Targets};
    use tracing_subscriber::fmt::format::DefaultFields;
    use tracing_subscriber::registry::LookupSpan;
    use tracing_subscriber::Layer;
    use tracing_tracy::{Config, TracyLayer};

    #[derive(Default)]
    struct ByName(DefaultFields);

    impl Config for ByName {
        type Formatter = DefaultFields;

        fn formatter(&self) -> &DefaultFields {
            &self.0
        }

        /// One zone for all patches: the statistics are of what is done, not of what it is done to.
        fn format_fields_in_zone_name(&self) -> bool {
            false
        }
    }

    pub(super) fn listener<S: Subscriber + for<'a> LookupSpan<'a>>() -> impl Layer<S> {
        // All packages begin with this.
        TracyLayer::new(ByName::default()).with_filter(Targets::new().with_target("terrane", LevelFilter::TRACE))
    }
}
