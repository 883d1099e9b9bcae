//! Normals of the ground, from its heights.

use super::Ground;
use glam::DVec3;

/// A place whose normal is asked for.
#[derive(Clone, Copy, Debug)]
pub struct NormalSite {
    /// Unit direction.
    pub up: DVec3,
    /// Metres to the points on each side between which the ground is taken to be straight.
    pub spacing: f64,
}

impl Ground<'_> {
    /// Unit normals of the ground at places, in the planet's axes.
    pub fn normals(&self, sites: &[NormalSite]) -> Vec<DVec3> {
        let radius = self.lattice.radius * self.lattice.unit;
        let around = |site: &NormalSite| {
            let (first, second) = site.up.any_orthonormal_pair();
            let angle = site.spacing / radius;
            [first, -first, second, -second].map(|side| (site.up + side * angle).normalize())
        };
        let directions: Vec<DVec3> = sites.iter().flat_map(around).collect();
        let heights = self.metres(&directions);
        let points: Vec<DVec3> = directions.iter().zip(heights).map(|(&d, h)| d * (radius + h)).collect();
        let normal = |(site, p): (&NormalSite, &[DVec3])| {
            let n = (p[0] - p[1]).cross(p[2] - p[3]).normalize_or(site.up);
            // The pair of tangents may be left-handed.
            if n.dot(site.up) < 0.0 {
                -n
            } else {
                n
            }
        };
        sites.iter().zip(points.chunks(4)).map(normal).collect()
    }
}
