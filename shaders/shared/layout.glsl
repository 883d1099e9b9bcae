// Generated from planet/src/layout.rs; regenerate with TERRANE_UPDATE=1 cargo test -p terrane-planet layout.

#ifndef TERRANE_LAYOUT
#define TERRANE_LAYOUT

struct PatchVertex {
    ivec3 position;
    uint grid_own;
    uint parent_coarser;
};

struct PatchDraw {
    uvec2 vertices;
    uvec2 triangles;
    uint vertex_count;
    uint awake_offset;
    uint resolve_offset;
    uint coarser_sides;
    uint level;
    uint layer;
    uint parent_layer;
    uvec2 quarter;
    float fade_distance;
    float texel_distance;
    vec3 grid_axis;
};

struct DrawnVertex {
    vec3 place;
    float weight;
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
    float altitude;
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
    float adaptation;
    float time;
    vec3 anchor;
    float sea_variance;
    float cloud_height;
    float cloud_depth;
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
const uint NO_LAYER = 4294967295u;
const uint VERTEX_BITS = 15u;
const uint SELECT_CHUNK = 1024u;
const uint RESOLVE_CHUNK = 256u;
const uint MODE_SHADED = 0u;
const uint MODE_WIRE = 1u;
const uint MODE_LEVELS = 2u;
const uint MODE_NORMALS = 3u;
const uint MODE_ALBEDO = 4u;
const uint MODE_DEPTH = 5u;
const uint TEXTURE_GUTTER = 4u;
const uint WAKE_ALWAYS = 65535u;
const float NO_SEA = -1e30;
const float SHORE_RANGE = 400.0;
const float REPEAT_M = 1024.0;
const float WAVE_COPIES[3] = float[](3.0, 19.0, 151.0);

#endif
