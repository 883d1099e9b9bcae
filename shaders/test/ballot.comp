#version 460
// Counts the odd numbers of a table that is read by its address: one ballot per subgroup.
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
#extension GL_EXT_scalar_block_layout : require
#include "count.glsl"

layout(local_size_x_id = 0) in;

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Table { uint values[]; };

layout(binding = 0, scalar) buffer Counts { uint odd; uint total; } counts;

layout(push_constant, scalar) uniform Push { uvec2 table; uint count; } push;

void main() {
    uint index = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    bool inside = index < push.count;
    Table table = Table(push.table);
    bool odd = inside && is_odd(table.values[index]);
    uvec4 votes = subgroupBallot(odd);
    uvec4 present = subgroupBallot(inside);
    if (subgroupElect()) {
        atomicAdd(counts.odd, subgroupBallotBitCount(votes));
        atomicAdd(counts.total, subgroupBallotBitCount(present));
    }
}
