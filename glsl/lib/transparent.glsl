// What Algorithms 2 and 3 of ZP share. Needs shade.glsl.

// The light on a splat is the same for all its fragments: it is shaded once, by its vertices.
const bool SHADED_ONCE = HEAD_LIGHT && !LOCAL_VIEWER;

uint splat_object(uint id)
{
    return HAS_OBJECTS ? floatBitsToUint(frame.splats.v[2 * id + 1].w) >> 8 : 0;
}

MaterialData splat_material(uint id)
{
    return material_at(splat_object(id));
}

// Of an image's nearest fragment are kept its depth and a word: its splat; or, where nothing asks for
// that (PACKED), what it adds to the mean, normal 24 | rho^2 8. No word is STP_NO_ID.
const uint WINNER_NORMAL_BITS = 12;
const float WINNER_RHO = 254;
