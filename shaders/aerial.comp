#version 460
// Tables of the eye: light that the air scatters towards it, over opacity, by azimuth, latitude and part of the ray.
#include "scattering.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f, binding = 1) uniform writeonly image2DArray scattered_table;
layout(rgba16f, binding = 2) uniform writeonly image2DArray haze_table;
layout(binding = 3) uniform sampler2D nodes;
layout(binding = 4) uniform sampler2D levels;
layout(binding = 5) uniform sampler2D densities;

// Where rays begin and point, by the cosines of their azimuth and, where they begin, against the vertical: that is at the eye or, from
// outside, where they enter the air.
void ray_of(float cosine, float c, out vec3 vertical, out vec3 ray) {
    vec3 up = shading.vertical, towards = shading.sunward;
    vec3 along = towards * cosine + cross(up, towards) * sqrt(max(1.0 - cosine * cosine, 0.0));
    float sine = sqrt(max(1.0 - c * c, 0.0));
    vertical = up;
    ray = up * c + along * sine;
    if (is_outside()) {
        // Angles of the triangle of eye, centre and entry.
        float at_eye = asin(clamp(sine * (bottom_radius() + thickness()) / (shading.radius + shading.height_m), 0.0, 1.0));
        float at_centre = acos(clamp(-c, -1.0, 1.0)) - at_eye;
        vertical = up * cos(at_centre) + along * sin(at_centre);
        ray = along * sin(at_eye) - up * cos(at_eye);
    }
}

// What a node of a row's ray adds: light over extinction, as if all of the ray were as here.
Source source_of(ivec2 node, float r_sun, float nu, float phase) {
    vec4 level = texelFetch(levels, node, 0);
    Medium medium = medium_of(texelFetch(densities, node, 0).rgb);
    Source source = source_at(medium, Level(level.z, level.w), (r_sun + level.x * nu) / level.y, phase);
    vec3 extinction = max(medium.extinction, vec3(1e-20));
    source.molecules = (SUN * source.molecules + NIGHT / PI * (medium.rayleigh + medium.mie)) / extinction;
    source.haze *= SUN / extinction;
    return source;
}

// The integral of the parabola through three values over opacities `a` and `b` between them (Simpson's rule for uneven steps); of straight
// lines where the one is nothing beside the other.
vec3 integral(vec3 first, vec3 middle, vec3 last, vec3 a, vec3 b) {
    vec3 sum = a + b, straight = 0.5 * ((first + middle) * a + (middle + last) * b);
    vec3 least = max(min(a, b), vec3(1e-12)), share = clamp(5.0 * least / max(sum, vec3(1e-11)) - 0.5, 0.0, 1.0);
    vec3 ab = max(a, vec3(1e-12)) / max(b, vec3(1e-12)), ba = 1.0 / ab;
    vec3 curved = sum / 6.0 * ((2.0 - ba) * first + (2.0 + ab + ba) * middle + (2.0 - ab) * last);
    return mix(straight, curved, share);
}

void main() {
    ivec3 size = imageSize(scattered_table);
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, size.xy))) return;
    bool to_ground;
    float c = row_cosine(texel.y, size.y, to_ground), r = bottom_radius() + eye_height();
    vec3 vertical, ray;
    ray_of(1.0 - 2.0 * float(texel.x) / float(size.x - 1), c, vertical, ray);
    float r_sun = r * dot(vertical, shading.sun), nu = dot(ray, shading.sun), phase = rayleigh_phase(nu);

    int last_node = textureSize(nodes, 0).x - 1, stride = last_node / (size.z - 1);
    vec3 end = texelFetch(nodes, ivec2(0, texel.y), 0).rgb;
    Source before = source_of(ivec2(0, texel.y), r_sun, nu, phase);
    vec3 molecules = vec3(0.0), haze = vec3(0.0), opacity = vec3(0.0);
    imageStore(scattered_table, ivec3(texel, 0), vec4(before.molecules, 1.0));
    imageStore(haze_table, ivec3(texel, 0), vec4(before.haze, 1.0));
    for (int node = 2; node <= last_node; node += 2) {
        ivec2 at = ivec2(node, texel.y), between = at - ivec2(1, 0);
        vec3 half_way = texelFetch(nodes, between, 0).rgb, next = texelFetch(nodes, at, 0).rgb;
        Source middle = source_of(between, r_sun, nu, phase), last = source_of(at, r_sun, nu, phase);
        vec3 a = end - half_way, b = half_way - next;
        molecules += integral(before.molecules, middle.molecules, last.molecules, a, b);
        haze += integral(before.haze, middle.haze, last.haze, a, b);
        opacity += a + b;
        if (node % stride == 0) {
            bvec3 some = greaterThan(opacity, vec3(1e-7));
            vec3 over = 1.0 / max(opacity, vec3(1e-7));
            imageStore(scattered_table, ivec3(texel, node / stride), vec4(mix(last.molecules, molecules * over, some), 1.0));
            imageStore(haze_table, ivec3(texel, node / stride), vec4(mix(last.haze, haze * over, some), 1.0));
        }
        before = last;
        end = next;
    }
}
