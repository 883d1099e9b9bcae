#version 460
// Which vertices are awake, one bit each, and how far each is on its way to its parent's place. Twin:
// planet/src/reference/select.rs.
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
layout(scalar, binding = 5) writeonly buffer Morph { float morph[]; };

layout(push_constant) uniform Push { uint task_count; };

bool on_coarser_side(uint grid, uint sides) {
    uint row = view.cells + 1u;
    uint i = grid % row;
    uint j = grid / row;
    return ((sides & 1u) != 0u && i == 0u) || ((sides & 2u) != 0u && i == view.cells)
        || ((sides & 4u) != 0u && j == 0u) || ((sides & 8u) != 0u && j == view.cells);
}

// A wake is 6 bits of exponent and 10 of mantissa: exact in single precision.
float wake_distance(uint code) {
    return uintBitsToFloat(((code >> 10u) + 127u) << 23u | (code & 1023u) << 13u);
}

// Whether a vertex is awake, and its morph weight.
bool is_awake(PatchVertex vertex, uint sides, out float weight) {
    weight = 0.0;
    bool coarser = sides != 0u && on_coarser_side(vertex.grid_own & 0xffffu, sides);
    uint code = (coarser ? vertex.parent_coarser : vertex.grid_own) >> 16u;
    if (code == WAKE_ALWAYS) return true;
    weight = 1.0;
    if (code == 0u) return false;
    float wake = wake_distance(code);
    precise vec3 p = relative_to_camera(vertex.position, view.anchor, view.offset);
    precise float outside = 0.0;
    for (int k = 0; k < 5; ++k) {
        precise float beyond = p.x * view.planes[k].x + p.y * view.planes[k].y + p.z * view.planes[k].z;
        outside = max(outside, beyond);
    }
    precise float falloff = view.falloff * outside;
    precise float reach = view.reach * wake - falloff;
    precise float squared = p.x * p.x + p.y * p.y + p.z * p.z;
    precise float limit = reach * reach;
    if (reach <= 0.0 || squared >= limit) return false;
    precise float slide = ((sqrt(squared) + falloff) / wake - view.scale) * view.morph_rate;
    weight = clamp(slide, 0.0, 1.0);
    return true;
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
            float weight;
            word |= uint(is_awake(vertices.at[first + k], target.coarser_sides, weight)) << k;
            morph[target.resolve_offset + first + k] = weight;
        }
        awake[target.awake_offset + first / 32u] = word;
        if (word != 0u) atomicAdd(state.awake, uint(bitCount(word)));
        return;
    }
    for (uint k = 0u; k < SELECT_CHUNK / 32u; ++k) {
        uint first = task.first + k * 32u;
        if (first >= target.vertex_count) return;
        uint v = first + lane;
        float weight;
        bool bit = v < target.vertex_count && is_awake(vertices.at[v], target.coarser_sides, weight);
        if (v < target.vertex_count) morph[target.resolve_offset + v] = weight;
        uint word = subgroupBallot(bit).x;
        if (lane == 0u) {
            awake[target.awake_offset + first / 32u] = word;
            atomicAdd(state.awake, uint(bitCount(word)));
        }
    }
}
