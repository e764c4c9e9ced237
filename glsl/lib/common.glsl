// Extensions, buffer references, the frame block and the specialisation constants.
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_memory_scope_semantics : require

// A word that other threads change by atomics in the same dispatch: a plain load would be a race.
#define ATOMIC_LOAD(word) atomicLoad(word, gl_ScopeDevice, 0, 0)

layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Vec4Ref { vec4 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Vec3Ref { vec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FloatRef { float v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer UintRef { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Uint64Ref { uint64_t v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer U64Vec2Ref { u64vec2 v[]; };

struct MaterialData {
    float ambient, diffuse, specular, shininess;
    vec3 albedo;
    float epsilon;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer MaterialRef { MaterialData v[]; };

struct OpticsData {
    vec3 ior;
    float level;
    vec3 reflectance, absorption;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer OpticsRef { OpticsData v[]; };

struct PhongData {
    vec3 u;
    vec2 radius;
    vec4 field;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PhongRef { PhongData v[]; };

struct ClipData {
    vec3 first, second;
    uint reflex;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ClipRef { ClipData v[]; };

#include "shared/constants.h"
#include "shared/frame.h"
#include "shared/push.h"

layout(set = 0, binding = 0, scalar) uniform Frame { stp_frame_constants frame; };

layout(constant_id = PLAN_GROUPS) const uint K = 1;
layout(constant_id = PLAN_VORONOI) const uint VORONOI = 0; // 0 off, 1 slab, 2 exact
layout(constant_id = PLAN_PACKED) const bool PACKED = false;
layout(constant_id = PLAN_GAUSS) const bool GAUSS = false;
layout(constant_id = PLAN_TWO_SIDED) const bool TWO_SIDED = false;
layout(constant_id = PLAN_CULL_BACK) const bool CULL_BACK = false;
layout(constant_id = PLAN_FLOOR) const bool FLOOR = false;
layout(constant_id = PLAN_ORTHOGRAPHIC) const bool ORTHOGRAPHIC = false;
layout(constant_id = PLAN_HAS_COLOR) const bool HAS_COLOR = false;
layout(constant_id = PLAN_HAS_OBJECTS) const bool HAS_OBJECTS = false;
layout(constant_id = PLAN_HAS_UNKNOWN) const bool HAS_UNKNOWN = false; // some normals are (0, 0, 0)
layout(constant_id = PLAN_HEAD_LIGHT) const bool HEAD_LIGHT = true; // the default light alone
layout(constant_id = PLAN_LOCAL_VIEWER) const bool LOCAL_VIEWER = false;
layout(constant_id = PLAN_BACKGROUND) const bool BACKGROUND = false;
layout(constant_id = PLAN_AOVS) const uint AOVS = 0; // bit 0 albedo and weight, 1 id and fragments, 2 layers
layout(constant_id = PLAN_SQUARINGS) const uint SQUARINGS = 5; // shininess = 2^SQUARINGS; 32: any
layout(constant_id = PLAN_REPAIR) const bool REPAIR = false; // two-pass code on overflowed pixels only
layout(constant_id = PLAN_KEY_IDS) const bool KEY_IDS = false; // exact: packed slots have ids, lib/terms.glsl
// PLAN_ATOMIC64, PLAN_LAYERED and PLAN_FLOAT64 choose modules, not code; PLAN_LANES is the size of a
// workgroup of the pyramid's passes.
layout(constant_id = PLAN_SAMPLE_GRID) const uint SAMPLE_GRID = 1; // the picture is the mean of SAMPLES
layout(constant_id = PLAN_AXIS_WALKS) const uint AXIS_WALKS = 1;
layout(constant_id = PLAN_AXIS_CUT) const bool AXIS_CUT = false; // near or far cuts kernels
layout(constant_id = PLAN_UNLIT) const bool UNLIT = false; // a volume shows its colours as they are
layout(constant_id = PLAN_AXIS_WALK) const uint AXIS_WALK = 0; // of this pass
layout(constant_id = PLAN_AXIS_PART) const uint AXIS_PART = 0;
layout(constant_id = PLAN_OPACITY) const uint OPACITY = 0; // 0 all is opaque, 1 one for all, 2 each its own
layout(constant_id = PLAN_MIXED) const bool MIXED = false; // some splats are opaque, where others are not
layout(constant_id = PLAN_OPTICS) const uint OPTICS = 0; // STP_OPTICS_*, or-ed
layout(constant_id = PLAN_HOST_DEPTH) const uint HOST_DEPTH = 0; // enum plan_host_depth
layout(constant_id = PLAN_DEEP) const bool DEEP = false; // layers are kept one by one
layout(constant_id = PLAN_PHONG) const uint PHONG = 0; // 0 all are discs, 1 ellipses, 2 some clipped
layout(constant_id = PLAN_SHADE) const uint SHADE = 0; // 0 pixels, 1 splats, 2 the nearest splat, flat
layout(constant_id = PLAN_LIGHT_CUBE) const bool LIGHT_CUBE = false; // light is looked up over normals
layout(constant_id = PLAN_AXIS_SHAPE) const uint AXIS_SHAPE = 0; // enum axis_shape
const bool ELLIPSOIDS = AXIS_SHAPE == 1;                 // of range images
const bool DISCS = AXIS_SHAPE == 2;                      // a surface's splats
layout(constant_id = PLAN_CULL_CLUSTERS) const bool CULL_CLUSTERS = false; // pyramid: points, STP_CLUSTER at once
layout(constant_id = PLAN_RIM_FAR) const bool RIM_FAR = false; // discs reach beyond the pixels beside their own
layout(constant_id = PLAN_CUTS) const bool CUTS = true; // near or far may cut a splat
layout(constant_id = PLAN_BINS) const bool BINS = false; // large splats are drawn block by block
layout(constant_id = PLAN_COLOR_CODES) const bool COLOR_CODES = false; // exact: colours are summed as integers of 12 bits
const uint SAMPLES = SAMPLE_GRID * SAMPLE_GRID;

// Words of a pixel in out_id: id, fragments; with samples also which sample was nearest, and hits.
// Layers, where they are counted, come last.
const uint ID_WORDS = (SAMPLE_GRID == 1 ? 2 : STP_ID_WORDS) + ((AOVS & 4) == 0 ? 0 : 1);

#ifndef PUSH_MORE
#define PUSH_MORE
#endif
layout(push_constant, scalar) uniform Push { STP_PUSH PUSH_MORE };

// An id that can be looked up, also of a lane that has none: loads are not always masked.
uint splat_known(uint id)
{
    return min(id, frame.known_count - 1);
}

// A vertex of a lane that has none. A software device fills up its vectors of vertices with lanes that
// load zeros; one of them off the screen, or a NaN, would send the whole batch through the clipper. Three
// of these have no area.
const vec4 NO_VERTEX = vec4(0, 0, 0.5, 1);

// Of an object. Where there is only one its material stands in the frame block: a software device loads
// a constant once, and what has an address once a lane.
MaterialData material_at(uint object)
{
    if (HAS_OBJECTS)
        return frame.materials.v[object];
    stp_material_gpu m = frame.material;
    return MaterialData(m.ambient, m.diffuse, m.specular, m.shininess,
                        vec3(m.albedo[0], m.albedo[1], m.albedo[2]), m.epsilon);
}
