//! Cluster levels of detail (Karis 2021), built by meshoptimizer's own `clusterlod`, one hierarchy a patch.
//!
//! Clusters of at most so many triangles are grouped; each group is simplified to half with its border to other groups locked and
//! split into clusters again. In a view a cluster is drawn iff its own simplification is within the knob and that of the group it
//! belongs to is not. Errors are those that the simplifier reports, which are no bounds (the knob makes up for it), or the
//! true ones, measured at all samples, made monotone from fine to coarse.
//!
//! In their favour: patches need not match along their borders, which are simplified freely but for the corners.

use super::setting::{pixels, CutRule, PatchCache, Plane, Setting};
use super::sheet::Sheet;
use super::Method;
use glam::{DVec3, IVec3, Vec3};
use meshopt::{clod_build, clod_default_config, ClodBounds, ClodConfig, ClodMesh, SimplifyVertex, VertexDataAdapter};
use std::sync::Arc;
use terrane_heightfield::decimate::mesh::grid_triangles;
use terrane_planet::draw::view::Camera;
use terrane_planet::globe::patch::PatchId;
use terrane_planet::mesh::certificate::DEVIATION_SHARE;
use terrane_planet::store::StoreError;

/// Where the errors of simplified groups come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Errors {
    /// The simplifier.
    Reported,
    /// All samples under the triangles.
    Measured,
}

/// Some triangles that are drawn together.
struct Cluster {
    /// Group that it is simplified away with.
    group: u32,
    /// Group that it came from; `None` for original triangles.
    refined: Option<u32>,
    triangles: Vec<[u32; 3]>,
}

/// Several clusters that are simplified together; lengths in lattice units. Infinite errors: not simplified any more.
#[derive(Clone, Copy, Debug)]
struct Group {
    centre: DVec3,
    radius: f64,
    reported: f64,
    measured: f64,
}

/// The clusters of a patch.
pub(crate) struct Hierarchy {
    clusters: Vec<Cluster>,
    groups: Vec<Group>,
}

/// Clusters over the patches of a cut.
pub(crate) struct Clusters {
    most_triangles: usize,
    errors: Errors,
    rule: CutRule,
    /// Tolerance of the cut over the knob.
    cut: f64,
    patches: Arc<PatchCache<Hierarchy>>,
}

/// meshoptimizer's own settings, without its fallback to clustering vertices, which breaks meshes up.
fn config(most_triangles: usize) -> ClodConfig {
    let mut config = clod_default_config(most_triangles);
    config.simplify_fallback_sloppy = false;
    config.optimize_clusters = false;
    config
}

impl Hierarchy {
    fn new(id: PatchId, cells: u32, positions: &[IVec3], most_triangles: usize) -> Hierarchy {
        let origin = positions[0].as_dvec3();
        let relative: Vec<[f32; 3]> = positions.iter().map(|p| (p.as_dvec3() - origin).as_vec3().to_array()).collect();
        let indices = grid_triangles(cells);
        let mut locks = vec![SimplifyVertex::None; relative.len()];
        let row = cells as usize + 1;
        for corner in [0, row - 1, row * (row - 1), row * row - 1] {
            locks[corner] = SimplifyVertex::Lock;
        }
        let mut hierarchy = Hierarchy { clusters: Vec::new(), groups: Vec::new() };
        let Ok(vertices) = VertexDataAdapter::new(bytemuck::cast_slice(&relative), size_of::<[f32; 3]>(), 0) else {
            return hierarchy;
        };
        let mesh = ClodMesh { vertex_lock: Some(&locks), ..ClodMesh::new(indices.as_flattened(), &vertices) };
        clod_build(config(most_triangles), &mesh, |group, clusters| {
            let number = hierarchy.groups.len() as u32;
            hierarchy.groups.push(Group::new(&group.simplified, origin));
            hierarchy.clusters.extend(clusters.iter().map(|cluster| Cluster {
                group: number,
                refined: u32::try_from(cluster.refined).ok(),
                triangles: cluster.indices.as_chunks::<3>().0.to_vec(),
            }));
            number as i32
        });
        hierarchy.measure(&Plane::new(id, cells, positions));
        hierarchy
    }

    /// Errors of groups: of the triangles they became, and at least those of the groups that their clusters came from. Clusters
    /// come before those that they are simplified to.
    fn measure(&mut self, plane: &Plane) {
        for Cluster { refined, triangles, .. } in &self.clusters {
            if let Some(finer) = refined {
                let error = triangles.iter().map(|&t| plane.deviation(t)).fold(0.0, f64::max);
                let group = &mut self.groups[*finer as usize];
                group.measured = group.measured.max(error);
            }
        }
        for Cluster { group, refined, .. } in &self.clusters {
            if let Some(finer) = refined {
                let error = self.groups[*finer as usize].measured;
                let group = &mut self.groups[*group as usize];
                group.measured = group.measured.max(error);
            }
        }
    }

    /// Triangles of the clusters that are drawn, `is_coarse` saying which groups are not good enough once simplified.
    fn triangles(&self, is_coarse: impl Fn(&Group) -> bool) -> Vec<[u32; 3]> {
        let coarse: Vec<bool> = self.groups.iter().map(is_coarse).collect();
        let drawn = |c: &&Cluster| coarse[c.group as usize] && c.refined.is_none_or(|finer| !coarse[finer as usize]);
        self.clusters.iter().filter(drawn).flat_map(|c| c.triangles.iter().copied()).collect()
    }
}

impl Group {
    fn new(bounds: &ClodBounds, origin: DVec3) -> Group {
        let last = bounds.error == f32::MAX;
        Group {
            centre: origin + Vec3::from_array(bounds.center).as_dvec3(),
            radius: f64::from(bounds.radius),
            reported: if last { f64::INFINITY } else { f64::from(bounds.error) },
            measured: if last { f64::INFINITY } else { 0.0 },
        }
    }
}

impl Clusters {
    /// Clusters of at most `most_triangles` over the patches that a rule asks for with a multiple of the knob as tolerance.
    pub(crate) fn family(most_triangles: usize, variants: &[(Errors, CutRule, f64)]) -> Vec<Clusters> {
        let patches = Arc::new(PatchCache::new());
        let of = |&(errors, rule, cut)| Clusters { most_triangles, errors, rule, cut, patches: patches.clone() };
        variants.iter().map(of).collect()
    }
}

impl Method for Clusters {
    fn family(&self) -> &'static str {
        "clusters"
    }

    fn variant(&self) -> String {
        let errors = match self.errors {
            Errors::Reported => "reported",
            Errors::Measured => "measured",
        };
        format!("{} triangles, {errors} errors, {}", self.most_triangles, self.rule.describe(self.cut))
    }

    fn draw(&self, setting: &Setting, camera: &Camera, knob: f64, sheet: &mut Sheet) -> Result<(), StoreError> {
        let view = setting.view(camera, self.cut * knob);
        let most = (1.0 - DEVIATION_SHARE) * knob;
        for leaf in setting.visible_leaves(&view, self.rule) {
            let positions = setting.positions(leaf.id)?;
            let make = || Ok(Hierarchy::new(leaf.id, setting.tree.cells, &positions, self.most_triangles));
            let hierarchy = self.patches.get(leaf.id, make)?;
            let triangles = hierarchy.triangles(|group| {
                let error = if self.errors == Errors::Reported { group.reported } else { group.measured };
                // Groups in view of which nothing is left to see count like others.
                pixels(error, view.eye.distance(group.centre) - group.radius, camera) > most
            });
            sheet.add(leaf.id.face, positions.len(), |v| positions[v as usize].as_dvec3(), &triangles);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{doubled_area, open_edges_inside, small_setting};
    use super::*;

    const CELLS: u32 = 32;

    fn hierarchy() -> Hierarchy {
        let setting = small_setting(CELLS, 0);
        let id = PatchId::roots().next().unwrap();
        Hierarchy::new(id, CELLS, &setting.positions(id).unwrap(), 32)
    }

    #[test]
    fn every_cut_covers_its_patch_once() {
        let hierarchy = hierarchy();
        let mut fewest = usize::MAX;
        for tolerance in [-1.0, 1e2, 1e3, 1e4, 1e5, 1e9] {
            for error in [|group: &Group| group.measured, |group: &Group| group.reported] {
                let triangles = hierarchy.triangles(|group| error(group) > tolerance);
                assert_eq!(open_edges_inside(CELLS, &triangles), 0, "{tolerance}");
                assert_eq!(doubled_area(CELLS, &triangles), 2 * 32 * 32, "{tolerance}");
                assert!(tolerance >= 0.0 || triangles.len() == 2 * 32 * 32);
                fewest = fewest.min(triangles.len());
            }
        }
        assert!(fewest < 200, "{fewest} triangles in the coarsest cut");
    }

    #[test]
    fn clusters_without_regard_to_their_groups_overlap() {
        let mut hierarchy = hierarchy();
        hierarchy.clusters.iter_mut().for_each(|cluster| cluster.refined = None);
        let triangles = hierarchy.triangles(|group| group.measured > 1e3);
        assert_ne!(doubled_area(CELLS, &triangles), 2 * 32 * 32);
    }

    #[test]
    fn measured_errors_grow_from_fine_to_coarse() {
        let hierarchy = hierarchy();
        let groups = &hierarchy.groups;
        let mut simplified = 0;
        for cluster in &hierarchy.clusters {
            if let Some(finer) = cluster.refined {
                assert!(groups[finer as usize].measured <= groups[cluster.group as usize].measured);
                simplified += usize::from(groups[finer as usize].measured > 0.0);
            }
        }
        assert!(simplified > 10);
    }
}
