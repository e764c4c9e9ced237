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
    bool beside; // one of the four is there: points may lie in the pixels round about
    Attributes attributes;
};

// The disc, whose plane a place's ray meets at `depth`, holds all of a texel of so many pixels about the
// place: a pixel's way in the plane is at most that on the screen over the cosine, and a quarter more
// where depths change within the texel.
bool disc_holds(Texel t, vec2 q, float side, float depth, float room)
{
    vec2 inverse = vec2(frame.inv_focal[0], frame.inv_focal[1]);
    vec2 at = (q + sample_shift() - vec2(frame.center[0], frame.center[1])) * inverse;
    vec3 ray = ORTHOGRAPHIC ? vec3(0, 0, 1) : vec3(at, 1);
    float facing = abs(dot(t.normal, ray)) * inversesqrt(dot(ray, ray));
    float half_ = 0.7072 * side * max(inverse.x, inverse.y);
    bool even = ORTHOGRAPHIC || half_ <= 0.2 * facing;
    return even && room * facing >= 1.25 * half_ * (ORTHOGRAPHIC ? 1 : depth);
}

// `hiding`: the place holds something, and what counts is whether it is hidden. A surface whose discs
// are smaller than texels hides all of a texel that it goes on in, though the mean disc does not cover it.
Pushed push_from(uint coarse, ivec2 p, vec2 at, bool hiding)
{
    ivec2 global = p + level_origin(coarse - 1);
    ivec2 side = ivec2((global.x & 1) * 2 - 1, (global.y & 1) * 2 - 1);
    ivec2 first = (global >> 1) - level_origin(coarse);
    Texel t[4];
    float depth[4];
    bool full = true, rim = false, exact = false, inside = false;
    float below = coarse == 1 ? 0 : float(1u << (coarse - 1)); // a pixel is its sample
    Pushed r;
    r.front = r.reach = r.before = NOTHING;
    r.beside = false;
    [[unroll]] for (int i = 0; i < 4; i++) {
        t[i] = texel_load(coarse, first + ivec2(i & 1, i >> 1) * side);
        Texel disc = t[i];
        rim = rim || (t[i].rim && coarse < frame.rim_level) || !texel_valid(t[i]);
        r.beside = r.beside || texel_valid(t[i]);
        float spread = 0.75 * float(1u << coarse) * (ORTHOGRAPHIC ? 1 : disc.depth) *
                       max(frame.inv_focal[0], frame.inv_focal[1]);
        disc.radius = hiding && disc.full ? max(disc.radius, spread) : disc.radius;
        float away2, reach, margin = spread * (1.5 / 0.75) / float(1u << coarse);
        bool hit = disc_miss(disc, at, depth[i], away2, reach) && texel_valid(disc);
        inside = inside || (i == 0 && disc.inside) ||
                 (hit && disc.exact && !hiding && disc_holds(disc, at, below, depth[i], reach - sqrt(away2)));
        bool near = !hit && texel_valid(disc) && away2 <= (reach + margin) * (reach + margin);
        r.before = near ? min(r.before, depth[i] + t[i].radius) : r.before;
        depth[i] = hit ? depth[i] : NOTHING;
        r.reach = depth[i] < r.front ? depth[i] + t[i].radius : r.reach;
        r.front = min(r.front, depth[i]);
    }
    r.weight = r.depth = 0;
    r.count = 0;
    r.normal = vec3(0);
    r.disc = EMPTY;
    r.disc.rim = rim && !inside;
    r.disc.inside = inside;
    r.attributes = Attributes(vec3(0), STP_NO_ID, 0);
    [[unroll]] for (int i = 0; i < 4; i++) {
        bool counts = depth[i] < NOTHING && depth[i] <= r.reach;
        float w = counts ? (i == 0 ? 9.0 : i == 3 ? 1.0 : 3.0) / 16.0 : 0;
        r.weight += w;
        r.count += counts ? 1 : 0;
        exact = exact || (counts && t[i].exact);
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
    r.disc.exact = exact && r.count == 1;
    r.disc.radius *= scale;
    r.disc.center = at + r.disc.center * scale;
    // Normals that cancel leave the frontmost's.
    if (dot(r.normal, r.normal) > 1e-12)
        r.disc.normal = r.normal;
    else
        r.normal = r.weight * r.disc.normal;
    return r;
}
