#version 460
// The vertex that each vertex is drawn as: its first awake ancestor. Twin: planet/src/reference/resolve.rs.
#include "frame.glsl"

layout(local_size_x = 64) in;

layout(scalar, binding = 0) readonly buffer Patches { PatchDraw patches[]; };
layout(scalar, binding = 1) readonly buffer Tasks { Task tasks[]; };
layout(scalar, binding = 2) readonly buffer Awake { uint awake[]; };
layout(scalar, binding = 3) writeonly buffer Resolved { uint resolved[]; };

layout(push_constant) uniform Push { uint task_count; };

void main() {
    uint number = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (number >= task_count) return;
    Task task = tasks[number];
    PatchDraw target = patches[task.patch_number];
    Vertices vertices = Vertices(target.vertices);
    for (uint k = 0u; k < RESOLVE_CHUNK / 64u; ++k) {
        uint v = task.first + k * 64u + gl_LocalInvocationID.x;
        if (v >= target.vertex_count) return;
        uint at = v;
        // Parents come earlier in the wake order, so this ends, at the latest at a vertex that names itself.
        while ((awake[target.awake_offset + at / 32u] >> (at % 32u) & 1u) == 0u) {
            uint parent = parent_of(vertices, at);
            if (parent >= at) break;
            at = parent;
        }
        resolved[target.resolve_offset + v] = at;
    }
}
