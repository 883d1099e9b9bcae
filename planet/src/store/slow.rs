//! A planet file as it would be at the other end of a line: for tests and measurements of what comes first, and of what waits for what.
//!
//! All requests share the line. An answer sets out when it was asked for and the answers before it have left; it takes the latency, and
//! the time of its bytes.

use super::error::StoreError;
use super::facts;
use super::planet_file::PlanetFile;
use super::records::{Part, Records};
use crate::globe::patch::PatchId;
use crate::mesh::progressive::PatchFacts;
use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Longest time that an answer takes.
const LONGEST: Duration = Duration::from_secs(3600);

/// How slow a line is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delay {
    /// Time from a question to the first byte of its answer.
    pub latency: Duration,
    /// Bytes a second, of all answers together; more than 0.
    pub bytes_per_second: f64,
}

/// A line that requests share.
#[derive(Debug)]
pub struct Line {
    delay: Delay,
    /// When the bytes of all answers so far have left.
    free: Mutex<Instant>,
}

impl Line {
    /// A line with nothing on its way.
    pub fn new(delay: Delay) -> Arc<Line> {
        Arc::new(Line { delay, free: Mutex::new(Instant::now()) })
    }

    /// Waits as long as an answer of so many bytes takes that is asked for now.
    pub fn carry(&self, bytes: usize) {
        let asked = Instant::now();
        let time =
            Duration::try_from_secs_f64(bytes as f64 / self.delay.bytes_per_second).map_or(LONGEST, |time| time.min(LONGEST));
        let left = {
            let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
            *free = (*free).max(asked) + time;
            *free
        };
        std::thread::sleep(left.saturating_duration_since(asked) + self.delay.latency);
    }
}

/// A planet file over a line.
#[derive(Debug)]
pub struct SlowFile {
    file: PlanetFile,
    line: Arc<Line>,
}

impl SlowFile {
    /// Puts a file at the other end of a line.
    pub fn new(file: PlanetFile, line: Arc<Line>) -> SlowFile {
        SlowFile { file, line }
    }
}

impl Records for SlowFile {
    fn path(&self) -> &Path {
        self.file.path()
    }

    fn cells(&self) -> u32 {
        self.file.header().cells
    }

    fn facts(&self, id: PatchId) -> Result<Option<PatchFacts>, StoreError> {
        let found = self.file.facts(id);
        self.line.carry(facts::BYTES);
        found
    }

    fn bytes(&self, id: PatchId, part: Part, range: Range<usize>) -> Result<Option<Vec<u8>>, StoreError> {
        let found = Records::bytes(&self.file, id, part, range);
        self.line.carry(length(&found));
        found
    }

    fn cloud_record(&self) -> Result<Option<Vec<u8>>, StoreError> {
        let found = self.file.cloud_record();
        self.line.carry(length(&found));
        found
    }
}

/// Bytes of an answer.
fn length(answer: &Result<Option<Vec<u8>>, StoreError>) -> usize {
    answer.as_ref().ok().and_then(Option::as_ref).map_or(0, Vec::len)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_share_the_line_and_wait_out_its_latency_together() {
        let delay = Delay { latency: Duration::from_millis(300), bytes_per_second: 1e6 };
        let line = Line::new(delay);
        let begun = Instant::now();
        std::thread::scope(|scope| (0..4).for_each(|_| drop(scope.spawn(|| line.carry(10_000)))));
        let took = begun.elapsed();
        // Four latencies one after the other would be 1.2 s, four answers at once 310 ms.
        assert!(took >= Duration::from_millis(340) && took < Duration::from_millis(1100), "{took:?}");
    }
}
