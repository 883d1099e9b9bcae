#version 460
layout(binding = 1) uniform sampler2DArray pages;
layout(push_constant) uniform Push { vec4 tint; uint layer; } push;

layout(location = 0) in vec2 texture_coordinate;
layout(location = 0) out vec4 color;

void main() {
    color = push.tint * textureLod(pages, vec3(texture_coordinate, float(push.layer)), 0.0);
}
