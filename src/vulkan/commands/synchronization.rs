//! Who touches a resource, as a table: each access with its stages, its memory access and the layout it needs.

use ash::vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};

/// An access to a buffer or image, before or after a barrier.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Access {
    /// Read by a copy.
    TransferRead,
    /// Written by a copy or fill.
    TransferWrite,
    /// Read by the host, after waiting.
    HostRead,
    /// Read as a storage or uniform buffer, or by address, in a compute shader.
    ComputeRead,
    /// Written (and read) by a compute shader; for images, as a storage image.
    ComputeWrite,
    /// Read as indirect arguments.
    IndirectRead,
    /// Read as indices.
    IndexRead,
    /// Read as a buffer in a vertex or fragment shader.
    GraphicsRead,
    /// Sampled in a vertex, fragment or compute shader.
    Sampled,
    /// Written (and read, to blend) as a colour target.
    ColorTarget,
    /// Written and tested as a depth target.
    DepthTarget,
    /// Presented to a window.
    Present,
}

impl Access {
    /// Stages, accesses and image layout.
    pub(crate) fn parts(self) -> (S, A, L) {
        let graphics = S::VERTEX_SHADER | S::FRAGMENT_SHADER;
        let depth = S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS;
        let storage_write = A::SHADER_STORAGE_WRITE | A::SHADER_STORAGE_READ;
        // The blanket read: it covers uniform, storage and address reads.
        let read = A::SHADER_READ;
        match self {
            Self::TransferRead => (S::ALL_TRANSFER, A::TRANSFER_READ, L::TRANSFER_SRC_OPTIMAL),
            Self::TransferWrite => (S::ALL_TRANSFER, A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL),
            Self::HostRead => (S::HOST, A::HOST_READ, L::GENERAL),
            Self::ComputeRead => (S::COMPUTE_SHADER, read | A::UNIFORM_READ, L::GENERAL),
            Self::ComputeWrite => (S::COMPUTE_SHADER, storage_write, L::GENERAL),
            Self::IndirectRead => (S::DRAW_INDIRECT, A::INDIRECT_COMMAND_READ, L::UNDEFINED),
            Self::IndexRead => (S::INDEX_INPUT, A::INDEX_READ, L::UNDEFINED),
            Self::GraphicsRead => (graphics, read | A::UNIFORM_READ, L::GENERAL),
            Self::Sampled => (graphics | S::COMPUTE_SHADER, A::SHADER_SAMPLED_READ, L::SHADER_READ_ONLY_OPTIMAL),
            Self::ColorTarget => {
                (S::COLOR_ATTACHMENT_OUTPUT, A::COLOR_ATTACHMENT_READ | A::COLOR_ATTACHMENT_WRITE, L::COLOR_ATTACHMENT_OPTIMAL)
            }
            Self::DepthTarget => {
                (depth, A::DEPTH_STENCIL_ATTACHMENT_READ | A::DEPTH_STENCIL_ATTACHMENT_WRITE, L::DEPTH_ATTACHMENT_OPTIMAL)
            }
            // The semaphore that presentation waits for makes the writes visible.
            Self::Present => (S::NONE, A::NONE, L::PRESENT_SRC_KHR),
        }
    }

    /// Whether it writes, and so has to wait for readers and writers before it.
    pub(crate) fn writes(self) -> bool {
        matches!(self, Self::TransferWrite | Self::ComputeWrite | Self::ColorTarget | Self::DepthTarget)
    }
}

/// The union of the stages and accesses of several accesses.
pub(crate) fn union(accesses: &[Access]) -> (S, A) {
    accesses.iter().fold((S::NONE, A::NONE), |(stages, memory), access| {
        let (s, a, _) = access.parts();
        (stages | s, memory | a)
    })
}
