#version 460
// The sea: the sphere at sea level, met by every view ray in closed form. Whether ground is under water comes from its
// texture and not from the mesh, which may be coarser than the water is deep, so that coasts are sharp at every altitude.
#include "mirrored_sky.glsl"
#include "skylight.glsl"

layout(binding = 1) uniform sampler2D depth;
layout(binding = 2) uniform sampler2D ground;

layout(location = 0) in vec2 in_uv;
layout(location = 0) out vec4 out_color;

float hash(vec3 cell) {
    cell = fract(cell * vec3(0.1031, 0.1030, 0.0973));
    cell += dot(cell, cell.yxz + 33.33);
    return fract((cell.x + cell.y) * cell.z);
}

float noise(vec3 p) {
    vec3 cell = floor(p), f = p - cell;
    f = f * f * (3.0 - 2.0 * f);
    vec4 near = vec4(hash(cell), hash(cell + vec3(1, 0, 0)), hash(cell + vec3(0, 1, 0)), hash(cell + vec3(1, 1, 0)));
    vec4 far = vec4(hash(cell + vec3(0, 0, 1)), hash(cell + vec3(1, 0, 1)), hash(cell + vec3(0, 1, 1)), hash(cell + vec3(1, 1, 1)));
    vec4 m = mix(near, far, f.z);
    vec2 n = mix(m.xz, m.yw, f.x);
    return mix(n.x, n.y, f.y);
}

// Tilt of the waves that a pixel can resolve; what it cannot becomes roughness.
vec3 ripple(vec3 place, vec3 up, float footprint, out float roughness) {
    vec3 tilt = vec3(0.0);
    float left = 0.24;
    for (int octave = 0; octave < 4; ++octave) {
        float wavelength = 64.0 / pow(4.0, float(octave));
        float seen = 1.0 - smoothstep(0.15, 0.5, footprint / wavelength);
        if (seen <= 0.0) break;
        vec3 p = place / wavelength;
        float here = noise(p);
        vec3 gradient = vec3(noise(p + vec3(0.3, 0, 0)), noise(p + vec3(0, 0.3, 0)), noise(p + vec3(0, 0, 0.3))) - here;
        tilt += gradient * seen * 0.12;
        left -= 0.03 * seen;
    }
    roughness = left;
    return normalize(up - (tilt - up * dot(tilt, up)));
}

void main() {
    vec4 ground_color = texelFetch(ground, ivec2(gl_FragCoord.xy), 0);
    out_color = vec4(ground_color.rgb, 1.0);
    if (light.sea_level <= NO_SEA || is_diagram()) return;
    bool is_ground = texelFetch(depth, ivec2(gl_FragCoord.xy), 0).r > 0.0;
    if (is_ground && ground_color.a >= 0.0) return;

    vec3 view_direction = view_ray(in_uv);
    vec3 ray = normalize(view_direction);
    float t = distance_to_sea(ray);
    if (t < 0.0) return;

    vec3 place = light.camera + ray * t;
    vec3 up = normalize(place);
    float elevation = dot(up, light.sun);
    float footprint = t * 2.0 * length(light.up) / light.size.y / max(-dot(ray, up), 0.02);
    float roughness;
    vec3 normal = ripple(place, up, footprint, roughness);

    // The water's depth below the surface point, and along the ray.
    float water_depth = is_ground ? max(-ground_color.a, 0.0) : SHORE_RANGE;
    float under = water_depth / max(-dot(ray, up), 0.05);
    vec3 absorbed = exp(-under * vec3(0.35, 0.075, 0.06) * 0.7);
    vec3 opaque = 1.0 - absorbed;
    vec3 arriving = sun_irradiance(light.sea_level, elevation);
    vec3 sky = sky_irradiance(light.sea_level, elevation);
    vec3 lit = (arriving * max(elevation, 0.0) + sky) / PI;
    float depth_share = 1.0 - exp(-water_depth / 25.0);
    vec3 body = mix(light.shallow, light.deep, depth_share) * lit;

    float fresnel = 0.02 + 0.98 * pow(1.0 - clamp(-dot(ray, normal), 0.0, 1.0), 5.0);
    // A rough sea seen at grazing angles shows its steeper faces: it never becomes a full mirror.
    fresnel = min(fresnel, 0.02 + 0.55 * (1.0 - roughness));
    vec3 bounced = reflect(ray, normal);
    bounced = normalize(bounced + up * max(0.0, 0.05 - dot(bounced, up)));
    vec3 half_way = normalize(light.sun - ray);
    float a2 = roughness * roughness;
    float n_h = clamp(dot(normal, half_way), 0.0, 1.0);
    float lobe = n_h * n_h * (a2 - 1.0) + 1.0;
    float glint = a2 / (PI * lobe * lobe) * 0.25 * (0.02 + 0.98 * pow(1.0 - clamp(dot(light.sun, half_way), 0.0, 1.0), 5.0));
    vec3 mirrored = mirrored_sky(bounced, up, sky) * fresnel + arriving * glint * step(0.0, elevation);
    vec3 floor_seen = ground_color.rgb * absorbed;
    out_color = vec4((body * opaque + floor_seen) * (1.0 - fresnel) + mirrored, 1.0);
}
