//! A flight along a shore, level and low. In: a planet and where to look for a shore. Out: keyframes with heights that clear the ground.
//!
//! The shore is walked as with a pair of compasses (Richardson 1961): each step leads to where the circle of one step around the last
//! point leaves the sea, with the land to the right. What winds more than the compasses are open is passed by. Where there is no sea, a
//! line of equal height does as well, with the higher ground to the right.

use super::{moved, short_way, site, Circle, Stop, FOV, SITES};
use crate::draw::camera_path::Keyframe;
use crate::draw::view_line::Stand;
use crate::globe::sphere::latitude_longitude;
use crate::planet::Planet;
use glam::DVec3;

/// Metres above the ground and the sea, and the most of them as a share of the planet's radius.
const CLEARANCE_M: f64 = 300.0;
const CLEARANCE_SHARE: f64 = 1.0 / 300.0;

/// Openings of the compasses in clearances, and how often they are put down.
const STEP: f64 = 4.0;
const STEPS: usize = 20;

/// Clearances flown a second.
const SPEED: f64 = 1.2;

/// Degrees to each side in which the shore may go on, and between directions that are tried.
const BEND: i32 = 135;
const TRIED: usize = 15;

/// Degrees to the right of the way, and above the horizontal, that the camera looks.
const ASIDE: f64 = 12.0;
const PITCH: f64 = -9.0;

/// Largest rise of the flight over its way.
const CLIMB: f64 = 0.25;

/// Halvings with which a shore is found: to a part in a thousand of a step.
const HALVINGS: u32 = 12;

/// Rings about a stop on which a shore is looked for, each twice as far as the one before, the first at a step.
const RINGS: i32 = 6;

/// Keyframes of a flight along the shore that is nearest to the first stop with one.
pub(super) fn keyframes(planet: &Planet, stops: &[Stop]) -> Vec<Keyframe> {
    let clearance = CLEARANCE_M.min(CLEARANCE_SHARE * planet.recipe.radius);
    let step = STEP * clearance / planet.recipe.radius;
    let walk = Walk::new(planet, stops, step);
    let points = smoothed(walk.points());
    let heights = heights(planet, &points, step, clearance);
    let seconds = STEP / SPEED;
    let keyframe = |k: usize| {
        let (latitude, longitude) = latitude_longitude(points[k]);
        let [before, after] = [k.saturating_sub(1), (k + 1).min(points.len() - 1)];
        let circle = Circle::between(points[before], points[after]);
        let heading = circle.heading((k - before) as f64 / (after - before) as f64) + ASIDE;
        let pitch = PITCH - (planet.recipe.radius / (planet.recipe.radius + clearance)).acos().to_degrees();
        let stand = Stand::Height(heights[k]);
        Keyframe { time_s: seconds * k as f64, latitude, longitude, stand, heading: short_way(heading), pitch, fov: FOV }
    };
    (0..points.len()).map(keyframe).collect()
}

/// A walk along a shore.
struct Walk<'a> {
    planet: &'a Planet,
    /// Metres above the datum where the shore is.
    level: f64,
    start: DVec3,
    /// Radians of a step.
    step: f64,
}

impl<'a> Walk<'a> {
    fn new(planet: &'a Planet, stops: &[Stop], step: f64) -> Walk<'a> {
        let first = stops.first().map_or(DVec3::X, |stop| stop.up);
        let sea = planet.terrain.sea_level();
        // Half the ground about the stop is lower than that, and half is higher.
        let level = sea.unwrap_or_else(|| {
            let mut around: Vec<f64> =
                (0..16).map(|k| planet.terrain.height(moved(first, f64::from(k) * 22.5, 4.0 * step))).collect();
            around.sort_by(f64::total_cmp);
            around[around.len() / 2]
        });
        let mut walk = Walk { planet, level, start: first, step };
        let nearest = stops.iter().find_map(|stop| walk.shore_near(stop.up));
        let other = || (0..SITES).map(site).filter(|to| walk.is_land(*to) != walk.is_land(first));
        let far = || other().max_by(|a, b| a.dot(first).total_cmp(&b.dot(first))).map(|to| walk.shore_between(first, to));
        walk.start = nearest.or_else(far).unwrap_or(first);
        walk
    }

    fn is_land(&self, up: DVec3) -> bool {
        self.planet.terrain.height(up) > self.level
    }

    /// The first shore on rings about a direction.
    fn shore_near(&self, up: DVec3) -> Option<DVec3> {
        let land = self.is_land(up);
        let ring = |k: i32| (0..24).map(move |turn| moved(up, f64::from(turn) * 15.0, self.step * 2f64.powi(k)));
        (0..RINGS).flat_map(ring).find(|to| self.is_land(*to) != land).map(|to| self.shore_between(up, to))
    }

    /// A shore on the way from land to sea or back.
    fn shore_between(&self, from: DVec3, to: DVec3) -> DVec3 {
        let (circle, land) = (Circle::between(from, to), self.is_land(from));
        // A step a part in a thousand, whatever the way.
        let halvings = HALVINGS + (circle.angle / self.step).max(1.0).log2().ceil() as u32;
        circle.at(halved(0.0, 1.0, halvings, |share| self.is_land(circle.at(share)) != land))
    }

    /// The heading nearest to another, within degrees of it, at which the circle of a step comes from the sea to land.
    fn onward(&self, up: DVec3, heading: f64, bend: i32) -> Option<f64> {
        let land = |turn: f64| self.is_land(moved(up, heading + turn, self.step));
        let turns: Vec<f64> = (-bend..=bend).step_by(TRIED).map(f64::from).collect();
        let shores = turns.windows(2).filter(|pair| !land(pair[0]) && land(pair[1]));
        let nearest = shores.min_by(|a, b| (a[0] + a[1]).abs().total_cmp(&(b[0] + b[1]).abs()))?;
        Some(heading + halved(nearest[0], nearest[1], HALVINGS, land))
    }

    /// Where the compasses are put down.
    fn points(&self) -> Vec<DVec3> {
        let mut points = vec![self.start];
        let mut heading = self.onward(self.start, 0.0, 180).unwrap_or(0.0);
        for _ in 0..STEPS {
            let here = points[points.len() - 1];
            heading = self.onward(here, heading, if points.len() == 1 { 180 } else { BEND }).unwrap_or(heading);
            let there = moved(here, heading, self.step);
            points.push(there);
            heading = Circle::between(here, there).heading(1.0);
        }
        points
    }
}

/// Where between two numbers a condition begins to hold that holds at the second, and not at the first.
fn halved(mut from: f64, mut to: f64, times: u32, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..times {
        let middle = 0.5 * (from + to);
        if holds(middle) {
            to = middle;
        } else {
            from = middle;
        }
    }
    to
}

/// The points without their smallest bends.
fn smoothed(mut points: Vec<DVec3>) -> Vec<DVec3> {
    for _ in 0..2 {
        let before = points.clone();
        for k in 1..points.len() - 1 {
            points[k] = (before[k - 1] + before[k] * 2.0 + before[k + 1]).normalize();
        }
    }
    points
}

/// Metres above the datum at every point that clear all ground on the ways to the points beside it, and rise gently.
fn heights(planet: &Planet, points: &[DVec3], step: f64, clearance: f64) -> Vec<f64> {
    let highest = |pair: &[DVec3]| {
        let circle = Circle::between(pair[0], pair[1]);
        let heading = circle.heading(0.5) + 90.0;
        let across = |share: f64| [-0.15, 0.0, 0.15].map(|aside| moved(circle.at(share), heading, aside * step));
        let sites = (0..=12).flat_map(|k| across(f64::from(k) / 12.0));
        sites.map(|up| planet.surface_height(up)).fold(f64::MIN, f64::max)
    };
    let legs: Vec<f64> = points.windows(2).map(highest).collect();
    let beside = |k: usize| legs[k.saturating_sub(1)].max(legs[k.min(legs.len() - 1)]);
    let mut heights: Vec<f64> = (0..points.len()).map(|k| clearance + beside(k)).collect();
    let rise = CLIMB * step * planet.recipe.radius;
    for k in 1..heights.len() {
        heights[k] = heights[k].max(heights[k - 1] - rise);
    }
    for k in (1..heights.len()).rev() {
        heights[k - 1] = heights[k - 1].max(heights[k] - rise);
    }
    heights
}
