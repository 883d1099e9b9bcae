//! What can go wrong between us and Vulkan, each with what was found and what to do next.

use ash::vk;

/// The result of every call of this layer.
pub type Result<T> = std::result::Result<T, VulkanError>;

/// An error of the Vulkan layer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VulkanError {
    /// The Vulkan loader library is not installed.
    #[error("the Vulkan loader was not found ({reason}); install it (Debian/Ubuntu: apt install libvulkan1)")]
    NoLoader {
        /// What the dynamic linker said.
        reason: String,
    },
    /// The loader found no driver at all.
    #[error(
        "no Vulkan driver was found; install one for your GPU, or the software renderer \
         (Debian/Ubuntu: apt install mesa-vulkan-drivers), and check VK_DRIVER_FILES if it is set"
    )]
    NoDriver,
    /// There are devices, but none meets the requirements.
    #[error("no usable GPU; Terrane needs Vulkan 1.3 with these features:\n{}", .reasons.join("\n"))]
    NoUsableDevice {
        /// One line per device: its name and what it lacks.
        reasons: Vec<String>,
    },
    /// The GPU that was asked for does not exist or is not usable.
    #[error("no usable GPU matches `{wanted}`; ask for the number, the UUID or part of the name of one of these:\n{}", .available.join("\n"))]
    NoSuchGpu {
        /// The index, part of a name or beginning of a UUID that was asked for.
        wanted: String,
        /// One line per device.
        available: Vec<String>,
    },
    /// What was asked for fits several GPUs.
    #[error("`{wanted}` fits several GPUs; ask for the number or UUID of one of these:\n{}", .fitting.join("\n"))]
    SeveralGpus {
        /// The part of a name or the beginning of a UUID that was asked for.
        wanted: String,
        /// One line for each device that fits.
        fitting: Vec<String>,
    },
    /// Compute pipelines of the GPU cannot have subgroups of the size that was asked for.
    #[error(
        "{gpu}: subgroups of {wanted} were asked for, it has powers of two from {least} to {most}; `terrane gpus` lists them"
    )]
    SubgroupSize {
        /// The GPU.
        gpu: String,
        /// What was asked for.
        wanted: u32,
        /// The least that it has.
        least: u32,
        /// The most.
        most: u32,
    },
    /// Validation was asked for but its layer is not installed.
    #[error(
        "the validation layer VK_LAYER_KHRONOS_validation was not found; install it \
         (Debian/Ubuntu: apt install vulkan-validationlayers) or run without validation"
    )]
    MissingValidation,
    /// A Vulkan instance extension that the window needs is missing.
    #[error("the Vulkan driver lacks {extension}, which a window needs")]
    MissingExtension {
        /// Name of the extension.
        extension: String,
    },
    /// No memory for a resource.
    #[error("out of memory for {what} ({bytes} bytes)")]
    OutOfMemory {
        /// Name of the resource.
        what: String,
        /// Its size in bytes.
        bytes: u64,
    },
    /// The device was lost; nothing of it can be used any more.
    #[error("the GPU was lost; the last zone begun was `{zone}`")]
    DeviceLost {
        /// The last zone begun in the commands that were waited for.
        zone: String,
    },
    /// The GPU did not finish in time.
    #[error("the GPU did not finish `{what}` within {seconds} s; the last zone begun was `{zone}`")]
    Timeout {
        /// Name of the commands.
        what: String,
        /// The limit, in seconds.
        seconds: u64,
        /// The last zone begun.
        zone: String,
    },
    /// A shader cannot be used as asked.
    #[error("shader {shader}: {problem}")]
    Shader {
        /// Name of the shader.
        shader: String,
        /// What is wrong.
        problem: String,
    },
    /// Resources do not match the bindings of a pipeline.
    #[error("pipeline {pipeline}, binding `{binding}`: {problem}")]
    Binding {
        /// Name of the pipeline.
        pipeline: String,
        /// Name of the binding.
        binding: String,
        /// What is wrong.
        problem: String,
    },
    /// An access past the end of a resource, or to memory that the host cannot see.
    #[error("{what}: {problem}")]
    Access {
        /// Name of the resource.
        what: String,
        /// What is wrong.
        problem: String,
    },
    /// Commands were used in the wrong order, such as recording before `begin`.
    #[error("commands `{commands}`: {problem}")]
    Commands {
        /// Name of the commands.
        commands: String,
        /// What is wrong.
        problem: String,
    },
    /// Any other error of the Vulkan API.
    #[error("{call} failed: {result}")]
    Api {
        /// The call that failed.
        call: &'static str,
        /// What it returned.
        result: vk::Result,
    },
}

/// Turns the error of an API call into ours, for use with `map_err`.
pub(crate) fn api(call: &'static str) -> impl FnOnce(vk::Result) -> VulkanError {
    move |result| match result {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => VulkanError::NoDriver,
        vk::Result::ERROR_DEVICE_LOST => VulkanError::DeviceLost { zone: format!("none ({call})") },
        vk::Result::ERROR_OUT_OF_HOST_MEMORY | vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => {
            VulkanError::OutOfMemory { what: call.to_owned(), bytes: 0 }
        }
        result => VulkanError::Api { call, result },
    }
}
