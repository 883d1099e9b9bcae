//! What verification found, in one view and in all.

use std::ops::AddAssign;

macro_rules! counts {
    ($($(#[$meta:meta])* $name:ident { $($(#[$member_meta:meta])* $member:ident,)* })*) => {$(
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct $name {
            $($(#[$member_meta])* pub $member: usize,)*
        }

        impl AddAssign for $name {
            fn add_assign(&mut self, other: Self) {
                $(self.$member += other.$member;)*
            }
        }

        impl $name {
            /// All of them together.
            pub fn total(&self) -> usize {
                0 $(+ self.$member)*
            }
        }
    )*};
}

counts! {
    /// Differences between the GPU's stages and their CPU twins.
    Mismatches {
        /// Patches missing from the frame's tables, or with other vertices, triangles or sides there.
        patches,
        /// Awake bits.
        awake,
        /// Drawn positions and morph weights of vertices.
        drawn_positions,
        /// Resolved vertices.
        resolved,
        /// Triangles emitted without culling that only one side has.
        triangles,
        /// Triangles emitted with culling that only one side has.
        culled_triangles,
        /// Counters of emission that are not what was read back.
        counters,
    }

    /// Faults that watertightness does not depend on, but the certificate does.
    MeshFaults {
        /// Triangles turned to the inside of the planet.
        flipped,
        /// Triangles without area.
        degenerate,
        /// Pairs of an awake vertex and a sleeping member of its ring.
        closure_violations,
    }
}

/// What one view showed, or several together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewReport {
    /// Patches drawn.
    pub patches: usize,
    /// Triangles emitted without culling.
    pub triangles: usize,
    /// Triangles emitted with culling.
    pub triangles_after_culling: usize,
    /// Awake vertices of all patches.
    pub awake_vertices: usize,
    /// Directed edges that nothing cancels.
    pub cracks: usize,
    /// Faults away from the rim of the data.
    pub faults: MeshFaults,
    /// Faults of patches at the rim of the data, where closure is not promised.
    pub faults_at_data_rim: MeshFaults,
    /// Drawn patches whose hierarchy does not replay.
    pub broken_hierarchies: usize,
    /// Triangles that did not fit the index buffer.
    pub dropped: usize,
    /// Differences between GPU and CPU.
    pub mismatches: Mismatches,
}

impl AddAssign<&ViewReport> for ViewReport {
    fn add_assign(&mut self, other: &ViewReport) {
        self.patches += other.patches;
        self.triangles += other.triangles;
        self.triangles_after_culling += other.triangles_after_culling;
        self.awake_vertices += other.awake_vertices;
        self.cracks += other.cracks;
        self.faults += other.faults;
        self.faults_at_data_rim += other.faults_at_data_rim;
        self.broken_hierarchies += other.broken_hierarchies;
        self.dropped += other.dropped;
        self.mismatches += other.mismatches;
    }
}

impl ViewReport {
    /// What breaks a promise, in words; nothing if all is well.
    pub fn broken_promises(&self) -> Vec<String> {
        let promises = [
            (self.cracks, "cracks in the surface"),
            (self.mismatches.total(), "differences between GPU and CPU"),
            (self.dropped, "triangles that did not fit the index buffer"),
            (self.broken_hierarchies, "patches whose hierarchy does not replay"),
            (self.faults.flipped, "flipped triangles"),
            (self.faults.degenerate, "triangles without area"),
            (self.faults.closure_violations, "breaches of closure"),
        ];
        promises.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect()
    }
}

/// What all views showed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VerifyReport {
    /// Views checked.
    pub views: usize,
    /// What they showed together.
    pub sum: ViewReport,
    /// Triangles emitted without culling in one view, at most.
    pub most_triangles: usize,
}

impl VerifyReport {
    /// Adds a view.
    pub fn add(&mut self, view: &ViewReport) {
        self.views += 1;
        self.sum += view;
        self.most_triangles = self.most_triangles.max(view.triangles);
    }
}
