#version 460
// Squares every texel of an image into another.
layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint FACTOR = 1;
layout(binding = 0) uniform sampler2D source;
layout(binding = 1, r32f) uniform writeonly image2D target;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(target)))) {
        return;
    }
    float value = texelFetch(source, texel, 0).x;
    imageStore(target, texel, vec4(value * value * float(FACTOR)));
}
