//! Regions of a patch's grid: of all samples, which vertex of a prefix each falls to. Parents are stored by them, and they say how a
//! prefix is drawn without the vertices that follow it.
//!
//! In a chunk a vertex and its parent fall to the same vertex of the chunks before. So a parent is one of few, the *members* of a region:
//! the vertex that all of it falls to, and what the chunk adds there. Once its vertices are known, a chunk says which member of its
//! region each other sample falls to.

/// No vertex.
pub(super) const NONE: u16 = u16::MAX;

/// What a sample's neighbours say first: that it falls to the same vertex as the one before it in its row, or as the one in the row before.
const AS_BEFORE: u32 = 0;
const AS_ABOVE: u32 = 1;

/// Codes from here on are ranks among a region's members.
const RANKS: u32 = 2;

/// The regions of a prefix, and the members that the next chunk gives them.
pub(super) struct Regions {
    side: usize,
    /// For every grid position the vertex index that it falls to.
    of: Vec<u16>,
    /// Where the members of a region begin in `members`, and how many there are.
    first: Vec<u32>,
    count: Vec<u32>,
    members: Vec<u16>,
}

impl Regions {
    /// All of a grid as one region that has no vertex yet.
    pub(super) fn new(side: usize) -> Regions {
        Regions { side, of: vec![0; side * side], first: vec![0], count: vec![0], members: vec![NONE; side * side] }
    }

    /// The regions of the first `prefix` vertices, each of which is the first member of its own. `of` names no others.
    pub(super) fn of(side: usize, of: Vec<u16>, prefix: usize) -> Regions {
        let mut first = vec![0; prefix + 1];
        of.iter().for_each(|&region| first[usize::from(region) + 1] += 1);
        (0..prefix).for_each(|region| first[region + 1] += first[region]);
        let mut members = vec![NONE; of.len()];
        (0..prefix).for_each(|region| members[first[region] as usize] = region as u16);
        first.pop();
        Regions { side, of, first, count: vec![1; prefix], members }
    }

    /// Adds a vertex, of which no other has the grid position, to its region. Says which it is, and which number among its members.
    pub(super) fn add(&mut self, grid: usize, vertex: u16) -> (usize, u32) {
        let region = usize::from(self.of[grid]);
        let rank = self.count[region];
        self.count[region] += 1;
        self.members[(self.first[region] + rank) as usize] = vertex;
        (region, rank)
    }

    /// A member by its number.
    pub(super) fn member(&self, region: usize, rank: u32) -> Option<u16> {
        (rank < self.count[region]).then(|| self.members[(self.first[region] + rank) as usize])
    }

    /// The number of a vertex that is a member.
    pub(super) fn rank(&self, region: usize, vertex: u16) -> u32 {
        let members = &self.members[self.first[region] as usize..][..self.count[region] as usize];
        // Members are in wake order.
        members.partition_point(|&member| member < vertex) as u32
    }

    /// For every grid position the vertex index that it falls to once the members added are vertices too. `index_of` has the vertex at each
    /// grid position, `code` what is stored of a position that has none and more than one member to fall to: `None` ends it.
    pub(super) fn refined(&self, index_of: &[u16], mut code: impl FnMut(&Choice) -> Option<u32>) -> Option<Vec<u16>> {
        let mut refined = vec![0u16; self.of.len()];
        for row in (0..self.of.len()).step_by(self.side) {
            for at in row..row + self.side {
                let region = self.of[at];
                let own = usize::from(region);
                refined[at] = if index_of[at] != NONE {
                    index_of[at]
                } else if self.count[own] == 1 {
                    self.members[self.first[own] as usize]
                } else {
                    let before = (at > row && self.of[at - 1] == region).then(|| refined[at - 1]);
                    let above = (row > 0 && self.of[at - self.side] == region).then(|| refined[at - self.side]);
                    match code(&Choice { at, region: own, before, above })? {
                        AS_BEFORE => before?,
                        AS_ABOVE => above?,
                        rank => self.member(own, rank - RANKS)?,
                    }
                };
            }
        }
        Some(refined)
    }

    /// The codes that [`Regions::refined`] reads, for `refined` regions.
    pub(super) fn codes(&self, index_of: &[u16], refined: &[u16]) -> Vec<u32> {
        let mut codes = Vec::with_capacity(refined.len());
        self.refined(index_of, |choice| {
            let falls_to = refined[choice.at];
            let code = if choice.before == Some(falls_to) {
                AS_BEFORE
            } else if choice.above == Some(falls_to) {
                AS_ABOVE
            } else {
                RANKS + self.rank(choice.region, falls_to)
            };
            codes.push(code);
            Some(code)
        });
        codes
    }
}

/// A grid position for which something is stored.
pub(super) struct Choice {
    at: usize,
    region: usize,
    /// What its neighbours of the same region fall to.
    before: Option<u16>,
    above: Option<u16>,
}
