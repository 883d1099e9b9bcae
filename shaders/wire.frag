#version 460
// Lines of the wireframe: dark and half transparent, so that the shading stays readable below them.
layout(location = 0) out vec4 out_color;
layout(location = 0) in vec3 in_position;
layout(location = 1) in vec2 in_grid;
layout(location = 2) flat in uint in_patch;

void main() {
    out_color = vec4(vec3(0.0), 0.55);
}
