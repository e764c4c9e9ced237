// 64-bit keys of fragments (docs/deferred.md, "Keys"). Smaller wins; equal keys are equal fragments.
//   packed, depth order:  depth 24 | rho^2 12 | normal 28, or id: TRAITS of lib/terms.glsl
//   packed, slabs:        slab 24-m | rho^2 12 | rest m | normal 28      depth = slab 2^m + rest, 8 <= m <= 16
//   id, depth order:      float depth 32 | id 32
//   id, slabs:            slab 18 | rho 14 | id 32
// Depth is quantised so that epsilon is exactly 2^m steps.

// A unit normal on the octahedron, in two coordinates of that many bits.
uint octahedral_encode(vec3 n, uint bits)
{
    n /= abs(n.x) + abs(n.y) + abs(n.z);
    vec2 o = n.xy;
    if (n.z < 0)
        o = (1 - abs(n.yx)) * vec2(n.x >= 0 ? 1 : -1, n.y >= 0 ? 1 : -1);
    uint mask = (1u << bits) - 1;
    ivec2 q = ivec2(round(o * float(mask >> 1)));
    return (uint(q.x) & mask) | (uint(q.y) & mask) << bits;
}

uint normal_encode(vec3 n)
{
    return octahedral_encode(n, 14);
}

// Of a fragment whose splat has a normal field; else it is the same all over the splat.
uint fragment_encode(Splat s, Fragment f, uint encoded)
{
    return PHONG != 0 ? normal_encode(fragment_normal(s, f)) : encoded;
}

vec3 octahedral_decode(uint u, uint bits)
{
    float unit = 1.0 / float((1u << (bits - 1)) - 1);
    uint above = 32 - bits;
    vec2 o = vec2(int(u << above) >> above, int(u << (above - bits)) >> above) * unit;
    vec3 n = vec3(o, 1 - abs(o.x) - abs(o.y));
    float fold = max(-n.z, 0);
    n.x += n.x >= 0 ? -fold : fold;
    n.y += n.y >= 0 ? -fold : fold;
    return n * inversesqrt(dot(n, n));
}

vec3 normal_decode(uint u)
{
    return octahedral_decode(u, 14);
}

uint depth_quantise(float depth)
{
    return uint(clamp((depth - frame.depth_low) * frame.depth_scale, 0.0, float((1u << STP_DEPTH_BITS) - 1)));
}

float depth_restore(uint q)
{
    return frame.depth_low + (float(q) + 0.5) * frame.depth_step;
}

uint rho_quantise(float rho2)
{
    return uint(rho2 * float(STP_RHO_MOST) + 0.5);
}

// Both layouts split at bit 32 without cutting more than rho or rest, so that 32-bit words do.
uvec2 key_words(Fragment f, uint normal)
{
    uint depth = depth_quantise(f.depth), rho = rho_quantise(f.rho2);
    if (VORONOI == 1) {
        uint m = frame.depth_bits, slab = depth >> m, rest = depth & ((1u << m) - 1);
        return uvec2((rest & 15) << 28 | normal, slab << (8 + m) | rho << (m - 4) | rest >> 4);
    }
    return uvec2((rho & 15) << 28 | normal, depth << 8 | rho >> 4);
}

uint64_t key_packed(Fragment f, uint normal)
{
    return packUint2x32(key_words(f, normal));
}

// In quantised steps.
uint key_depth(uvec2 key)
{
    if (VORONOI == 1) {
        uint m = frame.depth_bits;
        return key.y >> (8 + m) << m | (key.y & ((1u << (m - 4)) - 1)) << 4 | key.x >> 28;
    }
    return key.y >> 8;
}

float key_rho2(uvec2 key)
{
    uint rho = VORONOI == 1 ? key.y >> (frame.depth_bits - 4) & STP_RHO_MOST
                            : (key.y & 255) << 4 | key.x >> 28;
    return float(rho) * (1.0 / float(STP_RHO_MOST));
}

vec3 key_normal(uvec2 key)
{
    return normal_decode(key.x & STP_NORMAL_MASK);
}

uint64_t key_id(Fragment f, uint id)
{
    uint high = depth_order(f.depth);
    if (VORONOI == 1) {
        uint slab = uint(clamp((f.depth - frame.depth_low) * frame.slab_scale, 0.0, float(STP_SLAB_MOST)));
        high = slab << 14 | uint(min(sqrt(f.rho2), 1.0) * 16383.0 + 0.5);
    } else if (VORONOI == 2) {
        high = floatBitsToUint(f.rho2);
    }
    return uint64_t(high) << 32 | id;
}
