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
layout(scalar, binding = 6) readonly buffer DrawnPositions { DrawnVertex drawn_positions[]; };

layout(push_constant) uniform Push { uint task_count; };

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

// `first` is where the patch's drawn vertices begin.
bool is_culled(uint first, uvec3 corners) {
    if (view.culling == 0u) return false;
    vec3 a = drawn_positions[first + corners.x].position;
    vec3 b = drawn_positions[first + corners.y].position;
    vec3 c = drawn_positions[first + corners.z].position;
    if ((view.culling & CULL_FRUSTUM) != 0u) {
        for (int k = 0; k < view.planes.length(); ++k) {
            if (beyond(a, view.planes[k]) && beyond(b, view.planes[k]) && beyond(c, view.planes[k])) return true;
        }
    }
    return (view.culling & CULL_BACK) != 0u && faces_away(a, b, c);
}

// Corners of a triangle, as vertex indices.
uvec3 corners_of(Triangles triangles, uint t) {
    uint word = t + t / 2u;
    uint low = triangles.at[word];
    uint high = triangles.at[word + 1u];
    return (t & 1u) == 0u ? uvec3(low16(low), high16(low), low16(high)) : uvec3(high16(low), low16(high), high16(high));
}

void main() {
    uint number = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (number >= task_count) return;
    Task task = tasks[number];
    PatchDraw target = patches[task.patch_number];
    Triangles triangles = Triangles(target.triangles);
    for (uint first = task.first; first < task.end; first += 64u) {
        uint t = first + gl_LocalInvocationID.x;
        uvec3 corners = uvec3(0u);
        bool keep = t < task.end;
        if (keep) {
            uvec3 vertices = corners_of(triangles, t);
            corners.x = resolved[target.resolve_offset + vertices.x];
            corners.y = resolved[target.resolve_offset + vertices.y];
            corners.z = resolved[target.resolve_offset + vertices.z];
            keep = corners.x != corners.y && corners.y != corners.z && corners.z != corners.x
                && !is_culled(target.resolve_offset, corners);
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
