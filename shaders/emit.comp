#version 460
// The triangles to draw: corners looked up, degenerate and unseen ones dropped, the rest appended to one index buffer.
// Twin: planet/src/reference/emit.rs.
#extension GL_KHR_shader_subgroup_ballot : require
#include "frame.glsl"

layout(local_size_x = 64) in;

layout(scalar, binding = 0) readonly buffer View { FrameView view; };
layout(scalar, binding = 1) readonly buffer Patches { PatchDraw patches[]; };
layout(scalar, binding = 2) readonly buffer Tasks { Task tasks[]; };
layout(scalar, binding = 3) readonly buffer Resolved { uint resolved[]; };
layout(scalar, binding = 4) writeonly buffer Indices { uint indices[]; };
layout(scalar, binding = 5) buffer State { EmitState state; };
layout(scalar, binding = 6) readonly buffer Morph { float morph[]; };

layout(push_constant) uniform Push { uint task_count; };

// Relative rounding error below which a triangle seen edge-on still counts as facing the eye (the twin has the same).
const float BACK_SLACK = 1e-5;

bool beyond(vec3 p, vec3 n) {
    precise float height = p.x * n.x + p.y * n.y + p.z * n.z;
    return height > 0.0;
}

bool faces_away(vec3 a, vec3 b, vec3 c) {
    precise vec3 u = b - a;
    precise vec3 v = c - a;
    precise vec3 n = vec3(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x);
    precise float height = n.x * a.x + n.y * a.y + n.z * a.z;
    precise float size = abs(n.x) * abs(a.x) + abs(n.y) * abs(a.y) + abs(n.z) * abs(a.z);
    precise float limit = size * BACK_SLACK;
    return height > limit;
}

vec3 corner_place(Vertices vertices, uint weights, uint v) {
    return drawn_place(vertices, v, morph[weights + v], view.anchor, view.offset);
}

// `weights` is where the patch's morph weights begin.
bool is_culled(Vertices vertices, uint weights, uvec3 corners) {
    if (view.culling == 0u) return false;
    vec3 a = corner_place(vertices, weights, corners.x);
    vec3 b = corner_place(vertices, weights, corners.y);
    vec3 c = corner_place(vertices, weights, corners.z);
    if ((view.culling & CULL_FRUSTUM) != 0u) {
        for (int k = 0; k < 5; ++k) {
            if (beyond(a, view.planes[k]) && beyond(b, view.planes[k]) && beyond(c, view.planes[k])) return true;
        }
    }
    return (view.culling & CULL_BACK) != 0u && faces_away(a, b, c);
}

void main() {
    uint number = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (number >= task_count) return;
    Task task = tasks[number];
    PatchDraw target = patches[task.patch_number];
    Vertices vertices = Vertices(target.vertices);
    Triangles triangles = Triangles(target.triangles);
    for (uint k = 0u; k < EMIT_CHUNK / 64u; ++k) {
        uint t = task.first + k * 64u + gl_LocalInvocationID.x;
        uvec3 corners = uvec3(0u);
        bool keep = t < target.triangle_count;
        if (keep) {
            uvec2 packed = triangles.at[t];
            corners.x = resolved[target.resolve_offset + (packed.x & 0xffffu)];
            corners.y = resolved[target.resolve_offset + (packed.x >> 16u)];
            corners.z = resolved[target.resolve_offset + packed.y];
            keep = corners.x != corners.y && corners.y != corners.z && corners.z != corners.x
                && !is_culled(vertices, target.resolve_offset, corners);
        }
        uvec4 kept = subgroupBallot(keep);
        uint base = 0u;
        if (subgroupElect()) base = atomicAdd(state.wanted, subgroupBallotBitCount(kept));
        uint slot = subgroupBroadcastFirst(base) + subgroupBallotExclusiveBitCount(kept);
        // Past the end it keeps counting without writing: the picture loses triangles, and the count says how many.
        if (keep && slot < state.capacity) {
            uvec3 drawn = corners | uvec3(task.patch_number << VERTEX_BITS);
            indices[3u * slot] = drawn.x;
            indices[3u * slot + 1u] = drawn.y;
            indices[3u * slot + 2u] = drawn.z;
        }
    }
}
