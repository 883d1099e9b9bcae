// Light of a planet with a thin shell of air: sunlight that reaches a point, and the light that the air scatters towards the
// eye. Single scattering with two exponential densities (Rayleigh, Mie); optical depth towards the sun by a closed-form
// approximation of the Chapman function (Schüler 2012). Metres, planet-fixed directions.

#extension GL_EXT_scalar_block_layout : require
#include "layout.glsl"

layout(scalar, binding = 0) readonly buffer Light { Shading light; };

const float PI = 3.14159265;
// Irradiance of the sun outside the air, in the units that exposure maps to the display.
const float SUN = 10.0;
// Share of the scattering between the eye and what it sees that is drawn: photographs of the Earth are developed for contrast,
// and the whole of it looks like haze to people who know only those.
const float CLEARNESS = 0.62;
// Light that reached a point by more than one scattering, as a share of the single-scattering density.
const float MULTIPLE = 0.06;

bool has_air() { return light.scale_height > 0.0; }

// Whether the camera is so far away that the squares of its distance and of the planet's radius cannot be compared.
bool is_afar() { return light.altitude > light.radius; }

// Height above the datum of the point at distance t along a ray from the camera. Differences of squares would lose the
// metres that matter near the ground.
float height_along(vec3 ray, float cosine, float t) {
    if (is_afar()) return length(light.camera + ray * t) - light.radius;
    float r = light.radius + light.altitude;
    float root = sqrt(r * r + 2.0 * r * t * cosine + t * t);
    return light.altitude + t * (2.0 * r * cosine + t) / (root + r);
}

// Columns of air from a point at `height` towards a direction with cosine `c` against the vertical, in metres of air at the datum.
float chapman(float height, float scale, float c) {
    float x = light.radius / scale;
    float h = max(height, 0.0) / scale;
    float root = sqrt(x + h);
    if (c >= 0.0) return scale * root / (root * c + 1.0) * exp(-h);
    float lowest = sqrt(max(1.0 - c * c, 0.0)) * (x + h);
    float root_lowest = sqrt(lowest);
    // Below the horizon the lowest point is underground; the caller cuts that off, here it only must stay finite.
    return scale * (2.0 * root_lowest * exp(min(x - lowest, 60.0)) - root / (1.0 - root * c) * exp(-h));
}

// Share of the sun's disc that is above the horizon as seen from a height.
float sun_visibility(float height, float c) {
    float r = light.radius + max(height, 0.0);
    float horizon = -sqrt(max(1.0 - light.radius * light.radius / (r * r), 0.0));
    return smoothstep(-0.012, 0.012, c - horizon);
}

vec3 extinction(float rayleigh_column, float mie_column) {
    return exp(-(light.rayleigh * rayleigh_column + light.mie * 1.1 * mie_column));
}

// Sunlight that arrives at a height where the sun's elevation has sine `c`, as a fraction.
vec3 sunlight(float height, float c) {
    float visible = sun_visibility(height, c);
    if (!has_air() || visible <= 0.0) return vec3(visible);
    return visible * extinction(chapman(height, light.scale_height, c), chapman(height, light.mie_scale_height, c));
}

// Irradiance of the whole sky on level ground where the sun's elevation has sine `c`.
vec3 skylight(float c) {
    if (!has_air()) return vec3(0.002);
    float day = smoothstep(-0.15, 0.35, c);
    vec3 blue = light.rayleigh / max(light.rayleigh.b, 1e-9);
    float density = light.rayleigh.b * light.scale_height;
    return SUN * (blue * 0.6 + 0.4) * 0.55 * (1.0 - exp(-density * 1.3)) * day + vec3(0.004, 0.005, 0.008);
}

// Where a ray from the camera enters and leaves the ball of a radius `above` metres over the datum; x > y if it misses.
vec2 through_shell(vec3 ray, float above) {
    float r = light.radius + light.altitude;
    float shell = light.radius + above;
    float b = dot(ray, normalize(light.camera)) * r;
    // r² - shell², without the cancellation.
    float c = (light.altitude - above) * (r + shell);
    float discriminant = b * b - c;
    if (is_afar()) {
        // By how much the ray passes beside the centre.
        float aside = length(cross(light.camera, ray));
        discriminant = (shell - aside) * (shell + aside);
    }
    if (discriminant < 0.0) return vec2(1.0, -1.0);
    float root = sqrt(discriminant);
    float q = b > 0.0 ? -b - root : -b + root;
    vec2 hits = vec2(q, c / q);
    return vec2(min(hits.x, hits.y), max(hits.x, hits.y));
}

// Distance to the sea along a view ray; negative if it does not meet the sea's surface from above.
float distance_to_sea(vec3 ray) {
    if (light.sea_level <= NO_SEA || light.altitude <= light.sea_level) return -1.0;
    vec2 hits = through_shell(ray, light.sea_level);
    return hits.x < hits.y && hits.y > 0.0 ? hits.x : -1.0;
}

// View ray of a pixel at uv in [0, 1], not normalised: its length per unit of distance along the view axis.
vec3 view_ray(vec2 uv) {
    vec2 screen = uv * 2.0 - 1.0;
    return light.forward + light.right * screen.x - light.up * screen.y;
}

// Scattered light and transmittance between two distances along a ray.
void march(vec3 ray, float from, float to, out vec3 scattered, out vec3 transmittance) {
    const int STEPS = 10;
    vec3 up = normalize(light.camera);
    float cosine = dot(ray, up);
    float towards_sun = dot(ray, light.sun);
    float phase_rayleigh = 3.0 / (16.0 * PI) * (1.0 + towards_sun * towards_sun);
    const float g = 0.76;
    float phase_mie = 3.0 / (8.0 * PI) * (1.0 - g * g) / (2.0 + g * g) * (1.0 + towards_sun * towards_sun)
        / pow(1.0 + g * g - 2.0 * g * towards_sun, 1.5);
    scattered = vec3(0.0);
    vec2 column = vec2(0.0);
    float r = light.radius + light.altitude;
    float before = from;
    for (int k = 0; k < STEPS; ++k) {
        // Steps grow along the ray where it starts in dense air and shrink towards the ground where it comes from space.
        float share = float(k + 1) / float(STEPS);
        float curve = light.altitude < light.air_top ? share * share : share * (2.0 - share);
        float after = mix(from, to, mix(share, curve, 0.7));
        float t = 0.5 * (before + after);
        float length_step = after - before;
        before = after;
        float height = max(height_along(ray, cosine, t), 0.0);
        vec2 density = exp(-height / vec2(light.scale_height, light.mie_scale_height)) * length_step;
        vec3 place = light.camera + ray * t;
        float c = dot(normalize(place), light.sun);
        vec3 arriving = sunlight(height, c);
        density *= CLEARNESS;
        vec3 passed = extinction(column.x + 0.5 * density.x, column.y + 0.5 * density.y);
        vec3 single = arriving * (light.rayleigh * density.x * phase_rayleigh + light.mie * density.y * phase_mie);
        float day = smoothstep(-0.2, 0.3, c);
        vec3 more = MULTIPLE * day / (4.0 * PI) * (light.rayleigh * density.x + light.mie * density.y);
        scattered += passed * (single + more);
        column += density;
    }
    scattered *= SUN;
    transmittance = extinction(column.x, column.y);
}
