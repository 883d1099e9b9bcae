#version 460
// Colours come encoded as the display takes them, and multiplied by their alpha: that is how the interface wants them blended.
layout(location = 0) in vec2 in_texel;
layout(location = 1) in vec4 in_color;
layout(location = 0) out vec4 out_color;

layout(binding = 2) uniform sampler2D image;

void main() {
    out_color = in_color * texture(image, in_texel);
}
