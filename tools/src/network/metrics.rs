//! What a server did, as Prometheus reads it (text format 0.0.4).

use axum::http::StatusCode;
use std::fmt::Write;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Upper ends of the classes of times that answers took, seconds.
const SECONDS: [f64; 7] = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0];

/// Counters since the server started.
#[derive(Default)]
pub(super) struct Metrics {
    /// By the first digit of the status.
    answers: [AtomicU64; 6],
    turned_away: AtomicU64,
    bytes: AtomicU64,
    /// Not more than each of [`SECONDS`], and all.
    times: [AtomicU64; SECONDS.len() + 1],
    microseconds: AtomicU64,
}

impl Metrics {
    /// A question was answered.
    pub(super) fn answered(&self, status: StatusCode, bytes: u64, took: Duration) {
        let class = usize::from(status.as_u16() / 100).min(5);
        self.answers[class].fetch_add(1, Ordering::Relaxed);
        self.bytes.fetch_add(bytes, Ordering::Relaxed);
        self.microseconds.fetch_add(took.as_micros() as u64, Ordering::Relaxed);
        let ends = SECONDS.into_iter().chain([f64::INFINITY]);
        ends.zip(&self.times).filter(|(end, _)| took.as_secs_f64() <= *end).for_each(|(_, count)| {
            count.fetch_add(1, Ordering::Relaxed);
        });
    }

    /// A question came that there was no room for.
    pub(super) fn turned_away(&self) {
        self.turned_away.fetch_add(1, Ordering::Relaxed);
    }

    /// All of it, and how many questions are being answered.
    pub(super) fn text(&self, in_flight: usize) -> String {
        let count = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let mut text = String::new();
        // Writing to a string cannot fail.
        let mut add = |line: std::fmt::Arguments<'_>| writeln!(text, "{line}").unwrap_or_default();
        add(format_args!("# HELP terrane_requests_total Requests that were answered, by class of status."));
        add(format_args!("# TYPE terrane_requests_total counter"));
        for (class, counter) in self.answers.iter().enumerate().skip(2) {
            add(format_args!("terrane_requests_total{{status=\"{class}xx\"}} {}", count(counter)));
        }
        add(format_args!("# HELP terrane_requests_refused_total Requests that were answered with 503, for lack of room."));
        add(format_args!("# TYPE terrane_requests_refused_total counter"));
        add(format_args!("terrane_requests_refused_total {}", count(&self.turned_away)));
        add(format_args!("# HELP terrane_sent_bytes_total Bytes of answers."));
        add(format_args!("# TYPE terrane_sent_bytes_total counter"));
        add(format_args!("terrane_sent_bytes_total {}", count(&self.bytes)));
        add(format_args!("# HELP terrane_requests_in_flight Requests that are being answered."));
        add(format_args!("# TYPE terrane_requests_in_flight gauge"));
        add(format_args!("terrane_requests_in_flight {in_flight}"));
        add(format_args!("# HELP terrane_request_seconds Time to find answers, without sending them."));
        add(format_args!("# TYPE terrane_request_seconds histogram"));
        for (end, counter) in SECONDS.iter().zip(&self.times) {
            add(format_args!("terrane_request_seconds_bucket{{le=\"{end}\"}} {}", count(counter)));
        }
        let all = count(&self.times[SECONDS.len()]);
        add(format_args!("terrane_request_seconds_bucket{{le=\"+Inf\"}} {all}"));
        add(format_args!("terrane_request_seconds_sum {}", count(&self.microseconds) as f64 * 1e-6));
        add(format_args!("terrane_request_seconds_count {all}"));
        text
    }
}
