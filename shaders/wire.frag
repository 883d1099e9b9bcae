#version 460
// Lines of the wireframe: dark and half transparent, so that the shading stays readable below them.
layout(location = 0) out vec4 out_color;

void main() {
    out_color = vec4(vec3(0.0), 0.55);
}
