#version 460
// What each pixel shows, as a depth that later passes test against; and the ground as it is seen where no sea lies over it.
#include "clouds.glsl"
#include "classes.glsl"

layout(binding = 1) uniform sampler2D depth;
layout(binding = 2) uniform sampler2D ground;
layout(scalar, binding = 3) uniform View { FrameView view; };
layout(binding = 4) uniform sampler2D edges;

// Whether there are clouds (1), and rays without air (2).
layout(constant_id = 0) const int ASKED = 3;

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
    bool under_water = (stored <= 0.0 || ground_color.a < 0.0) && !draws_diagram();
    float sea = under_water ? distance_to_sea(ray) : -1.0;
    float end = sea > 0.0 ? sea : stored > 0.0 ? view.near / stored * stretch : 1e30;
    int code = sea > 0.0 ? CLASS_SEA : CLASS_DRY;
    if ((ASKED & 2) != 0 && sea <= 0.0 && !meets_air(ray)) code = CLASS_SPACE;
    if ((ASKED & 1) != 0 && has_clouds() && may_meet_clouds(ray, end)) code = (sea > 0.0 ? CLASS_SEA : CLASS_DRY) + CLASS_CLOUDY;
    bool edge = texelFetch(edges, pixel, 0).r > 0.0;
    gl_FragDepth = class_depth(2 * (2 * code + int(edge)));
}
