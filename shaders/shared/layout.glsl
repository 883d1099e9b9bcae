// Generated from planet/src/draw/layout/; regenerate with TERRANE_UPDATE=1 cargo test -p terrane-planet layout.

#ifndef TERRANE_LAYOUT
#define TERRANE_LAYOUT

struct PatchVertex {
    ivec3 position;
    uint grid_wake;
    uint parent_coarser_wake;
};

struct PatchDraw {
    uvec2 vertices;
    uvec2 triangles;
    uint vertex_count;
    uint awake_offset;
    uint resolve_offset;
    uint coarser_sides;
    uint level;
    uint slot;
    uint parent_slot;
    uvec2 quarter;
    vec2 texture_corner;
    float texture_cell;
    float fade_distance;
    float texel_distance;
    vec3 grid_axis;
    vec4 deviations;
};

struct DrawnVertex {
    vec3 position;
    float weight;
};

struct Star {
    vec2 at;
    vec3 radiance;
};

struct GuiCorner {
    vec2 position;
    vec2 texel;
    uint color;
};

struct Task {
    uint patch_number;
    uint first;
    uint end;
};

struct FrameView {
    ivec3 anchor;
    uint culling;
    vec3 offset;
    float scale;
    vec3 planes[5];
    float falloff;
    vec3 up;
    float height_weight;
    float side_weight;
    float reach;
    float morph_rate;
    uint cells;
    vec3 shift;
    float unit;
    float near;
    mat4 clip;
};

struct Shading {
    vec3 camera;
    uint mode;
    vec3 sun;
    float height_m;
    vec3 right;
    float radius;
    vec3 up;
    float sea_level;
    vec3 forward;
    float scale_height;
    vec3 rayleigh;
    float mie_scale_height;
    vec3 mie;
    float mie_g;
    vec3 mie_extinction;
    float ozone_height;
    vec3 ozone;
    float ozone_reach;
    vec3 shallow;
    float air_bottom;
    vec3 deep;
    float air_top;
    vec3 vertical;
    float horizon;
    vec3 sunward;
    vec2 size;
    vec4 window;
    float ground_albedo;
    float exposure;
    uint tone;
    vec3 bend;
    float adaptation;
    float time;
    vec3 anchor;
    float sea_variance;
    float cloud_height;
    float cloud_depth;
    float horizon_drop;
};

struct EmitState {
    uint wanted;
    uint capacity;
    uint awake;
    uint index_count;
    uint instance_count;
    uint first_index;
    int vertex_offset;
    uint first_instance;
};

const uint CULL_FRUSTUM = 1u;
const uint CULL_BACK = 2u;
const float BACK_SLACK = 1e-5;
const uint NO_SLOT = 4294967295u;
const uint TILES_PER_SIDE = 7u;
const float NO_SEA = -1e30;
const uint VERTEX_BITS = 15u;
const uint SELECT_CHUNK = 1024u;
const uint RESOLVE_CHUNK = 256u;
const float SUN = 10.0;
const float SUN_RADIUS = 0.00465;
const float GLARE = 1.7e-6;
const vec3 NIGHT = vec3(0.014, 0.018, 0.024);
const int MULTIPLE_ROUND = 8;
const int MULTIPLE_LAYERS = 8;
const int MULTIPLE_STEPS = 32;
const uint STARS = 9000u;
const uint METER_BINS = 128u;
const uint METER_STRIDE = 4u;
const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);
const float TONE_GREY = 0.18;
const vec2 TONE_SHADOWS = vec2(0.72, 1.25);
const float TONE_SATURATION = 0.42;
const float TONE_SHOULDER = 0.76;
const float TONE_PALING = 0.5;
const float AGX_EXPOSURE = 1.5;
const mat3 AGX_MIX = mat3(0.936992, 0.016931, 0.01695, 0.031373, 0.951387, 0.031373, 0.031689, 0.031666, 0.951657);
const mat3 AGX_UNMIX = mat3(1.068485, -0.018402, -0.018424, -0.034099, 1.052838, -0.034102, -0.034445, -0.03442, 1.052547);
const vec2 AGX_RANGE = vec2(-12.47393, 4.026069);
const float AGX_CURVE[7] = float[7](15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232);
const float AGX_CONTRAST = 1.4;
const float AGX_SATURATION = 1.35;
const vec3 DITHER = vec3(0.06711056, 0.00583715, 52.982918);
const int EDGE_REACH = 128;
const int EDGE_ROWS = 4;
const uint SIDE_LEFT = 1u;
const uint SIDE_RIGHT = 2u;
const uint SIDE_BOTTOM = 4u;
const uint SIDE_TOP = 8u;
const uint MODE_SHADED = 0u;
const uint MODE_WIRE = 1u;
const uint MODE_LEVELS = 2u;
const uint MODE_NORMALS = 3u;
const uint MODE_ALBEDO = 4u;
const uint MODE_DEPTH = 5u;
const uint MODE_WAKE = 6u;
const uint MODE_ERROR = 7u;
const uint TONE_NEUTRAL = 0u;
const uint TONE_AGX = 1u;
bool is_diagram(uint mode) { return any(bvec3(mode == MODE_NORMALS, mode == MODE_ALBEDO, mode == MODE_DEPTH)); }
bool is_plain(uint mode) { return any(bvec2(mode == MODE_NORMALS, mode == MODE_DEPTH)); }
const uint TEXTURE_GUTTER = 4u;
const float SHORE_RANGE = 400.0;
const float FADE_FROM = 0.65;
const float DEVIATION_SHARE = 0.4;
const uint WAKE_ASLEEP = 0u;
const uint WAKE_ALWAYS = 65535u;
const uint WAKE_MANTISSA_BITS = 10u;
const float REPEAT_M = 1024.0;
const float WAVE_COPIES[3] = float[](3.0, 19.0, 151.0);
const float GROUND_LAYER = 0.0;
const float CROWN_LAYER = 1.0;
const float CLOUD_EDGE = 0.5;

#endif
