#version 460
// Tables of the eye: light that the air scatters towards it, over opacity, by azimuth, latitude and part of the ray.
#include "scattering.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f, binding = 1) uniform writeonly image2DArray scattered_table;
layout(rgba16f, binding = 2) uniform writeonly image2DArray haze_table;
layout(binding = 3) uniform sampler2D nodes;

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

void main() {
    ivec3 size = imageSize(scattered_table);
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, size.xy))) return;
    bool to_ground;
    float height = eye_height(), c = row_cosine(texel.y, size.y, to_ground);
    float whole = max(way_length(height, c, to_ground), 1e-3), r = bottom_radius() + height;
    vec3 vertical, ray;
    ray_of(1.0 - 2.0 * float(texel.x) / float(size.x - 1), c, vertical, ray);
    float sun_c = dot(vertical, shading.sun), nu = dot(ray, shading.sun), phase = rayleigh_phase(nu);

    int last = textureSize(nodes, 0).x - 1, stride = last / (size.z - 1);
    vec3 molecules = vec3(0.0), haze = vec3(0.0), opacity = vec3(0.0), passed = vec3(1.0);
    Source before = Source(vec3(0.0), vec3(0.0));
    for (int node = 0; node <= last; ++node) {
        vec4 stored = texelFetch(nodes, ivec2(node, texel.y), 0);
        float t = stored.x * whole;
        vec2 reached = after(height, c, t);
        Medium medium = medium_at(reached.x);
        Source source = source_at(medium, reached.x, (r * sun_c + t * nu) / reached.y, phase);
        vec3 extinction = max(medium.extinction, vec3(1e-20));
        // Over extinction: what the ray would look like if all of it were as here.
        source.molecules = (SUN * source.molecules + NIGHT / PI * (medium.rayleigh + medium.mie)) / extinction;
        source.haze *= SUN / extinction;
        vec3 lost = node == 0 ? vec3(0.0) : passed - stored.yzw;
        passed = stored.yzw;
        molecules += 0.5 * (before.molecules + source.molecules) * lost;
        haze += 0.5 * (before.haze + source.haze) * lost;
        opacity += lost;
        if (node % stride == 0) {
            bvec3 some = greaterThan(opacity, vec3(1e-7));
            vec3 over = 1.0 / max(opacity, vec3(1e-7));
            imageStore(scattered_table, ivec3(texel, node / stride), vec4(mix(source.molecules, molecules * over, some), 1.0));
            imageStore(haze_table, ivec3(texel, node / stride), vec4(mix(source.haze, haze * over, some), 1.0));
        }
        before = source;
    }
}
