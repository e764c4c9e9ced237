// Lists of deep pixels, those that have more fragments than slots (docs/transparency.md, "Many
// fragments"): behind all slots, as far as there is room. Needs pixel.glsl.

const uint LIST_WORD = STP_SLOTS - 1; // of a deep pixel's slots: see list_word

bool deep(uint pixel)
{
    return frame.counts.v[pixel] > STP_SLOTS;
}

// High half: where the list begins, behind list_begin, or STP_LIST_NONE; low half: its length.
uint list_word(uint pixel)
{
    return slot_index(pixel, LIST_WORD);
}

bool list_has(uint pixel)
{
    return deep(pixel) && uint(frame.keys.v[list_word(pixel)] >> 32) != STP_LIST_NONE;
}

// Pixels of whole blocks.
uint list_pixels()
{
    return frame.blocks_x * frame.blocks_y * STP_GROUP;
}

uint list_begin()
{
    return list_pixels() * STP_SLOTS;
}

// Slots of all lists together.
uint list_room()
{
    return list_pixels() * STP_LIST_SLOTS;
}

// The work word of a block: how many fragments its deep pixels have, then the place of their next list.
uint list_block(uint block)
{
    return STP_WORK_FLAGS + 2 * frame.blocks_x * frame.blocks_y + block;
}
