//! The order of collapses: by rising key, octave by octave; within an octave tile by tile; and within a tile in steps of a
//! thirty-second of an octave.
//!
//! Every operation takes constant time (all but), and what is near in space is near in time: in strictly rising order, as from a
//! heap, the work jumps about the whole field, and at 1025² samples and more nearly every access misses the caches. Tiles commute
//! but for their rims, so callers that need a strict order can sort the collapses afterwards.

use std::collections::BTreeMap;

/// Bits of a key's mantissa that steps do not tell apart.
const DROPPED_BITS: u32 = 18;

/// Steps in an octave.
const STEPS: usize = 1 << (f32::MANTISSA_DIGITS - 1 - DROPPED_BITS);

/// Vertices that wait for their turn.
pub struct Queue {
    /// Vertices with their keys, by octave and tile.
    later: BTreeMap<(u32, u32), Vec<(f32, u32)>>,
    /// Octave and tile whose turn it is.
    current: (u32, u32),
    /// Their vertices by step.
    steps: Vec<Vec<u32>>,
    step: usize,
    /// What is left of the present step, last first.
    round: Vec<u32>,
}

impl Queue {
    /// Nothing waits yet.
    #[allow(clippy::new_without_default, reason = "an empty queue is made in one place only")]
    pub fn new() -> Queue {
        Queue { later: BTreeMap::new(), current: (0, 0), steps: vec![Vec::new(); STEPS], step: 0, round: Vec::new() }
    }

    /// Adds a vertex. One whose turn has passed comes as soon as its tile has a turn again.
    pub fn push(&mut self, key: f32, tile: u32, v: u32) {
        let (octave, step) = octave_and_step(key);
        let now = self.current.0;
        if octave > now || tile > self.current.1 {
            self.later.entry((octave.max(now), tile)).or_default().push((key, v));
        } else if tile < self.current.1 {
            self.later.entry((now + 1, tile)).or_default().push((key, v));
        } else {
            let step = if octave < now { self.step } else { step.max(self.step) };
            self.steps[step].push(v);
        }
    }

    /// Whether a vertex with this key need not wait any longer than the one popped last.
    pub fn is_due(&self, key: f32) -> bool {
        octave_and_step(key) <= (self.current.0, self.step)
    }

    /// The next vertex; those of one step by number.
    pub fn pop(&mut self) -> Option<u32> {
        while self.round.is_empty() {
            match (self.step..STEPS).find(|&step| !self.steps[step].is_empty()) {
                Some(step) => {
                    self.step = step;
                    std::mem::swap(&mut self.round, &mut self.steps[step]);
                    self.round.sort_unstable_by(|a, b| b.cmp(a));
                }
                None => {
                    let (current, vertices) = self.later.pop_first()?;
                    (self.current, self.step) = (current, 0);
                    for (key, v) in vertices {
                        let (octave, step) = octave_and_step(key);
                        self.steps[if octave < current.0 { 0 } else { step }].push(v);
                    }
                }
            }
        }
        self.round.pop()
    }
}

/// Octave and step of a key. Keys are not negative, so their bits order like numbers.
fn octave_and_step(key: f32) -> (u32, usize) {
    let bits = key.to_bits() >> DROPPED_BITS;
    (bits / STEPS as u32, bits as usize % STEPS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rest(mut queue: Queue) -> Vec<u32> {
        std::iter::from_fn(|| queue.pop()).collect()
    }

    #[test]
    fn vertices_come_out_in_the_order_of_their_keys() {
        let mut queue = Queue::new();
        for (key, v) in [(3.0, 7), (0.0, 9), (3.0, 2), (f32::INFINITY, 1), (100.0, 4)] {
            queue.push(key, 0, v);
        }
        assert_eq!((queue.pop(), queue.pop()), (Some(9), Some(2)));
        assert!(queue.is_due(3.01) && !queue.is_due(3.2));
        queue.push(1.0, 0, 5);
        assert_eq!(rest(queue), [7, 5, 4, 1]);
    }

    #[test]
    fn tiles_of_an_octave_come_out_one_after_another() {
        let mut queue = Queue::new();
        for (key, tile, v) in [(1.9, 0, 1), (1.1, 1, 2), (1.2, 0, 3), (2.5, 0, 4), (2.4, 1, 5)] {
            queue.push(key, tile, v);
        }
        assert_eq!([queue.pop(), queue.pop(), queue.pop()], [Some(3), Some(1), Some(2)]);
        // The first tile's turn in this octave has passed.
        queue.push(1.5, 0, 6);
        assert_eq!(rest(queue), [6, 4, 5]);
    }
}
