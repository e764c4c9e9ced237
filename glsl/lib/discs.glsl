// The discs of the points on the device, as they were uploaded. Needs lib/pyramid.glsl;
// point_view_keep and disc_view_keep come first.
layout(set = 0, binding = STP_BINDING_RADII) uniform samplerBuffer point_radii;

mat3 normal_turn; // to the camera frame

void disc_view_keep()
{
    const float r[9] = frame.rotation;
    normal_turn = mat3(r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]);
    point_view_keep();
}

// Its normal is of any length.
Texel point_disc(uint index, uvec4 point, float depth, Place place)
{
    float away;
    vec3 n = point_normal(point, away);
    Texel t = EMPTY;
    t.depth = depth;
    t.radius = texelFetch(point_radii, int(index)).x;
    n = TWO_SIDED && away > 0 ? -n : n;
    PRECISE vec3 turned = normal_turn[0] * n.x + normal_turn[1] * n.y + normal_turn[2] * n.z;
    t.normal = turned;
    t.center = vec2(place.whole) + (place.part - sample_shift());
    t.full = true;
    return t;
}

Attributes point_attributes(uint index)
{
    Attributes a = Attributes(vec3(0), push_first + index, 0);
    if (HAS_COLOR)
        a.color = frame.colors.v[index] * frame.pyramid_color;
    if (HAS_OBJECTS)
        a.object = frame.objects.v[index];
    return a;
}
