//! Which patches a planet file is to hold: the whole planet to one level, and perhaps a region to a finer one.

use crate::globe::patch::{PatchId, Side, MAX_LEVEL};
use crate::store::Region;
use glam::DVec3;
use std::collections::BTreeSet;
use thiserror::Error;

/// How far beyond a region, in patch sizes of the level above, patches are still refined. A viewer inside the region wants
/// children for their textures' sake within about one and a half sizes; a little less saves a third of the patches and shows
/// only as a softer far distance.
pub const FUNNEL: f64 = 1.0;

/// Most patches in a plan; more would take weeks and terabytes.
pub const MOST_PATCHES: usize = 4_000_000;

/// A plan that cannot be.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PlanError {
    /// A level past the deepest.
    #[error("level {found} is too deep, expected at most {MAX_LEVEL}")]
    TooDeep {
        /// Level asked for.
        found: u8,
    },
    /// A region whose finest level is not below that of the whole planet.
    #[error(
        "the region's level {found} is not finer than the planet's level {levels}; ask for a deeper one or leave the region out"
    )]
    RegionNotFiner {
        /// Level of the region.
        found: u8,
        /// Level of the whole planet.
        levels: u8,
    },
    /// A centre or radius of no region.
    #[error("a region of {found} m about {direction}, expected a finite radius of 0 or more about a unit direction")]
    NoRegion {
        /// Radius asked for.
        found: f64,
        /// Direction asked for.
        direction: DVec3,
    },
    /// More patches than can be baked.
    #[error("more than {MOST_PATCHES} patches; ask for fewer levels or a smaller region")]
    TooMany,
}

/// The patches to bake, coarse to fine.
#[derive(Clone, Debug, PartialEq)]
pub struct BakePlan {
    /// Ids by level, then face, row and column.
    pub patches: Vec<PatchId>,
    /// The region, if one is finer.
    pub region: Option<Region>,
}

impl BakePlan {
    /// All patches of levels 0 to `levels`, and inside a region down to its level, 2:1 balanced across patch edges. `radius_m` is
    /// the planet's.
    ///
    /// # Errors
    /// For levels too deep, regions that are none or not finer, and more than [`MOST_PATCHES`] patches.
    pub fn new(radius_m: f64, levels: u8, region: Option<Region>) -> Result<BakePlan, PlanError> {
        let deepest = region.map_or(levels, |r| r.to_level);
        if levels.max(deepest) > MAX_LEVEL {
            return Err(PlanError::TooDeep { found: levels.max(deepest) });
        }
        if whole_planet(levels) > MOST_PATCHES as u64 {
            return Err(PlanError::TooMany);
        }
        let mut wanted: Vec<BTreeSet<PatchId>> = vec![PatchId::roots().collect()];
        for level in 1..=levels {
            let children = wanted[usize::from(level) - 1].iter().filter_map(|id| id.children()).flatten().collect();
            wanted.push(children);
        }
        if let Some(region) = region {
            check_region(&region, levels)?;
            for level in levels + 1..=region.to_level {
                let parents = wanted[usize::from(level) - 1].iter().filter(|&&id| in_funnel(id, &region, radius_m));
                wanted.push(parents.filter_map(|id| id.children()).flatten().collect());
                if wanted.iter().map(BTreeSet::len).sum::<usize>() > MOST_PATCHES {
                    return Err(PlanError::TooMany);
                }
            }
            for level in (levels + 1..=region.to_level).rev() {
                balance(&mut wanted, usize::from(level));
            }
        }
        let mut patches: Vec<PatchId> = wanted.into_iter().flatten().collect();
        patches.sort_by_key(|id| (id.level, id.face, id.y, id.x));
        Ok(BakePlan { patches, region })
    }
}

/// Patches of levels 0 to `levels` of a whole planet.
pub fn whole_planet(levels: u8) -> u64 {
    (0..=levels.min(MAX_LEVEL)).map(|level| 6 << (2 * level)).sum()
}

fn check_region(region: &Region, levels: u8) -> Result<(), PlanError> {
    if region.to_level <= levels {
        return Err(PlanError::RegionNotFiner { found: region.to_level, levels });
    }
    let unit = (region.direction.length() - 1.0).abs() < 1e-6;
    if unit && region.radius_m >= 0.0 && region.radius_m.is_finite() {
        Ok(())
    } else {
        Err(PlanError::NoRegion { found: region.radius_m, direction: region.direction })
    }
}

/// Whether the children of a patch belong to a region: its nearest point, about, lies within the region's radius and funnel.
fn in_funnel(id: PatchId, region: &Region, radius_m: f64) -> bool {
    let centre = id.centre();
    let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(a, b)| crate::globe::sphere::direction(id.point(a, b, 1)));
    let half_diagonal = corners.iter().map(|c| c.angle_between(centre)).fold(0.0, f64::max);
    let size = std::f64::consts::FRAC_PI_2 / f64::from(1u32 << id.level);
    let nearest = region.direction.angle_between(centre) - half_diagonal;
    nearest * radius_m <= region.radius_m + FUNNEL * size * radius_m
}

/// Adds to the level above what the patches of `level` need: their parents' four neighbours, always with all siblings.
fn balance(wanted: &mut [BTreeSet<PatchId>], level: usize) {
    let parents: BTreeSet<PatchId> = wanted[level].iter().filter_map(|id| id.parent()).collect();
    for parent in parents {
        for needed in Side::ALL.map(|side| parent.neighbour(side)).into_iter().chain([parent]) {
            match needed.parent().and_then(PatchId::children) {
                Some(siblings) => wanted[level - 1].extend(siblings),
                None => wanted[level - 1].extend([needed]),
            }
        }
    }
}
