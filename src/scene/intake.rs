//! What workers found is taken in: meshes and textures are staged for upload, and room is made for them.
//!
//! In: responses. Out: an upload, and patches of the ground that is drawn or of the one that is to be drawn next.

use super::loader::{Loaded, LoadedMesh, Response};
use super::resident::{ResidentMesh, ResidentPatch};
use super::{Scene, SceneError};
use crate::vulkan::Upload;
use std::collections::HashMap;
use std::time::Duration;
use terrane_planet::globe::patch::PatchId;

/// Bytes staged at a time.
const UPLOAD_CHUNK: u64 = 8 << 20;

impl Scene {
    /// Begins a frame: another ground takes the place of that before if it is ready, and what has arrived is staged.
    pub(super) fn stage_arrived(&mut self, uploads: usize) -> Result<Upload, SceneError> {
        self.frame += 1;
        self.finish_renewal();
        self.take_edit(Duration::ZERO);
        self.take_clouds(Duration::ZERO)?;
        let arrived = self.unless_behind(self.loader.take(uploads))?;
        self.stage(arrived)
    }

    pub(super) fn upload(&mut self, arrived: Vec<Response>) -> Result<(), SceneError> {
        Ok(self.stage(arrived)?.finish()?)
    }

    fn stage(&mut self, arrived: Vec<Response>) -> Result<Upload, SceneError> {
        let _span = tracing::trace_span!("stage", patches = arrived.len()).entered();
        let mut upload = Upload::new(&self.context, UPLOAD_CHUNK);
        for response in arrived {
            match response {
                Response::Patch(loaded) => self.stage_patch(*loaded, &mut upload)?,
                Response::Horizon(id, relief) => {
                    let Some(patch) = self.resident.get_mut(&id) else { continue };
                    let Some(slot) = patch.slot else { continue };
                    patch.sun = relief.sun;
                    self.textures.upload_relief(&mut upload, slot, &relief)?;
                }
            }
        }
        Ok(upload)
    }

    /// Those of the ground that a patch as it arrives belongs to.
    fn patches_beside(&mut self, id: PatchId) -> &mut HashMap<PatchId, ResidentPatch> {
        match &mut self.renewal {
            Some(renewal) if renewal.touches(id) => &mut renewal.fresh,
            _ => &mut self.resident,
        }
    }

    fn stage_patch(&mut self, loaded: Loaded, upload: &mut Upload) -> Result<(), SceneError> {
        let Loaded { id, facts, mesh, texture, mut grid } = loaded;
        let is_next = self.renewal.as_ref().is_some_and(|renewal| renewal.touches(id));
        if let Some(facts) = facts {
            let next = self.renewal.as_mut().map(|renewal| &mut renewal.tree);
            let now = Some(&mut self.tree).filter(|_| !is_next);
            next.into_iter().chain(now).for_each(|tree| tree.insert(id, &facts));
        }
        if let Some(renewal) = self.renewal.as_mut().filter(|_| is_next) {
            renewal.grids.extend(grid.take().map(|grid| (id, grid)));
        }
        let patch = self.patches_beside(id).get(&id);
        let there = patch.and_then(|patch| patch.mesh.as_ref());
        let mesh = mesh.filter(|mesh| there.is_none_or(|there| mesh.improves(there)));
        let texture = texture.filter(|_| patch.is_none_or(|patch| patch.slot.is_none()));
        if mesh.is_none() && texture.is_none() {
            return Ok(());
        }
        if !self.make_room(id, mesh.as_ref()) {
            self.turn_away(id);
            return Ok(());
        }
        let slot = if texture.is_some() { self.claim_slot(upload)? } else { None };
        if texture.is_some() && slot.is_none() {
            self.turn_away(id);
            return Ok(());
        }
        let mut patch = self.patches_beside(id).remove(&id).unwrap_or_default();
        patch.last_used = self.frame;
        if let (Some(slot), Some(texture)) = (slot, texture) {
            self.textures.upload(upload, slot, &texture.mips)?;
            self.textures.upload_relief(upload, slot, &texture.relief)?;
            (patch.slot, patch.sun) = (Some(slot), texture.relief.sun);
        }
        if let Some(mesh) = mesh {
            self.mesh_bytes -= patch.mesh.take().map_or(0, |coarser| coarser.buffer().bytes());
            let resident = ResidentMesh::new(&self.context, upload, &mesh.patch, mesh.finest)?;
            self.mesh_bytes += resident.buffer().bytes();
            patch.mesh = Some(resident);
            if let Some(grid) = grid {
                self.ground.known.insert(grid);
            }
        }
        self.patches_beside(id).insert(id, patch);
        Ok(())
    }

    /// Notes that there was no room for a patch.
    fn turn_away(&mut self, id: PatchId) {
        match &mut self.renewal {
            // Drawn coarser, it gives up the room of what it replaces. Its whole faces it cannot do without.
            Some(renewal) if renewal.touches(id) && id.level > 0 => renewal.is_full = true,
            _ => self.full = true,
        }
    }

    /// Whether there is room for a patch and its mesh, once others have gone that the latest frame did not use.
    fn make_room(&mut self, id: PatchId, mesh: Option<&LoadedMesh>) -> bool {
        let bytes = mesh.map_or(0, |mesh| ResidentMesh::bytes_of(&mesh.patch, mesh.finest));
        let lacks = |scene: &Scene| {
            let fresh = scene.renewal.as_ref().filter(|renewal| renewal.touches(id)).map(|renewal| &renewal.fresh);
            let is_new = !fresh.unwrap_or(&scene.resident).contains_key(&id);
            (is_new && scene.resident_count() >= scene.capacity) || scene.mesh_bytes + bytes > scene.most_mesh_bytes
        };
        while id.level > 0 && lacks(self) {
            if !self.evict() {
                return false;
            }
        }
        true
    }

    /// A slot for textures: a free one, or else that of an evicted patch.
    fn claim_slot(&mut self, upload: &mut Upload) -> Result<Option<u32>, SceneError> {
        loop {
            let slot = self.textures.claim(upload)?;
            if slot.is_some() || !self.evict() {
                return Ok(slot);
            }
        }
    }

    /// Frees the least recently used patch that the latest frame did not use.
    fn evict(&mut self) -> bool {
        let idle = self.resident.iter().filter(|(id, p)| id.level > 0 && p.last_used + 1 < self.frame);
        let Some(oldest) = idle.min_by_key(|(id, p)| (p.last_used, **id)).map(|(id, _)| *id) else { return false };
        self.remove(oldest);
        true
    }

    /// Takes a patch of the ground that is drawn from the GPU.
    pub(super) fn remove(&mut self, id: PatchId) {
        self.ground.known.remove(id);
        let patch = self.resident.remove(&id).unwrap_or_default();
        self.mesh_bytes -= patch.mesh.map_or(0, |mesh| mesh.buffer().bytes());
        if let Some(slot) = patch.slot {
            self.textures.release(slot);
        }
    }
}
