//! A camera path while the user makes it: keyframes that are added, moved and taken away. In: where the viewer is. Out: a route.

use terrane_planet::draw::camera_path::{CameraPath, Keyframe, Pace, PathError, Route};

/// Seconds from one keyframe to the next that is added.
const STEP_S: f64 = 5.0;

/// What is to be done to the keyframes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Revision {
    /// One more at the end, where the viewer is.
    Add,
    /// Put this one where the viewer is.
    Set(usize),
    /// Take this one away.
    Remove(usize),
    /// Exchange this one with the next: their places, not their times.
    Exchange(usize),
    /// At another time: those after it are moved on as much.
    Time(usize, f64),
    /// Take all away.
    Clear,
}

/// Keyframes that are worked on.
#[derive(Clone, Debug, Default)]
pub(super) struct Storyboard {
    pub(super) pace: Pace,
    keyframes: Vec<Keyframe>,
}

impl Storyboard {
    pub(super) fn keyframes(&self) -> &[Keyframe] {
        &self.keyframes
    }

    /// Works on another route from now on.
    pub(super) fn take(&mut self, route: Route) {
        (self.pace, self.keyframes) = (route.pace, route.keyframes);
    }

    pub(super) fn route(&self) -> Route {
        Route { pace: self.pace, keyframes: self.keyframes.clone() }
    }

    /// The path, over a planet of a radius in metres.
    ///
    /// # Errors
    /// Fewer than two keyframes, or ones that make no path.
    pub(super) fn path(&self, radius_m: f64) -> Result<CameraPath, PathError> {
        self.route().path(radius_m)
    }

    /// Does what is asked for; `here` is where the viewer is.
    pub(super) fn revise(&mut self, revision: Revision, here: Keyframe) {
        let count = self.keyframes.len();
        match revision {
            Revision::Add => {
                let time_s = self.keyframes.last().map_or(0.0, |last| last.time_s + STEP_S);
                self.keyframes.push(Keyframe { time_s, ..here });
            }
            Revision::Set(at) if at < count => {
                self.keyframes[at] = Keyframe { time_s: self.keyframes[at].time_s, ..here };
            }
            Revision::Remove(at) if at < count => drop(self.keyframes.remove(at)),
            Revision::Exchange(at) if at + 1 < count => {
                let times = [self.keyframes[at].time_s, self.keyframes[at + 1].time_s];
                self.keyframes.swap(at, at + 1);
                (self.keyframes[at].time_s, self.keyframes[at + 1].time_s) = (times[0], times[1]);
            }
            Revision::Time(at, time_s) if at < count && time_s.is_finite() => {
                let least = if at == 0 { 0.0 } else { self.keyframes[at - 1].time_s + 0.1 };
                let later = time_s.max(least) - self.keyframes[at].time_s;
                self.keyframes[at..].iter_mut().for_each(|keyframe| keyframe.time_s += later);
            }
            Revision::Clear => self.keyframes.clear(),
            Revision::Set(_) | Revision::Remove(_) | Revision::Exchange(_) | Revision::Time(..) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrane_planet::draw::view_line::Stand;

    fn at(latitude: f64) -> Keyframe {
        Keyframe { time_s: 99.0, latitude, longitude: 8.0, stand: Stand::Height(4000.0), heading: 0.0, pitch: -10.0, fov: 50.0 }
    }

    fn rows(board: &Storyboard) -> Vec<(f64, f64)> {
        board.keyframes().iter().map(|keyframe| (keyframe.time_s, keyframe.latitude)).collect()
    }

    #[test]
    fn keyframes_are_added_moved_and_taken_away_and_always_make_a_path() {
        let mut board = Storyboard::default();
        assert!(board.path(6e6).is_err());
        for latitude in [1.0, 2.0, 3.0] {
            board.revise(Revision::Add, at(latitude));
        }
        assert_eq!(rows(&board), [(0.0, 1.0), (5.0, 2.0), (10.0, 3.0)]);
        board.revise(Revision::Exchange(0), at(9.0));
        board.revise(Revision::Set(2), at(4.0));
        board.revise(Revision::Time(1, 7.5), at(9.0));
        assert_eq!(rows(&board), [(0.0, 2.0), (7.5, 1.0), (12.5, 4.0)]);
        board.revise(Revision::Time(2, -1.0), at(9.0));
        assert_eq!(rows(&board)[2], (7.6, 4.0));
        board.revise(Revision::Remove(0), at(9.0));
        assert_eq!(board.path(6e6).unwrap().span(), (7.5, 7.6));
        for beyond in [Revision::Set(7), Revision::Remove(7), Revision::Exchange(1), Revision::Time(7, 1.0)] {
            board.revise(beyond, at(9.0));
        }
        assert_eq!(rows(&board).len(), 2);
        board.revise(Revision::Clear, at(9.0));
        assert!(board.keyframes().is_empty());
    }
}
