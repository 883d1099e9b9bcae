//! Finds for a method the knob with which its measured error is the target.

use super::sheet::{Reading, Sheet};
use super::{Method, Setting, Viewpoint};
use glam::DVec3;
use rayon::prelude::*;
use terrane_planet::store::StoreError;

/// How near to the target the measured error must come, relative to it.
const NEAR: f64 = 0.03;

/// Most knobs that are tried.
const TRIES: usize = 14;

/// Of so many frames one is drawn to choose between variants.
const CHOOSING: usize = 4;

/// Which error is made equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Equal {
    /// The largest at any probe of any frame.
    Max,
    /// The 99.9th percentile at the random pixels of all frames.
    P999,
}

impl Equal {
    /// Both.
    pub(crate) const ALL: [Equal; 2] = [Equal::Max, Equal::P999];

    /// In words.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Equal::Max => "max",
            Equal::P999 => "p99.9",
        }
    }
}

/// What a method shows over all frames with one knob.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    /// Which method.
    pub(crate) family: &'static str,
    /// Which variant of it.
    pub(crate) variant: String,
    /// The knob.
    pub(crate) knob: f64,
    /// Largest error in pixels.
    pub(crate) max: f64,
    /// 99.9th percentile of the errors at random pixels.
    pub(crate) p999: f64,
    /// Median of the same.
    pub(crate) p50: f64,
    /// Triangles in the frustum that face the camera, by frame.
    pub(crate) in_view: Vec<usize>,
    /// Triangles before that culling, all frames together.
    pub(crate) submitted: usize,
    /// Largest error by frame.
    pub(crate) max_by_frame: Vec<f64>,
    /// Where the largest of all was read: the frame, and the position in lattice units from the planet's centre.
    pub(crate) worst: (usize, DVec3),
    /// Probes under no triangle.
    pub(crate) missed: usize,
}

impl Measured {
    /// The error that is made equal.
    pub(crate) fn error(&self, equal: Equal) -> f64 {
        match equal {
            Equal::Max => self.max,
            Equal::P999 => self.p999,
        }
    }

    /// Mean of the triangles in view.
    pub(crate) fn mean_in_view(&self) -> f64 {
        self.in_view.iter().sum::<usize>() as f64 / self.in_view.len().max(1) as f64
    }
}

/// Draws and measures all viewpoints with one knob.
pub(crate) fn measure(
    setting: &Setting,
    viewpoints: &[&Viewpoint],
    method: &dyn Method,
    knob: f64,
) -> Result<Measured, StoreError> {
    let reading = |viewpoint: &&Viewpoint| {
        let view = setting.view(&viewpoint.camera, knob);
        let mut sheet = Sheet::new(&view, &viewpoint.probes, setting.tree.lattice.radius);
        method.draw(setting, &viewpoint.camera, knob, &mut sheet)?;
        Ok(sheet.finish())
    };
    let readings: Vec<Reading> = viewpoints.par_iter().map(reading).collect::<Result<_, _>>()?;
    let mut at_pixels: Vec<f32> = readings.iter().flat_map(|r| r.at_pixels.iter().copied()).collect();
    at_pixels.sort_unstable_by(f32::total_cmp);
    let percentile = |share: f64| at_pixels.get((at_pixels.len() as f64 * share) as usize).copied().map_or(0.0, f64::from);
    Ok(Measured {
        family: method.family(),
        variant: method.variant(),
        knob,
        max: readings.iter().map(|r| r.max).fold(0.0, f64::max),
        p999: percentile(0.999),
        p50: percentile(0.5),
        in_view: readings.iter().map(|r| r.in_view).collect(),
        submitted: readings.iter().map(|r| r.submitted).sum(),
        worst: readings
            .iter()
            .enumerate()
            .max_by(|a, b| a.1.max.total_cmp(&b.1.max))
            .map_or((0, DVec3::X), |(k, r)| (k, r.worst)),
        max_by_frame: readings.iter().map(|r| r.max).collect(),
        missed: readings.iter().map(|r| r.missed).sum(),
    })
}

/// Where to look for a knob.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    /// Which error is made equal.
    pub(crate) equal: Equal,
    /// To what, in pixels.
    pub(crate) target: f64,
    /// The first knob tried.
    pub(crate) first: f64,
    /// Most triangles in view of interest.
    pub(crate) most: f64,
}

/// The coarsest drawing found whose error is within [`NEAR`] of the target or below it. Errors rise with the knob, not steadily: where
/// one frame's worst point decides, they jump, and what is found may stay below the target. `None` if none was found, or if even
/// a drawing that is too coarse takes more triangles than are of interest.
pub(crate) fn tune(
    setting: &Setting,
    viewpoints: &[&Viewpoint],
    method: &dyn Method,
    aim: Aim,
) -> Result<Option<Measured>, StoreError> {
    let Aim { equal, target, first, most } = aim;
    let (mut low, mut high) = (None::<Measured>, None::<f64>);
    let mut knob = first;
    for _ in 0..TRIES {
        let outcome = measure(setting, viewpoints, method, knob)?;
        let error = outcome.error(equal);
        let ratio = target / error.max(1e-3 * target);
        let good = error <= target * (1.0 + NEAR);
        if good {
            low = low.filter(|known| known.knob > knob).or(Some(outcome));
        } else if outcome.mean_in_view() > most {
            return Ok(None);
        } else {
            high = Some(high.map_or(knob, |known| known.min(knob)));
        }
        let reached = low.as_ref().map(|low| low.knob);
        if good && (error >= target * (1.0 - NEAR) || high.zip(reached).is_some_and(|(high, low)| high < low * 1.01)) {
            break;
        }
        let guess = knob * ratio.clamp(0.125, 8.0);
        knob = match (reached, high) {
            // A guess too near to an end of the bracket does not shrink it.
            (Some(low), Some(high)) => guess.clamp(low.powf(0.8) * high.powf(0.2), low.powf(0.2) * high.powf(0.8)),
            _ => guess,
        };
    }
    Ok(low)
}

/// The best variant of a family: found on some of the frames, measured on all. `None` if no variant comes near the target.
pub(crate) fn best(
    setting: &Setting,
    viewpoints: &[Viewpoint],
    methods: &[Box<dyn Method>],
    (equal, target): (Equal, f64),
    progress: &mut dyn FnMut(&Measured),
) -> Result<Option<Measured>, StoreError> {
    let all: Vec<&Viewpoint> = viewpoints.iter().collect();
    let some: Vec<&Viewpoint> = viewpoints.iter().skip((CHOOSING / 2).min(viewpoints.len() / 2)).step_by(CHOOSING).collect();
    let mut aim = Aim { equal, target, first: target, most: f64::INFINITY };
    let mut chosen = &methods[0];
    for method in methods.iter().filter(|_| methods.len() > 1) {
        let Some(outcome) = tune(setting, &some, method.as_ref(), aim)? else { continue };
        progress(&outcome);
        if outcome.mean_in_view() < aim.most {
            chosen = method;
            aim = Aim { most: outcome.mean_in_view(), first: outcome.knob, ..aim };
        }
    }
    let outcome = tune(setting, &all, chosen.as_ref(), Aim { most: f64::INFINITY, ..aim })?;
    outcome.iter().for_each(progress);
    Ok(outcome)
}
