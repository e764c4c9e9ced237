// MKC 3.3: what the coarser level says of a place on a finer one: weights 9, 3, 3, 1 over those four of
// its texels whose ellipses cover the place and that no other of them hides. Needs lib/pyramid.glsl.

struct Pushed {
    float weight; // 0: nothing covers the place
    Texel disc;   // the mean
    vec3 normal;  // weighted sum
    float depth;  // of the surface at the place; the mean
    float front;  // nearest depth there, and what lies with it: at most `reach`
    float reach;
    float before; // depth that a disc which misses the place by a pixel or so would hide from there
    uint count;
    Attributes attributes;
};

// `hiding`: the place holds something, and what counts is whether it is hidden. A surface whose discs
// are smaller than texels hides all of a texel that it goes on in, though the mean disc does not cover it.
Pushed push_from(uint coarse, ivec2 p, vec2 at, bool hiding)
{
    ivec2 global = p + level_origin(coarse - 1);
    ivec2 side = ivec2((global.x & 1) * 2 - 1, (global.y & 1) * 2 - 1);
    ivec2 first = (global >> 1) - level_origin(coarse);
    Texel t[4];
    float depth[4];
    bool full = true, rim = false;
    Pushed r;
    r.front = r.reach = r.before = NOTHING;
    [[unroll]] for (int i = 0; i < 4; i++) {
        t[i] = texel_load(coarse, first + ivec2(i & 1, i >> 1) * side);
        Texel disc = t[i];
        rim = rim || t[i].rim || !texel_valid(t[i]);
        float spread = 0.75 * float(1u << coarse) * (ORTHOGRAPHIC ? 1 : disc.depth) *
                       max(frame.inv_focal[0], frame.inv_focal[1]);
        disc.radius = hiding && disc.full ? max(disc.radius, spread) : disc.radius;
        float away2, reach, margin = spread * (1.5 / 0.75) / float(1u << coarse);
        bool hit = disc_miss(disc, at, depth[i], away2, reach) && texel_valid(disc);
        bool near = !hit && texel_valid(disc) && away2 <= (reach + margin) * (reach + margin);
        r.before = near ? min(r.before, depth[i] + t[i].radius) : r.before;
        depth[i] = hit ? depth[i] : NOTHING;
        r.reach = depth[i] < r.front ? depth[i] + t[i].radius : r.reach;
        r.front = min(r.front, depth[i]);
    }
    r.weight = r.depth = 0;
    r.count = 0;
    r.normal = vec3(0);
    r.disc = Texel(0, 0, 0, vec3(0), vec2(0), false, rim);
    r.attributes = Attributes(vec3(0), STP_NO_ID, 0);
    [[unroll]] for (int i = 0; i < 4; i++) {
        bool counts = depth[i] < NOTHING && depth[i] <= r.reach;
        float w = counts ? (i == 0 ? 9.0 : i == 3 ? 1.0 : 3.0) / 16.0 : 0;
        r.weight += w;
        r.count += counts ? 1 : 0;
        full = full && (!counts || t[i].full);
        r.depth += counts ? w * (depth[i] - r.front) : 0;
        r.normal += w * t[i].normal;
        r.disc.depth += counts ? w * (t[i].depth - r.front) : 0;
        r.disc.radius += w * t[i].radius;
        r.disc.extent = max(r.disc.extent, counts ? t[i].extent : 0);
        r.disc.center += w * (t[i].center - at);
#if ATTRIBUTES > 0
        Attributes of = attributes_load(coarse, first + ivec2(i & 1, i >> 1) * side);
        r.attributes.color += counts ? w * of.color : vec3(0);
        if (counts && depth[i] == r.front) {
            r.attributes.id = of.id;
            r.attributes.object = of.object;
        }
#endif
        if (counts && depth[i] == r.front)
            r.disc.normal = t[i].normal;
    }
    float scale = 1 / r.weight;
    r.depth = r.front + r.depth * scale;
    r.disc.depth = r.front + r.disc.depth * scale;
    r.disc.full = full;
    r.disc.radius *= scale;
    r.disc.center = at + r.disc.center * scale;
    // Normals that cancel leave the frontmost's.
    if (dot(r.normal, r.normal) > 1e-12)
        r.disc.normal = r.normal;
    else
        r.normal = r.weight * r.disc.normal;
    return r;
}
