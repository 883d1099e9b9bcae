#version 460
// Which vertices are awake, one bit each, and where they are drawn. Twins: planet/src/reference/select.rs, position.rs.
#extension GL_KHR_shader_subgroup_ballot : require
#include "frame.glsl"

// 0: every invocation tests 32 vertices and writes a word (fast where subgroups are narrow, as on CPUs).
// 1: every invocation tests one vertex at a time and a ballot makes the word (needs subgroups of 32 or more).
layout(constant_id = 0) const uint BALLOT = 0u;

layout(local_size_x = 32) in;

layout(scalar, binding = 0) readonly buffer View { FrameView view; };
layout(scalar, binding = 1) readonly buffer Patches { PatchDraw patches[]; };
layout(scalar, binding = 2) readonly buffer Tasks { Task tasks[]; };
layout(scalar, binding = 3) writeonly buffer Awake { uint awake[]; };
layout(scalar, binding = 4) buffer State { EmitState state; };
layout(scalar, binding = 5) writeonly buffer DrawnPositions { DrawnVertex drawn_positions[]; };

layout(push_constant) uniform Push { uint task_count; };

// Camera-relative position in lattice units: integers first, so that it is exact near the camera.
vec3 relative_to_camera(ivec3 position) {
    precise vec3 result = vec3(position - view.anchor) - view.offset;
    return result;
}

// Camera-relative position at which a vertex is drawn: on the straight way from its own position (weight 0) to its parent's (1).
vec3 drawn_position(Vertices vertices, uint v, float weight) {
    vec3 own = relative_to_camera(vertices.at[v].position);
    if (weight == 0.0) return own;
    vec3 parent = relative_to_camera(vertices.at[parent_of(vertices, v)].position);
    precise vec3 position = own + (parent - own) * weight;
    return position;
}

// The orientation term's part of the selection distance: planet/src/draw/orientation.rs.
float oriented_distance(vec3 p) {
    vec3 up = view.up;
    precise float below = -(p.x * up.x + p.y * up.y + p.z * up.z);
    precise vec3 across = vec3(p.y * up.z - p.z * up.y, p.z * up.x - p.x * up.z, p.x * up.y - p.y * up.x);
    precise float aside = sqrt(across.x * across.x + across.y * across.y + across.z * across.z);
    precise float distance = view.height_weight * below - view.side_weight * aside;
    return distance;
}

// Whether a vertex is awake, and its morph weight.
bool is_awake(PatchVertex vertex, uint sides, out float weight) {
    weight = 0.0;
    uint code = wake_code(vertex, sides, view.cells);
    if (code == WAKE_ALWAYS) return true;
    weight = 1.0;
    if (code == WAKE_ASLEEP) return false;
    float wake = wake_distance(code);
    precise vec3 p = relative_to_camera(vertex.position);
    precise float outside = 0.0;
    for (int k = 0; k < view.planes.length(); ++k) {
        precise float beyond = p.x * view.planes[k].x + p.y * view.planes[k].y + p.z * view.planes[k].z;
        outside = max(outside, beyond);
    }
    precise float falloff = view.falloff * outside;
    precise float reach = view.reach * wake - falloff;
    precise float squared = p.x * p.x + p.y * p.y + p.z * p.z;
    precise float limit = reach * reach;
    if (reach <= 0.0 || squared >= limit) return false;
    float oriented = view.height_weight > 0.0 ? oriented_distance(p) : 0.0;
    if (oriented >= reach) return false;
    float distance = max(sqrt(squared), oriented);
    precise float slide = ((distance + falloff) / wake - view.scale) * view.morph_rate;
    weight = clamp(slide, 0.0, 1.0);
    return true;
}

// Whether a vertex is awake; writes where it is drawn, for sleeping ones their own position.
bool select_vertex(Vertices vertices, uint v, PatchDraw target) {
    float weight;
    bool awake = is_awake(vertices.at[v], target.coarser_sides, weight);
    drawn_positions[target.resolve_offset + v] = DrawnVertex(drawn_position(vertices, v, awake ? weight : 0.0), weight);
    return awake;
}

void main() {
    uint number = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (number >= task_count) return;
    Task task = tasks[number];
    PatchDraw target = patches[task.patch_number];
    Vertices vertices = Vertices(target.vertices);
    uint lane = gl_LocalInvocationID.x;
    if (BALLOT == 0u) {
        uint first = task.first + lane * 32u;
        if (first >= target.vertex_count) return;
        uint count = min(32u, target.vertex_count - first);
        uint word = 0u;
        for (uint k = 0u; k < count; ++k) {
            word |= uint(select_vertex(vertices, first + k, target)) << k;
        }
        awake[target.awake_offset + first / 32u] = word;
        if (word != 0u) atomicAdd(state.awake, uint(bitCount(word)));
        return;
    }
    for (uint k = 0u; k < SELECT_CHUNK / 32u; ++k) {
        uint first = task.first + k * 32u;
        if (first >= target.vertex_count) return;
        uint v = first + lane;
        bool bit = v < target.vertex_count && select_vertex(vertices, v, target);
        uint word = subgroupBallot(bit).x;
        if (lane == 0u) {
            awake[target.awake_offset + first / 32u] = word;
            atomicAdd(state.awake, uint(bitCount(word)));
        }
    }
}
