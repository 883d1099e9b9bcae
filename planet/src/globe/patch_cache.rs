//! An LRU cache of things that belong to patches.

use super::patch::PatchId;
use std::collections::HashMap;

/// Things of up to so many patches. Past that the least recently used half goes.
pub(crate) struct PatchCache<T> {
    /// Each with the time of its latest use.
    kept: HashMap<PatchId, (T, u64)>,
    clock: u64,
    most: usize,
}

impl<T: Clone> PatchCache<T> {
    /// Nothing yet, and room for `most`.
    pub(crate) fn new(most: usize) -> PatchCache<T> {
        PatchCache { kept: HashMap::new(), clock: 0, most }
    }

    /// What is kept of a patch; it counts as used.
    pub(crate) fn get(&mut self, id: PatchId) -> Option<T> {
        self.clock += 1;
        let (thing, used) = self.kept.get_mut(&id)?;
        *used = self.clock;
        Some(thing.clone())
    }

    /// A cache of the same size, with what is kept of the patches that a condition names.
    pub(crate) fn of_those(&self, condition: impl Fn(PatchId) -> bool) -> PatchCache<T> {
        let kept = self.kept.iter().filter(|(id, _)| condition(**id)).map(|(id, kept)| (*id, kept.clone())).collect();
        PatchCache { kept, ..*self }
    }

    /// Keeps something of a patch.
    pub(crate) fn insert(&mut self, id: PatchId, thing: T) {
        if self.kept.len() >= self.most {
            let mut times: Vec<u64> = self.kept.values().map(|(_, used)| *used).collect();
            let (_, &mut middle, _) = times.select_nth_unstable(self.most / 2);
            self.kept.retain(|_, (_, used)| *used > middle);
        }
        self.kept.insert(id, (thing, self.clock));
    }
}
