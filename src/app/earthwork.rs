//! The tool that changes the ground: what it does, how wide and how deep.

use crate::scene::{EditRequest, EditStatus};
use glam::DVec3;
use terrane_planet::globe::sphere::latitude_longitude;
use terrane_planet::planet::edits::mean_height;
use terrane_planet::planet::Planet;
use terrane_planet::recipe::{Edit, Shape};

/// Pixels that the cursor may move between press and release for a click.
pub(super) const STILL: f64 = 4.0;
/// Widest edit, as a share of the planet's radius: recipes allow a third.
const WIDEST: f64 = 0.05;

/// What the tool does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Work {
    #[default]
    Crater,
    Flatten,
    Raise,
    Lower,
}

impl Work {
    pub(super) const ALL: [Work; 4] = [Work::Crater, Work::Flatten, Work::Raise, Work::Lower];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Work::Crater => "crater",
            Work::Flatten => "flatten",
            Work::Raise => "raise",
            Work::Lower => "lower",
        }
    }
}

/// The tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tool {
    /// Whether a click uses it.
    pub(super) held: bool,
    pub(super) work: Work,
    /// Metres on the ground.
    pub(super) radius_m: f64,
    /// Metres in the middle.
    pub(super) depth_m: f64,
}

impl Default for Tool {
    fn default() -> Tool {
        Tool { held: false, work: Work::Crater, radius_m: 300.0, depth_m: 80.0 }
    }
}

impl Tool {
    /// Metres that a radius can be, on a planet.
    pub(super) fn radii(planet_m: f64) -> std::ops::RangeInclusive<f64> {
        5.0..=WIDEST * planet_m
    }

    /// What it asks for in a direction: as `terrane edit` would.
    pub(super) fn request(&self, planet: &Planet, site: DVec3) -> EditRequest {
        let (latitude_deg, longitude_deg) = latitude_longitude(site);
        let mean = || mean_height(planet, latitude_deg, longitude_deg, self.radius_m);
        let shape = match self.work {
            Work::Crater => Shape::Crater { depth_m: self.depth_m, ground_m: Some(mean()) },
            Work::Flatten => Shape::Flatten { height_m: mean() },
            Work::Raise => Shape::Raise { by_m: self.depth_m },
            Work::Lower => Shape::Raise { by_m: -self.depth_m },
        };
        EditRequest::Apply(Edit { latitude_deg, longitude_deg, radius_m: self.radius_m, shape })
    }
}

/// What an edit's state is in words; nothing if there is nothing to say.
pub(super) fn words(status: &EditStatus) -> Option<String> {
    use crate::scene::EditState as S;
    match &status.state {
        S::Idle => None,
        S::Storing => Some("the planet file is being changed".to_owned()),
        S::Loading { there, needed } => Some(format!("new ground: {there} of {needed} patches")),
        S::Finishing { built, total } => Some(format!("the file's coarser patches: {built} of {total}")),
        S::Failed { message } => Some(message.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrane_planet::globe::sphere::direction_at;
    use terrane_planet::recipe::shipped;

    #[test]
    fn the_tool_asks_for_what_it_shows_where_it_is_put_down() {
        let planet = Planet::from_recipe(shipped::load("tiny").unwrap(), 32).unwrap();
        let ground = mean_height(&planet, -38.95, 34.34, 300.0);
        for work in Work::ALL {
            let tool = Tool { work, ..Tool::default() };
            let EditRequest::Apply(edit) = tool.request(&planet, direction_at(-38.95, 34.34)) else { panic!("{work:?}") };
            assert!(edit.check(planet.recipe.radius).is_ok());
            assert!((edit.latitude_deg + 38.95).abs() < 1e-9 && (edit.longitude_deg - 34.34).abs() < 1e-9);
            let expected = match work {
                Work::Crater => Shape::Crater { depth_m: 80.0, ground_m: Some(ground) },
                Work::Flatten => Shape::Flatten { height_m: ground },
                Work::Raise => Shape::Raise { by_m: 80.0 },
                Work::Lower => Shape::Raise { by_m: -80.0 },
            };
            assert_eq!((edit.shape, edit.radius_m), (expected, 300.0));
        }
    }
}
