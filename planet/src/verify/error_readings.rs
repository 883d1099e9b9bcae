//! Screen errors collected: percentiles of all readings, and where the largest was read.

use crate::globe::patch::PatchId;
use glam::DVec3;
use hdrhistogram::Histogram;
use std::fmt;

/// Histograms count millionths of a pixel, to three digits; the largest reading is kept exactly.
const STEPS_PER_PIXEL: f64 = 1e6;

/// Largest reading that a histogram tells from larger ones, in pixels.
const MOST_PIXELS: f64 = 1e9;

/// How a point was chosen to be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Probe {
    /// A camera ray through a random pixel.
    Pixel,
    /// A vertex of a drawn patch that sleeps, or slides.
    Sleeper,
    /// A sample of a finer resident patch than the drawn one.
    FinerSample,
}

impl fmt::Display for Probe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Probe::Pixel => "pixel",
            Probe::Sleeper => "sleeping vertex",
            Probe::FinerSample => "finer sample",
        })
    }
}

/// One measured point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Angle between the drawn and the finest surface, seen by the camera, in pixels of the picture's middle.
    pub pixels: f64,
    /// Drawn patch.
    pub patch: PatchId,
    /// How the point was chosen.
    pub probe: Probe,
    /// Unit direction of the point.
    pub direction: DVec3,
    /// Distance of the drawn surface from the planet's centre in metres.
    pub drawn_m: f64,
    /// Distance of the finest surface from the planet's centre in metres.
    pub finest_m: f64,
    /// Distance from the camera to the nearer of the two in metres.
    pub distance_m: f64,
}

/// Many readings.
#[derive(Clone, Debug)]
pub struct ErrorReadings {
    pixels: Histogram<u64>,
    /// By [`Probe`].
    worst: [Option<Reading>; 3],
}

impl Default for ErrorReadings {
    fn default() -> Self {
        ErrorReadings { pixels: Histogram::new(3).expect("three digits are in range"), worst: [None; 3] }
    }
}

impl ErrorReadings {
    /// Adds one.
    pub fn add(&mut self, reading: Reading) {
        let steps = (reading.pixels.min(MOST_PIXELS) * STEPS_PER_PIXEL).round() as u64;
        self.pixels.record(steps).expect("a histogram that resizes holds every reading");
        self.note_worst(reading);
    }

    /// Adds all of another collection.
    pub fn merge(&mut self, other: &ErrorReadings) {
        self.pixels.add(&other.pixels).expect("a histogram that resizes holds another");
        other.worst.iter().flatten().for_each(|&reading| self.note_worst(reading));
    }

    fn note_worst(&mut self, reading: Reading) {
        let worst = &mut self.worst[reading.probe as usize];
        if worst.is_none_or(|worst| reading.pixels > worst.pixels) {
            *worst = Some(reading);
        }
    }

    /// Number of readings.
    pub fn count(&self) -> u64 {
        self.pixels.len()
    }

    /// The reading below which a share of all lie, in pixels to three digits; 0 without readings.
    pub fn percentile(&self, share: f64) -> f64 {
        (self.pixels.value_at_quantile(share) as f64 / STEPS_PER_PIXEL).min(self.max())
    }

    /// The largest reading in pixels, exactly; 0 without readings.
    pub fn max(&self) -> f64 {
        self.worst().map_or(0.0, |worst| worst.pixels)
    }

    /// The largest reading.
    pub fn worst(&self) -> Option<&Reading> {
        self.worst.iter().flatten().max_by(|a, b| a.pixels.total_cmp(&b.pixels))
    }

    /// The largest reading of points chosen in one way, in pixels; 0 without any.
    pub fn max_of(&self, probe: Probe) -> f64 {
        self.worst[probe as usize].map_or(0.0, |worst| worst.pixels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(pixels: f64) -> Reading {
        let patch = PatchId::roots().next().unwrap();
        Reading { pixels, patch, probe: Probe::Pixel, direction: DVec3::X, drawn_m: 1.0, finest_m: 1.0, distance_m: 1.0 }
    }

    #[test]
    fn percentiles_and_the_largest_survive_merging() {
        let (mut low, mut high) = (ErrorReadings::default(), ErrorReadings::default());
        (0..500).for_each(|k| low.add(reading(f64::from(k) / 1000.0)));
        (500..1000).for_each(|k| high.add(reading(f64::from(k) / 1000.0)));
        high.add(reading(7.000_000_123));
        low.merge(&high);
        assert_eq!((low.count(), low.max()), (1001, 7.000_000_123));
        assert!((low.percentile(0.5) - 0.5).abs() < 2e-3 && (low.percentile(0.99) - 0.99).abs() < 2e-3);
    }
}
