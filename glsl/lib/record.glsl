// What bin.comp leaves of a large splat for the passes that draw it block by block (frame.projected):
//   0 place: part, whole   1 g, ab, zc   2 q, h.x   3 h.y, reach, id, tag   4 normal, field.x
// and of an ellipse, its axes turned as its normal was
//   5 st   6 u, field.y   7 v, field.z   8 first clip line, field.w   9 second clip line, reflex

const uint RECORD = PHONG == 2 ? STP_BIN_CLIPPED : PHONG == 1 ? STP_BIN_ELLIPSE : STP_BIN_DISC;

#ifdef BINNED

layout(set = 0, binding = STP_BINDING_PROJECTED) uniform utextureBuffer record_texels;

vec4 record_at(uint at)
{
    return uintBitsToFloat(texelFetch(record_texels, int(at)));
}

void record_load_ellipse(uint at, float field, inout Splat s, inout Footprint f)
{
    vec4 u = record_at(at + 6), v = record_at(at + 7), first = record_at(at + 8);
    f.st = record_at(at + 5);
    s.phong.u = u.xyz;
    s.phong.v = v.xyz;
    s.phong.field = vec4(field, u.w, v.w, first.w);
    s.phong.side = 1;
    if (PHONG != 2)
        return;
    vec4 second = record_at(at + 9);
    s.phong.clip[0] = first.xyz;
    s.phong.clip[1] = second.xyz;
    s.phong.reflex = second.w != 0;
}

// Returns the id. Of the splat: its tag, its normal, and of an ellipse all but the radii.
uint record_load(uint record, out Splat s, out Footprint f)
{
    uint at = record * RECORD;
    vec4 a = record_at(at), b = record_at(at + 1), c = record_at(at + 2), d = record_at(at + 3);
    vec4 e = record_at(at + 4);
    f.p = Place(floatBitsToInt(a.zw), a.xy);
    f.g = b.x;
    f.ab = b.yz;
    f.zc = b.w;
    f.q = c.xyz;
    f.h = vec2(c.w, d.x);
    f.reach = d.y;
    s.tag = floatBitsToUint(d.w);
    s.normal = e.xyz;
    if (PHONG != 0)
        record_load_ellipse(at, e.w, s, f);
    return floatBitsToUint(d.z);
}

#else

// As integers: ids and places are no floats that a device may flush.
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer RecordRef { uvec4 v[]; };

void record_put(uint at, vec4 value)
{
    RecordRef(frame.projected).v[at] = floatBitsToUint(value);
}

void record_store(uint record, uint id, Splat s, Footprint f)
{
    uint at = record * RECORD;
    Phong e = s.phong;
    RecordRef(frame.projected).v[at] = uvec4(floatBitsToUint(f.p.part), f.p.whole);
    record_put(at + 1, vec4(f.g, f.ab, f.zc));
    record_put(at + 2, vec4(f.q, f.h.x));
    RecordRef(frame.projected).v[at + 3] = uvec4(floatBitsToUint(vec2(f.h.y, f.reach)), id, s.tag);
    record_put(at + 4, vec4(s.normal, PHONG != 0 ? e.field.x : 0));
    if (PHONG == 0)
        return;
    record_put(at + 5, f.st);
    record_put(at + 6, vec4(e.side * e.u, e.field.y));
    record_put(at + 7, vec4(e.side * e.v, e.field.z));
    record_put(at + 8, vec4(e.clip[0], e.field.w));
    if (PHONG == 2)
        record_put(at + 9, vec4(e.clip[1], e.reflex ? 1 : 0));
}

#endif
