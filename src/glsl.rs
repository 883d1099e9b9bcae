//! GLSL to SPIR-V 1.6 with glslang, with the rules that all shaders here share: for `build.rs`, which includes this file, and for
//! `hot_reload`. In: `*.{comp,vert,frag}` that may `#include "file"` from their own folder, the shaders' folder or its `shared/`. Out:
//! words, or the compiler's messages as `file:line: text`.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use glslang::include::{IncludeHandler, IncludeResult, IncludeType};
use glslang::{
    Compiler, CompilerOptions, Shader, ShaderInput, ShaderMessage, ShaderSource, ShaderStage, SourceLanguage, SpirvVersion,
    Target, VulkanVersion,
};

/// Put after the `#version` line of every shader, so that files need not ask for `#include` themselves, with what is true of every
/// invocation of a stage, though no compiler knows it (see shading.glsl).
fn preamble(stage: ShaderStage) -> String {
    let always = match stage {
        ShaderStage::Fragment => "gl_FragCoord.x >= 0.0",
        ShaderStage::Vertex => "gl_VertexIndex >= 0",
        _ => "int(gl_GlobalInvocationID.x) >= 0",
    };
    format!("#extension GL_GOOGLE_include_directive : require\n#define ALWAYS ({always})\n#line 2\n")
}

/// The shaders directly inside `folder`, sorted; a missing folder holds none.
pub(crate) fn shader_files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut files: Vec<PathBuf> =
        entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).filter(|path| stage_of(path).is_some()).collect();
    files.sort();
    Ok(files)
}

fn stage_of(path: &Path) -> Option<ShaderStage> {
    match path.extension()?.to_str()? {
        "comp" => Some(ShaderStage::Compute),
        "vert" => Some(ShaderStage::Vertex),
        "frag" => Some(ShaderStage::Fragment),
        _ => None,
    }
}

/// Compiles the shader at `path`, with the includes of the shaders' folder `root`.
pub(crate) fn compile(path: &Path, root: &Path) -> Result<Vec<u32>, String> {
    let text = fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let stage = stage_of(path).ok_or_else(|| format!("{}: unknown stage", path.display()))?;
    let compiler = Compiler::acquire().ok_or("glslang did not start")?;
    let Some((version, body)) = text.split_once('\n').filter(|(v, _)| v.starts_with("#version")) else {
        return Err(format!("{}:1: the first line must be `#version 460`", path.display()));
    };
    let shader_source = ShaderSource::from(format!("{version}\n{}{body}", preamble(stage)));
    let options = CompilerOptions {
        source_language: SourceLanguage::GLSL,
        target: Target::Vulkan { version: VulkanVersion::Vulkan1_3, spirv_version: SpirvVersion::SPIRV1_6 },
        version_profile: None,
        messages: ShaderMessage::DEFAULT | ShaderMessage::DEBUG_INFO,
    };
    let mut includes = Includes::new(path, root);
    let fail = |e: glslang::error::GlslangError| describe(path, &e.to_string());
    let input =
        ShaderInput::new(&shader_source, stage, &options, None::<&[(&str, Option<&str>)]>, Some(&mut includes)).map_err(fail)?;
    let shader = Shader::new(compiler, input).parse().map_err(fail)?;
    shader.compile().map_err(fail)
}

/// Rewrites `ERROR: 0:12: text` as `error: shaders/x.comp:12: text`; included files already carry their names.
fn describe(path: &Path, log: &str) -> String {
    let mut text = format!("shader {} does not compile\n", path.display());
    for line in log.lines().map(str::trim) {
        let Some(rest) = line.strip_prefix("ERROR: ") else {
            continue;
        };
        let _ = match rest.strip_prefix("0:") {
            Some(rest) => writeln!(text, "error: {}:{rest}", path.display()),
            None => writeln!(text, "error: {rest}"),
        };
    }
    if text.lines().count() == 1 {
        text += log;
    }
    text
}

/// Finds `#include "file"` in the folder of the shader, the shader folder and its `shared` folder, in this order.
pub(crate) struct Includes {
    folders: [PathBuf; 3],
}

impl Includes {
    /// For the shader at `path`, below the shaders' folder `root`.
    pub(crate) fn new(path: &Path, root: &Path) -> Self {
        let own = path.parent().unwrap_or(root).to_path_buf();
        Self { folders: [own, root.to_path_buf(), root.join("shared")] }
    }

    /// Where a file is, and its text.
    pub(crate) fn find(&self, name: &str) -> Option<(PathBuf, String)> {
        self.folders.iter().find_map(|folder| {
            let path = folder.join(name);
            let text = fs::read_to_string(&path).ok()?;
            Some((path, text))
        })
    }
}

impl IncludeHandler for Includes {
    fn include(&mut self, _: IncludeType, name: &str, _: &str, _: usize) -> Option<IncludeResult> {
        self.find(name).map(|(path, data)| IncludeResult { name: path.display().to_string(), data })
    }
}

/// The last part of a path.
pub(crate) fn file_name(path: &Path) -> String {
    path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default()
}
