//! What a shader says about itself: bindings, push constants and workgroup size, so that none is written twice.

use ash::vk;

use super::shader::Shader;
use super::types::{decoration, Module, Type, Variable};
use crate::vulkan::error::{Result, VulkanError};

/// SPIR-V storage classes.
mod class {
    pub(super) const UNIFORM_CONSTANT: u32 = 0;
    pub(super) const UNIFORM: u32 = 2;
    pub(super) const PUSH_CONSTANT: u32 = 9;
    pub(super) const STORAGE_BUFFER: u32 = 12;
}

/// What a binding takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BindingKind {
    /// `buffer` block.
    Storage,
    /// `uniform` block.
    Uniform,
    /// `sampler2D` and the like.
    Sampled,
    /// `image2D` and the like.
    StorageImage,
}

impl BindingKind {
    pub(crate) fn descriptor_type(self) -> vk::DescriptorType {
        match self {
            Self::Storage => vk::DescriptorType::STORAGE_BUFFER,
            Self::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
            Self::Sampled => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Self::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
        }
    }
}

/// One binding of descriptor set 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Binding {
    /// The variable's name in the shader, or its block's name where the variable has none.
    pub name: String,
    /// Binding number.
    pub number: u32,
    /// What it takes.
    pub kind: BindingKind,
    /// Array length, 1 if it is no array.
    pub count: u32,
    /// The stages that declare it.
    pub stages: vk::ShaderStageFlags,
}

/// What one shader declares.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reflection {
    /// The shader's stage.
    pub stage: vk::ShaderStageFlags,
    /// Bindings of set 0, by number.
    pub bindings: Vec<Binding>,
    /// Size of the push constants in bytes, 0 for none.
    pub push_constant_bytes: u32,
    /// Invocations of a workgroup in x, y and z; zeros if the stage has none.
    pub workgroup_size: [u32; 3],
}

impl Reflection {
    /// Reads the declarations of a shader, with specialization constants as given (id, value).
    ///
    /// # Errors
    /// Damaged SPIR-V, another stage than vertex, fragment and compute, an entry point other than `main`, a descriptor
    /// set other than 0, separate samplers, or arrays of unknown length.
    pub fn new(shader: &Shader<'_>, specialization: &[(u32, u32)]) -> Result<Self> {
        let fail = |problem| VulkanError::Shader { shader: shader.name.to_owned(), problem };
        let mut module = Module::parse(shader.words).map_err(fail)?;
        specialize(&mut module, specialization);
        let stage = stage(&module).map_err(fail)?;
        let mut bindings = Vec::new();
        let mut push_constant_bytes = 0;
        for variable in &module.variables {
            if variable.class == class::PUSH_CONSTANT {
                push_constant_bytes = module.size(pointee(&module, variable));
            } else if let Some(binding) = binding(&module, variable, stage).map_err(fail)? {
                bindings.push(binding);
            }
        }
        bindings.sort_by_key(|binding| binding.number);
        let workgroup_size = workgroup_size(&module);
        Ok(Self { stage, bindings, push_constant_bytes, workgroup_size })
    }
}

fn specialize(module: &mut Module, specialization: &[(u32, u32)]) {
    let ids: Vec<u32> = module.constants.keys().copied().collect();
    for id in ids {
        let Some(spec) = module.decoration(id, decoration::SPEC_ID) else {
            continue;
        };
        if let Some((_, value)) = specialization.iter().find(|(wanted, _)| *wanted == spec) {
            module.constants.insert(id, *value);
        }
    }
}

fn stage(module: &Module) -> std::result::Result<vk::ShaderStageFlags, String> {
    let Some((model, name)) = &module.entry else {
        return Err("no entry point".to_owned());
    };
    if name != "main" {
        return Err(format!("the entry point is `{name}`, expected `main`"));
    }
    match model {
        0 => Ok(vk::ShaderStageFlags::VERTEX),
        4 => Ok(vk::ShaderStageFlags::FRAGMENT),
        5 => Ok(vk::ShaderStageFlags::COMPUTE),
        other => Err(format!("execution model {other} is not supported")),
    }
}

/// The value of the built-in `WorkgroupSize` goes before the execution modes.
fn workgroup_size(module: &Module) -> [u32; 3] {
    /// Number of the built-in in SPIR-V.
    const WORKGROUP_SIZE: u32 = 25;
    let value = |id: &u32| module.constants.get(id).copied().unwrap_or(0);
    let built_in = module.composites.iter().find(|(id, _)| module.decoration(**id, decoration::BUILT_IN) == Some(WORKGROUP_SIZE));
    match (built_in, module.local_size_id) {
        (Some((_, parts)), _) if parts.len() == 3 => std::array::from_fn(|i| value(&parts[i])),
        (_, Some(ids)) => ids.map(|id| value(&id)),
        _ => module.local_size.unwrap_or_default(),
    }
}

fn pointee(module: &Module, variable: &Variable) -> u32 {
    match module.types.get(&variable.type_id) {
        Some(Type::Pointer(of)) => *of,
        _ => 0,
    }
}

/// The binding that a variable declares; none for inputs, outputs and the like.
fn binding(module: &Module, variable: &Variable, stages: vk::ShaderStageFlags) -> std::result::Result<Option<Binding>, String> {
    let resource = [class::UNIFORM_CONSTANT, class::UNIFORM, class::STORAGE_BUFFER];
    if !resource.contains(&variable.class) {
        return Ok(None);
    }
    let (type_id, count) = element(module, pointee(module, variable));
    let name = name(module, variable.id, type_id);
    let number = module.decoration(variable.id, decoration::BINDING);
    let Some(number) = number else {
        return Err(format!("`{name}` has no binding number"));
    };
    let set = module.decoration(variable.id, decoration::DESCRIPTOR_SET).unwrap_or(0);
    if set != 0 {
        return Err(format!("`{name}` is in descriptor set {set}; there is set 0 only"));
    }
    if count == 0 {
        return Err(format!("`{name}` is an array of unknown length"));
    }
    let buffer_block = module.decoration(type_id, decoration::BUFFER_BLOCK).is_some();
    let block = module.decoration(type_id, decoration::BLOCK).is_some();
    let kind = match (variable.class, module.types.get(&type_id)) {
        (class::STORAGE_BUFFER, _) => BindingKind::Storage,
        (class::UNIFORM, _) if buffer_block => BindingKind::Storage,
        (class::UNIFORM, _) if block => BindingKind::Uniform,
        (_, Some(Type::SampledImage)) => BindingKind::Sampled,
        (_, Some(Type::Image(true))) => BindingKind::StorageImage,
        (_, Some(Type::Image(false) | Type::Sampler)) => {
            return Err(format!("`{name}`: images and samplers must be combined"));
        }
        _ => return Err(format!("`{name}` is of a kind that is not supported")),
    };
    Ok(Some(Binding { name, number, kind, count, stages }))
}

/// The element type and length of an array; the type itself and 1 for others; length 0 if it is not known.
fn element(module: &Module, type_id: u32) -> (u32, u32) {
    match module.types.get(&type_id) {
        Some(Type::Array(of, length)) => (*of, module.constants.get(length).copied().unwrap_or(0)),
        Some(Type::RuntimeArray) => (type_id, 0),
        _ => (type_id, 1),
    }
}

fn name(module: &Module, variable: u32, type_id: u32) -> String {
    let named = |id| module.names.get(&id).filter(|name| !name.is_empty()).cloned();
    named(variable).or_else(|| named(type_id)).unwrap_or_default()
}
