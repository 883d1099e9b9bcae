//! What commands last did with each buffer and image, so that a stage says only what it does next.
//!
//! In: uses of resources, in the order of recording. Out: the barriers between them. Data that is written by the GPU and read by its
//! address needs [`Commands::barrier`]: neither this nor validation sees such reads.

use std::collections::HashMap;

use ash::vk::{self, AccessFlags2 as A, Handle as _, ImageLayout as L, PipelineStageFlags2 as S};

use super::synchronization::Access;
use super::Commands;
use crate::vulkan::error::Result;
use crate::vulkan::resources::buffer::Buffer;
use crate::vulkan::resources::image::ImageView;

/// A buffer or image and what commands do with it next, for [`Commands::ready`].
#[derive(Clone, Copy)]
pub enum Use<'a> {
    /// A buffer.
    Buffer(&'a Buffer, Access),
    /// An image, with the contents that it has.
    Image(&'a ImageView, Access),
    /// An image whose contents are thrown away.
    Anew(&'a ImageView, Access),
}

impl Buffer {
    /// This buffer, about to be accessed like this.
    pub fn to(&self, next: Access) -> Use<'_> {
        Use::Buffer(self, next)
    }
}

impl ImageView {
    /// This view, about to be accessed like this, with the contents that it has.
    pub fn to(&self, next: Access) -> Use<'_> {
        Use::Image(self, next)
    }

    /// This view, about to be accessed like this for the first time: its contents are thrown away.
    pub fn anew(&self, next: Access) -> Use<'_> {
        Use::Anew(self, next)
    }
}

/// A resource, whatever handle reaches it. Views of the same layers and levels are one; views that overlap otherwise are not known to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Key {
    Buffer(u64),
    Image(u64, [u32; 4]),
}

impl Key {
    fn of_buffer(buffer: &Buffer) -> Self {
        Self::Buffer(buffer.raw.handle.as_raw())
    }

    fn of_view(view: &ImageView) -> Self {
        let vk::ImageSubresourceRange { base_mip_level, level_count, base_array_layer, layer_count, .. } = view.raw.range;
        Self::Image(view.raw.image.handle.as_raw(), [base_mip_level, level_count, base_array_layer, layer_count])
    }
}

/// What happened to a resource: the last write, what may read it since, and the layout it is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct State {
    write: (S, A),
    reads: (S, A),
    layout: L,
}

/// From and to: stages, accesses and layouts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Barrier {
    from: (S, A, L),
    to: (S, A, L),
}

impl State {
    /// Of a resource that these commands have not touched: whatever happened to it before them.
    const fn untouched(layout: L) -> Self {
        Self { write: (S::ALL_COMMANDS, A::MEMORY_WRITE), reads: (S::NONE, A::NONE), layout }
    }

    /// The barrier before the next access, if it takes one.
    fn advance(&mut self, next: Access) -> Option<Barrier> {
        let (stages, access, layout) = next.parts();
        let before = *self;
        let to = (stages, access, layout);
        if !next.writes() && layout == self.layout {
            self.reads = (before.reads.0 | stages, before.reads.1 | access);
            let seen = before.reads.0.contains(stages) && before.reads.1.contains(access);
            return (!seen).then_some(Barrier { from: (before.write.0, before.write.1, layout), to });
        }
        // A change of layout is a write, too, and done when the stages of `next` begin.
        let written = if next.writes() { access } else { A::NONE };
        let reads = if next.writes() { (S::NONE, A::NONE) } else { (stages, access) };
        *self = Self { write: (stages, written), reads, layout };
        Some(Barrier { from: (before.write.0 | before.reads.0, before.write.1, before.layout), to })
    }
}

/// The states of all resources that some commands have touched since they began.
#[derive(Default)]
pub(super) struct Accesses {
    states: HashMap<Key, State>,
}

impl Accesses {
    pub(super) fn clear(&mut self) {
        self.states.clear();
    }
}

impl Commands {
    /// Makes resources ready for what is done with them next, after all that these commands did with them before.
    ///
    /// # Errors
    /// An image that these commands have not touched, and whose contents are not thrown away: see [`found`](Self::found). Not
    /// recording, or rendering.
    pub fn ready(&mut self, uses: &[Use<'_>]) -> Result<()> {
        let (mut buffers, mut images) = (Vec::new(), Vec::new());
        for next in uses {
            match *next {
                Use::Buffer(buffer, next) => buffers.extend(self.advance_buffer(buffer, next)),
                Use::Image(view, next) => images.extend(self.advance_image(view, next)?),
                Use::Anew(view, next) => {
                    let state = self.accesses.states.entry(Key::of_view(view)).or_insert(State::untouched(L::UNDEFINED));
                    state.layout = L::UNDEFINED;
                    images.extend(self.advance_image(view, next)?);
                }
            }
        }
        if buffers.is_empty() && images.is_empty() {
            return Ok(());
        }
        let dependency = vk::DependencyInfo::default().buffer_memory_barriers(&buffers).image_memory_barriers(&images);
        self.pipeline_barrier(&dependency)
    }

    /// Says how earlier commands left an image whose contents are still wanted.
    pub fn found(&mut self, view: &ImageView, access: Access) {
        self.keep_raw(view.raw.clone());
        let (_, _, layout) = access.parts();
        self.accesses.states.insert(Key::of_view(view), State::untouched(layout));
    }

    fn advance_buffer(&mut self, buffer: &Buffer, next: Access) -> Option<vk::BufferMemoryBarrier2<'static>> {
        self.keep(buffer);
        // Buffers have no layout: that of `next` stands for all.
        let (_, _, layout) = next.parts();
        let state = self.accesses.states.entry(Key::of_buffer(buffer)).or_insert(State::untouched(layout));
        state.layout = layout;
        let Barrier { from, to } = state.advance(next)?;
        let barrier = vk::BufferMemoryBarrier2::default()
            .src_stage_mask(from.0)
            .src_access_mask(from.1)
            .dst_stage_mask(to.0)
            .dst_access_mask(to.1)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .buffer(buffer.raw.handle)
            .size(vk::WHOLE_SIZE);
        Some(barrier)
    }

    fn advance_image(&mut self, view: &ImageView, next: Access) -> Result<Option<vk::ImageMemoryBarrier2<'static>>> {
        self.keep_raw(view.raw.clone());
        let Some(state) = self.accesses.states.get_mut(&Key::of_view(view)) else {
            let name = &view.raw.image.name;
            return Err(self.misuse(&format!("image `{name}` is used as {next:?}, and nobody said how it was found")));
        };
        let barrier = state.advance(next).map(|Barrier { from, to }| {
            vk::ImageMemoryBarrier2::default()
                .src_stage_mask(from.0)
                .src_access_mask(from.1)
                .dst_stage_mask(to.0)
                .dst_access_mask(to.1)
                .old_layout(from.2)
                .new_layout(to.2)
                .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
                .image(view.raw.image.handle)
                .subresource_range(view.raw.range)
        });
        Ok(barrier)
    }
}

#[cfg(test)]
mod tests {
    use super::{Barrier, State, A, L, S};
    use crate::vulkan::Access;

    fn after(accesses: &[Access]) -> State {
        let mut state = State::untouched(L::UNDEFINED);
        for access in accesses {
            state.advance(*access);
        }
        state
    }

    #[test]
    fn what_was_written_is_waited_for_once_by_each_kind_of_reader() {
        let mut state = after(&[Access::ComputeWrite]);
        let first = state.advance(Access::ComputeRead).unwrap();
        assert!(first.from.1.contains(A::SHADER_STORAGE_WRITE) && first.to.0 == S::COMPUTE_SHADER);
        assert_eq!(state.advance(Access::ComputeRead), None);
        let other = state.advance(Access::GraphicsRead).unwrap();
        assert!(other.from.1.contains(A::SHADER_STORAGE_WRITE) && other.to.0.contains(S::FRAGMENT_SHADER));
        assert_eq!(state.advance(Access::ComputeRead), None);
    }

    #[test]
    fn a_write_waits_for_all_readers_since_the_last() {
        let mut state = after(&[Access::ComputeWrite, Access::ComputeRead, Access::GraphicsRead]);
        let Barrier { from, .. } = state.advance(Access::ComputeWrite).unwrap();
        assert!(from.0.contains(S::COMPUTE_SHADER | S::VERTEX_SHADER | S::FRAGMENT_SHADER));
        // And writes wait for each other.
        assert!(state.advance(Access::ComputeWrite).is_some());
    }

    #[test]
    fn a_change_of_layout_waits_like_a_write_and_later_readers_for_it() {
        let mut state = after(&[Access::DepthTarget]);
        let sampled = state.advance(Access::Sampled).unwrap();
        assert_eq!((sampled.from.2, sampled.to.2), (L::DEPTH_ATTACHMENT_OPTIMAL, L::SHADER_READ_ONLY_OPTIMAL));
        assert!(sampled.from.1.contains(A::DEPTH_STENCIL_ATTACHMENT_WRITE));
        assert_eq!(state.advance(Access::Sampled), None);
        let back = state.advance(Access::DepthTarget).unwrap();
        assert!(back.from.0.contains(S::FRAGMENT_SHADER) && back.from.2 == L::SHADER_READ_ONLY_OPTIMAL);
    }
}
