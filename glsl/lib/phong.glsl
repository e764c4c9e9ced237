// Ellipses, their normal fields and clip lines (docs/phong.md). PHONG is 0 where all are discs, and
// then nothing of this is left in a shader. Included by splat.glsl.

struct Phong {
    vec3 u, v;     // camera frame, unit
    vec2 radius;   // semi-axes along u and v
    vec4 field;    // BSK Eq. 2
    float side;    // -1 where the splat's normal was turned
    vec3 clip[2];  // PHONG 2: both lines, those that are missing keep all
    bool reflex;
};

// With axes of no length the splat is a disc whose normal is not known: any axes do.
void phong_disc(vec3 normal, float radius, inout Phong e)
{
    e.u = normalize(abs(normal.x) < 0.7 ? vec3(0, normal.z, -normal.y) : vec3(-normal.z, 0, normal.x));
    e.v = across(normal, e.u);
    e.radius = vec2(radius);
}

void clip_load(uint id, inout Phong e)
{
    if (PHONG != 2)
        return;
    ClipData c = frame.clips.v[splat_known(id)];
    e.clip[0] = c.first;
    e.clip[1] = c.second;
    e.reflex = c.reflex != 0;
}

// Of one line, the other keeps all, and both must.
bool clip_keeps(Phong e, vec2 st)
{
    PRECISE float first = inner(e.clip[0], vec3(st, 1)), second = inner(e.clip[1], vec3(st, 1));
    return (e.reflex ? max(first, second) : min(first, second)) >= 0;
}

// normal: as given, in the world; its image in the camera frame is side * turned.
Phong phong_load(uint id, vec3 normal, vec3 turned, float side)
{
    PhongData d = frame.ellipses.v[splat_known(id)];
    const float r[9] = frame.rotation;
    PRECISE vec3 u = vec3(r[0] * d.u.x + r[1] * d.u.y + r[2] * d.u.z,
                          r[3] * d.u.x + r[4] * d.u.y + r[5] * d.u.z,
                          r[6] * d.u.x + r[7] * d.u.y + r[8] * d.u.z);
    PRECISE vec3 v = side * across(turned, u);
    Phong e;
    e.u = u;
    e.v = v;
    e.radius = d.radius;
    e.field = SHADE == 2 ? vec4(0) : d.field;
    e.side = side;
    if (HAS_UNKNOWN && d.u == vec3(0))
        phong_disc(turned, d.radius.x, e);
    clip_load(id, e);
    return e;
}

// Whether some normal of the field faces the eye from somewhere on the splat: an upper bound of
// N.(eye - q) over the ellipse. towards: from the centre to the eye, in the world.
bool phong_faces(uint id, vec3 normal, REAL3 towards)
{
    PhongData d = frame.ellipses.v[splat_known(id)];
    if (SHADE == 2)
        return false; // its one normal was asked already
    REAL3 n = REAL3(normal), u = REAL3(d.u), v = cross(n, u);
    vec2 r = ORTHOGRAPHIC ? vec2(0) : d.radius;
    REAL along_u = dot(u, towards), along_v = dot(v, towards);
    vec2 slope = vec2(REAL2(d.field.y * along_u, d.field.w * along_v)) - d.field.xz * r;
    REAL most = dot(n, towards) + d.field.x * along_u + d.field.z * along_v;
    return most + length(slope) + max(0, max(-d.field.y * r.x, -d.field.w * r.y)) > 0;
}

// Columns of the map from an offset in pixels to (s, t) den.
void phong_columns(Phong e, vec2 direction, float scale, out vec2 first, out vec2 second)
{
    vec3 d = vec3(direction, 1);
    PRECISE vec2 of_v = across(e.v, d).xy, of_u = across(d, e.u).xy;
    PRECISE vec2 k = e.side * scale / e.radius;
    PRECISE vec2 x = vec2(of_v.x, of_u.x) * k * frame.inv_focal[0];
    PRECISE vec2 y = vec2(of_v.y, of_u.y) * k * frame.inv_focal[1];
    first = x;
    second = y;
}

// The same map of the floored ellipse: its singular values raised, its directions kept. major: the
// unit direction of the larger one, whose image the first column's direction must be.
vec4 phong_floored(vec2 first, vec2 second, vec2 major, float values_major, float values_minor,
                   float turn, float det)
{
    PRECISE vec2 along = first * major.x + second * major.y;
    PRECISE vec2 image = along * (turn * inversesqrt(inner(along, along)));
    vec2 beside = sign(det) * vec2(-image.y, image.x);
    PRECISE vec2 column = values_major * major.x * image - values_minor * major.y * beside;
    PRECISE float ratio = sign(det) * values_major * values_minor / inner(column, column);
    return vec4(column, vec2(-column.y, column.x) * ratio);
}

vec3 phong_normal(Phong e, vec3 turned, vec2 st)
{
    PRECISE vec3 n =
        turned + e.side * ((e.field.x + e.field.y * st.x) * e.u + (e.field.z + e.field.w * st.y) * e.v);
    PRECISE float l = inner(n, n);
    PRECISE vec3 unit = n * inversesqrt(l);
    return l >= 1e-12 ? unit : turned;
}

// Half the splat's extent along the axes of the camera frame.
vec3 phong_reach(Phong e)
{
    vec3 u = e.radius.x * e.u, v = e.radius.y * e.v;
    return sqrt(u * u + v * v);
}

// Offsets from the projected centre c (direction: c.xy / c.z) that the outline reaches, over the
// focal lengths: tangent lines of the projected conic. Its terms are sums of squares.
vec4 phong_extent(Phong e, float depth, vec2 direction)
{
    vec3 u = e.radius.x * e.u, v = e.radius.y * e.v;
    vec2 a = u.xy - direction * u.z, b = v.xy - direction * v.z;
    float k = 1 / (depth * depth - u.z * u.z - v.z * v.z);
    vec2 mid = -k * (a * u.z + b * v.z), reach = sqrt(mid * mid + k * (a * a + b * b));
    return vec4(mid - reach, mid + reach);
}
