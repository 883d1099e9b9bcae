#version 460
// From a picture drawn with fewer pixels to one of all: Catmull and Rom's cubic (1974) over the nearest twelve pixels, stretched along
// edges by the structure tensor of the brightness (Bigün and Granlund 1987), so that slanted edges stay straight instead of stepped; kept
// within the range of the nearest four, so that nothing rings.
layout(location = 0) out vec4 out_color;

layout(binding = 0) uniform sampler2D few;

// Pixels of `few` for one of the picture.
layout(push_constant) uniform Push { vec2 ratio; };

// How much longer than wide the kernel is along a clear edge.
const float STRETCH = 2.0;
// Squares of differences of brightness below which there is no edge: 2 steps of 255.
const float FAINT = 6e-5;

float brightness(vec3 color) { return dot(color, vec3(0.25, 0.5, 0.25)); }

// The cubic at the root of a squared distance.
float cubic(float squared) {
    float r = sqrt(squared);
    float near = 1.0 + squared * (1.5 * r - 2.5), far = 2.0 + r * (-4.0 + r * (2.5 - 0.5 * r));
    return r < 1.0 ? near : r < 2.0 ? far : 0.0;
}

// Adds a pixel's gradient of brightness to the tensor (xx, xy, yy).
void add_gradient(inout vec3 tensor, float weight, float left, float right, float above, float below) {
    vec2 g = vec2(right - left, below - above);
    tensor += weight * vec3(g.x * g.x, g.x * g.y, g.y * g.y);
}

void main() {
    vec2 at = gl_FragCoord.xy * ratio - 0.5;
    ivec2 base = ivec2(floor(at)), last = textureSize(few, 0) - 1;
    vec2 f = at - vec2(base);
    // Rows and columns -1 to 2 around `base`; the corners are not looked at.
    vec3 c[16];
    float l[16];
    for (int k = 0; k < 16; k++) {
        if (k == 0 || k == 3 || k == 12 || k == 15) continue;
        c[k] = texelFetch(few, clamp(base + ivec2(k & 3, k >> 2) - 1, ivec2(0), last), 0).rgb;
        l[k] = brightness(c[k]);
    }
    vec3 tensor = vec3(0.0);
    add_gradient(tensor, (1.0 - f.x) * (1.0 - f.y), l[4], l[6], l[1], l[9]);
    add_gradient(tensor, f.x * (1.0 - f.y), l[5], l[7], l[2], l[10]);
    add_gradient(tensor, (1.0 - f.x) * f.y, l[8], l[10], l[5], l[13]);
    add_gradient(tensor, f.x * f.y, l[9], l[11], l[6], l[14]);
    // Half the difference of the tensor's eigenvalues, and half their sum: how much of it has one direction.
    vec2 turned = vec2(0.5 * (tensor.x - tensor.z), tensor.y);
    float one_way = length(turned), all_ways = 0.5 * (tensor.x + tensor.z);
    float clear = one_way / (all_ways + FAINT);
    // Across the edge, by half of the doubled angle; where that is none, anything.
    vec2 doubled = one_way > 1e-9 ? turned / one_way : vec2(1.0, 0.0);
    vec2 across = vec2(sqrt(max(0.5 + 0.5 * doubled.x, 0.0)), sqrt(max(0.5 - 0.5 * doubled.x, 0.0)));
    if (doubled.y < 0.0) across.y = -across.y;
    float along = 1.0 / mix(1.0, STRETCH, clear * clear);

    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (int k = 0; k < 16; k++) {
        if (k == 0 || k == 3 || k == 12 || k == 15) continue;
        vec2 away = vec2(k & 3, k >> 2) - 1.0 - f;
        float u = dot(away, across), v = along * dot(away, vec2(-across.y, across.x));
        float weight = cubic(u * u + v * v);
        sum += weight * c[k];
        weights += weight;
    }
    vec3 least = min(min(c[5], c[6]), min(c[9], c[10])), most = max(max(c[5], c[6]), max(c[9], c[10]));
    out_color = vec4(clamp(sum / weights, least, most), 1.0);
}
