// Generated from planet/src/layout.rs: reads every member of every structure back (tests only).
#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_GOOGLE_include_directive : require
#include "layout.glsl"

layout(local_size_x = 1) in;
layout(scalar, binding = 0) readonly buffer PatchVertexBlock { PatchVertex patchvertex; };
layout(scalar, binding = 1) readonly buffer PatchDrawBlock { PatchDraw patchdraw; };
layout(scalar, binding = 2) readonly buffer TaskBlock { Task task; };
layout(scalar, binding = 3) readonly buffer FrameViewBlock { FrameView frameview; };
layout(scalar, binding = 4) readonly buffer ShadingBlock { Shading shading; };
layout(scalar, binding = 5) readonly buffer EmitStateBlock { EmitState emitstate; };
layout(scalar, binding = 6) writeonly buffer Words { uint words[]; };

uint bits(uint x) { return x; }
uint bits(int x) { return uint(x); }
uint bits(float x) { return floatBitsToUint(x); }

void main() {
    uint at = 0u;
    words[at++] = bits(patchvertex.position.x);
    words[at++] = bits(patchvertex.position.y);
    words[at++] = bits(patchvertex.position.z);
    words[at++] = bits(patchvertex.grid_own);
    words[at++] = bits(patchvertex.parent_coarser);
    words[at++] = bits(patchdraw.vertices.x);
    words[at++] = bits(patchdraw.vertices.y);
    words[at++] = bits(patchdraw.triangles.x);
    words[at++] = bits(patchdraw.triangles.y);
    words[at++] = bits(patchdraw.vertex_count);
    words[at++] = bits(patchdraw.triangle_count);
    words[at++] = bits(patchdraw.awake_offset);
    words[at++] = bits(patchdraw.resolve_offset);
    words[at++] = bits(patchdraw.coarser_sides);
    words[at++] = bits(patchdraw.level);
    words[at++] = bits(patchdraw.layer);
    words[at++] = bits(patchdraw.parent_layer);
    words[at++] = bits(patchdraw.quarter.x);
    words[at++] = bits(patchdraw.quarter.y);
    words[at++] = bits(patchdraw.fade_distance);
    words[at++] = bits(patchdraw.grid_axis.x);
    words[at++] = bits(patchdraw.grid_axis.y);
    words[at++] = bits(patchdraw.grid_axis.z);
    words[at++] = bits(task.patch_number);
    words[at++] = bits(task.first);
    words[at++] = bits(frameview.anchor.x);
    words[at++] = bits(frameview.anchor.y);
    words[at++] = bits(frameview.anchor.z);
    words[at++] = bits(frameview.culling);
    words[at++] = bits(frameview.offset.x);
    words[at++] = bits(frameview.offset.y);
    words[at++] = bits(frameview.offset.z);
    words[at++] = bits(frameview.scale);
    words[at++] = bits(frameview.planes[0].x);
    words[at++] = bits(frameview.planes[0].y);
    words[at++] = bits(frameview.planes[0].z);
    words[at++] = bits(frameview.planes[1].x);
    words[at++] = bits(frameview.planes[1].y);
    words[at++] = bits(frameview.planes[1].z);
    words[at++] = bits(frameview.planes[2].x);
    words[at++] = bits(frameview.planes[2].y);
    words[at++] = bits(frameview.planes[2].z);
    words[at++] = bits(frameview.planes[3].x);
    words[at++] = bits(frameview.planes[3].y);
    words[at++] = bits(frameview.planes[3].z);
    words[at++] = bits(frameview.planes[4].x);
    words[at++] = bits(frameview.planes[4].y);
    words[at++] = bits(frameview.planes[4].z);
    words[at++] = bits(frameview.falloff);
    words[at++] = bits(frameview.cells);
    words[at++] = bits(frameview.unit);
    words[at++] = bits(frameview.near);
    words[at++] = bits(frameview.clip[0].x);
    words[at++] = bits(frameview.clip[0].y);
    words[at++] = bits(frameview.clip[0].z);
    words[at++] = bits(frameview.clip[0].w);
    words[at++] = bits(frameview.clip[1].x);
    words[at++] = bits(frameview.clip[1].y);
    words[at++] = bits(frameview.clip[1].z);
    words[at++] = bits(frameview.clip[1].w);
    words[at++] = bits(frameview.clip[2].x);
    words[at++] = bits(frameview.clip[2].y);
    words[at++] = bits(frameview.clip[2].z);
    words[at++] = bits(frameview.clip[2].w);
    words[at++] = bits(frameview.clip[3].x);
    words[at++] = bits(frameview.clip[3].y);
    words[at++] = bits(frameview.clip[3].z);
    words[at++] = bits(frameview.clip[3].w);
    words[at++] = bits(shading.camera.x);
    words[at++] = bits(shading.camera.y);
    words[at++] = bits(shading.camera.z);
    words[at++] = bits(shading.mode);
    words[at++] = bits(shading.sun.x);
    words[at++] = bits(shading.sun.y);
    words[at++] = bits(shading.sun.z);
    words[at++] = bits(shading.altitude);
    words[at++] = bits(shading.right.x);
    words[at++] = bits(shading.right.y);
    words[at++] = bits(shading.right.z);
    words[at++] = bits(shading.radius);
    words[at++] = bits(shading.up.x);
    words[at++] = bits(shading.up.y);
    words[at++] = bits(shading.up.z);
    words[at++] = bits(shading.sea_level);
    words[at++] = bits(shading.forward.x);
    words[at++] = bits(shading.forward.y);
    words[at++] = bits(shading.forward.z);
    words[at++] = bits(shading.scale_height);
    words[at++] = bits(shading.rayleigh.x);
    words[at++] = bits(shading.rayleigh.y);
    words[at++] = bits(shading.rayleigh.z);
    words[at++] = bits(shading.mie);
    words[at++] = bits(shading.shallow.x);
    words[at++] = bits(shading.shallow.y);
    words[at++] = bits(shading.shallow.z);
    words[at++] = bits(shading.mie_scale_height);
    words[at++] = bits(shading.deep.x);
    words[at++] = bits(shading.deep.y);
    words[at++] = bits(shading.deep.z);
    words[at++] = bits(shading.exposure);
    words[at++] = bits(shading.size.x);
    words[at++] = bits(shading.size.y);
    words[at++] = bits(shading.air_top);
    words[at++] = bits(shading.time);
    words[at++] = bits(emitstate.wanted);
    words[at++] = bits(emitstate.capacity);
    words[at++] = bits(emitstate.index_count);
    words[at++] = bits(emitstate.instance_count);
    words[at++] = bits(emitstate.first_index);
    words[at++] = bits(emitstate.vertex_offset);
    words[at++] = bits(emitstate.first_instance);
}
