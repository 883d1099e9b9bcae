//! Places that the viewer flew to, as a browser keeps pages. In: where they left and where to. Out: the place before and the one after.

use super::pose::Pose;

/// Most places that are remembered.
const MOST: usize = 100;

/// Places in the order of their visits, and at which the viewer is.
#[derive(Default)]
pub(super) struct History {
    places: Vec<Pose>,
    at: usize,
}

impl History {
    /// The viewer leaves a place for another.
    pub(super) fn visit(&mut self, from: Pose, to: Pose) {
        self.places.truncate(self.at);
        self.places.extend([from, to]);
        let surplus = self.places.len().saturating_sub(MOST);
        self.places.drain(..surplus);
        self.at = self.places.len() - 1;
    }

    /// The place before, for a viewer who may have moved since they came.
    pub(super) fn back(&mut self, from: Pose) -> Option<Pose> {
        let before = self.at.checked_sub(1)?;
        self.places[self.at] = from;
        self.at = before;
        self.places.get(before).copied()
    }

    /// The place after.
    pub(super) fn forward(&mut self) -> Option<Pose> {
        let place = self.places.get(self.at + 1).copied()?;
        self.at += 1;
        Some(place)
    }

    /// Whether there is a place before, and one after.
    pub(super) fn has(&self) -> [bool; 2] {
        [self.at > 0, self.at + 1 < self.places.len()]
    }
}

#[cfg(test)]
mod tests {
    use super::super::pose::tests::pose;
    use super::*;

    #[test]
    fn places_come_back_in_the_order_of_a_browser() {
        let [a, b, c, moved] = [1.0, 2.0, 3.0, 4.0].map(|altitude_m| pose(altitude_m, 0.0, 0.0));
        let mut history = History::default();
        assert_eq!((history.has(), history.back(a), history.forward()), ([false; 2], None, None));
        history.visit(a, b);
        history.visit(b, c);
        assert_eq!((history.back(moved), history.back(b), history.back(a)), (Some(b), Some(a), None));
        assert_eq!((history.forward(), history.forward(), history.forward()), (Some(b), Some(moved), None));
        history.back(moved);
        history.visit(b, a);
        assert_eq!((history.has(), history.back(a)), ([true, false], Some(b)));
    }

    #[test]
    fn only_so_many_places_are_remembered() {
        let mut history = History::default();
        (0..1000).for_each(|k| history.visit(pose(f64::from(k), 0.0, 0.0), pose(f64::from(k) + 0.5, 0.0, 0.0)));
        assert!(history.places.len() <= MOST);
        assert_eq!(history.back(pose(0.0, 0.0, 0.0)), Some(pose(999.0, 0.0, 0.0)));
    }
}
