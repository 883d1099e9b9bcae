#version 460
// What each pixel shows, as a depth that later passes test against; and the ground as it is seen where no sea lies over it.
#include "clouds.glsl"
#include "classes.glsl"

layout(binding = 1) uniform sampler2D depth;
layout(binding = 2) uniform sampler2D ground;
layout(scalar, binding = 3) readonly buffer View { FrameView view; };
layout(binding = 4) uniform sampler2D edges;

// Whether there are clouds.
layout(constant_id = 0) const int CLOUDY = 1;

layout(location = 0) in vec2 in_uv;
layout(location = 0) out vec4 out_color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 ground_color = texelFetch(ground, pixel, 0);
    out_color = vec4(ground_color.rgb, 1.0);
    float stored = texelFetch(depth, pixel, 0).r;
    vec3 direction = view_ray(in_uv);
    float stretch = length(direction);
    vec3 ray = direction / stretch;
    bool under_water = (stored <= 0.0 || ground_color.a < 0.0) && !is_diagram(shading.mode);
    float sea = under_water ? distance_to_sea(ray) : -1.0;
    float end = sea > 0.0 ? sea : stored > 0.0 ? view.near / stored * stretch : 1e30;
    int code = int(sea > 0.0) << SEA_BIT | int(texelFetch(edges, pixel, 0).r > 0.0) << EDGE_BIT;
    if (CLOUDY == 1) code |= int(has_clouds() && may_meet_clouds(ray, end)) << CLOUDS_BIT;
    gl_FragDepth = class_depth(code);
}
