//! GLSL of the structures and constants: how each type is declared there, the text of `shaders/shared/layout.glsl`, and a shader that
//! reads every member back.

use super::constants::declarations;
use super::structures;
use std::fmt::Write;

/// A type that can be a member of a GPU structure.
pub(super) trait GlslMember {
    /// GLSL declaration of a member of this type.
    fn declare(name: &str) -> String;
    /// GLSL expressions of all 32-bit words of a member.
    fn words(name: &str) -> Vec<String>;
}

macro_rules! glsl_members {
    ($($rust:ty => $glsl:literal, $suffix:literal, [$($word:literal),*];)*) => {$(
        impl GlslMember for $rust {
            fn declare(name: &str) -> String {
                format!("{} {name}{};", $glsl, $suffix)
            }
            fn words(name: &str) -> Vec<String> {
                vec![$(format!(concat!("{}", $word), name)),*]
            }
        }
    )*};
}

glsl_members! {
    u32 => "uint", "", [""];
    i32 => "int", "", [""];
    f32 => "float", "", [""];
    [u32; 2] => "uvec2", "", [".x", ".y"];
    [i32; 3] => "ivec3", "", [".x", ".y", ".z"];
    [f32; 2] => "vec2", "", [".x", ".y"];
    [f32; 3] => "vec3", "", [".x", ".y", ".z"];
    [f32; 4] => "vec4", "", [".x", ".y", ".z", ".w"];
    [[f32; 3]; 5] => "vec3", "[5]", ["[0].x", "[0].y", "[0].z", "[1].x", "[1].y", "[1].z", "[2].x", "[2].y", "[2].z",
        "[3].x", "[3].y", "[3].z", "[4].x", "[4].y", "[4].z"];
    [[f32; 4]; 4] => "mat4", "", ["[0].x", "[0].y", "[0].z", "[0].w", "[1].x", "[1].y", "[1].z", "[1].w",
        "[2].x", "[2].y", "[2].z", "[2].w", "[3].x", "[3].y", "[3].z", "[3].w"];
}

/// A type that a shared constant can have.
pub(super) trait GlslConstant {
    /// GLSL declaration of a constant of this value.
    fn declare(&self, name: &str) -> String;
}

macro_rules! glsl_constants {
    ($($rust:ty => $glsl:literal, $suffix:literal;)*) => {$(
        impl GlslConstant for $rust {
            fn declare(&self, name: &str) -> String {
                format!("const {} {name} = {self:?}{};", $glsl, $suffix)
            }
        }
    )*};
}

glsl_constants! {
    u32 => "uint", "u";
    i32 => "int", "";
    f32 => "float", "";
    f64 => "float", "";
}

macro_rules! glsl_constant_arrays {
    ($($rust:ty => $glsl:literal, $count:literal, $suffix:literal;)*) => {$(
        impl GlslConstant for $rust {
            fn declare(&self, name: &str) -> String {
                let values = self.map(|x| format!("{x:?}{}", $suffix)).join(", ");
                format!(concat!("const ", $glsl, " {}", $count, " = ", $glsl, $count, "({});"), name, values)
            }
        }
    )*};
}

glsl_constant_arrays! {
    [u32; 2] => "uvec2", "", "u";
    [f32; 2] => "vec2", "", "";
    [f32; 3] => "vec3", "", "";
    [f64; 3] => "vec3", "", "";
    [f32; 9] => "mat3", "", "";
    [f32; 7] => "float", "[7]", "";
}

/// The generated GLSL: all structures and shared constants.
pub fn glsl() -> String {
    let mut text = String::from(
        "// Generated from planet/src/draw/layout/; regenerate with TERRANE_UPDATE=1 cargo test -p terrane-planet layout.\n\n\
         #ifndef TERRANE_LAYOUT\n#define TERRANE_LAYOUT\n\n",
    );
    for (name, members, _) in structures() {
        let _ = writeln!(text, "struct {name} {{\n    {}\n}};\n", members.join("\n    "));
    }
    for line in declarations() {
        let _ = writeln!(text, "{line}");
    }
    text.push_str("\n#endif\n");
    text
}

/// GLSL of a compute shader that copies every word of one of each structure into a buffer, in order.
pub fn probe_glsl() -> String {
    let mut text = String::from(
        "#version 460\n// Generated from planet/src/draw/layout/: reads every member of every structure back (tests only).\n\
         #extension GL_EXT_scalar_block_layout : require\n#include \"layout.glsl\"\n\nlayout(local_size_x = 1) in;\n",
    );
    let mut body = String::new();
    for (binding, (name, _, words)) in structures().into_iter().enumerate() {
        let variable = name.to_lowercase();
        let _ = writeln!(text, "layout(scalar, binding = {binding}) readonly buffer {name}Block {{ {name} {variable}; }};");
        for word in words {
            let _ = writeln!(body, "    words[at++] = bits({variable}.{word});");
        }
    }
    let binding = structures().len();
    let _ = writeln!(text, "layout(scalar, binding = {binding}) writeonly buffer Words {{ uint words[]; }};\n");
    text.push_str("uint bits(uint x) { return x; }\nuint bits(int x) { return uint(x); }\nuint bits(float x) { return floatBitsToUint(x); }\n\n");
    let _ = writeln!(text, "void main() {{\n    uint at = 0u;\n{body}}}");
    text
}

/// Words (32-bit) of each structure in the order of [`probe_glsl`]'s bindings.
pub fn probe_words() -> Vec<(&'static str, usize)> {
    structures().into_iter().map(|(name, _, words)| (name, words.len())).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{DrawnVertex, EmitState, FrameView, GuiCorner, PatchDraw, PatchVertex, Shading, Star, Task};
    use super::*;

    #[test]
    fn structures_have_no_padding() {
        let sizes = [
            size_of::<PatchVertex>(),
            size_of::<PatchDraw>(),
            size_of::<DrawnVertex>(),
            size_of::<Star>(),
            size_of::<GuiCorner>(),
            size_of::<Task>(),
            size_of::<FrameView>(),
            size_of::<Shading>(),
            size_of::<EmitState>(),
        ];
        let words: Vec<usize> = probe_words().into_iter().map(|(_, words)| 4 * words).collect();
        assert_eq!(words, sizes);
    }

    #[test]
    fn generated_shader_code_is_up_to_date() {
        let shaders = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
        for (file, text) in [("shared/layout.glsl", glsl()), ("layout_probe.comp", probe_glsl())] {
            let path = shaders.join(file);
            if std::env::var_os("TERRANE_UPDATE").is_some() {
                std::fs::write(&path, &text).unwrap();
            }
            let found = std::fs::read_to_string(&path).unwrap_or_default();
            assert!(found == text, "{} is out of date: run the tests once with TERRANE_UPDATE=1", path.display());
        }
    }
}
