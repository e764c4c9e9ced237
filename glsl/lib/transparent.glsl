// What Algorithms 2 and 3 of ZP share. Needs shade.glsl.

// The light on a splat is the same for all its fragments: it is shaded once, by its vertices.
const bool SHADED_ONCE = HEAD_LIGHT && !LOCAL_VIEWER;

uint splat_object(uint id)
{
    return HAS_OBJECTS ? floatBitsToUint(frame.splats.v[2 * id + 1].w) >> 8 : 0;
}

MaterialData splat_material(uint id)
{
    return frame.materials.v[splat_object(id)];
}
