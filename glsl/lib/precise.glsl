#ifndef PRECISE
// Where two modules must find the same bits: nothing is contracted. Of a function: in what it returns.
#ifdef SAME_BITS
#define PRECISE precise
#else
#define PRECISE
#endif

// dot, cross, length and mix are one operation each, whose arithmetic is the driver's: `precise` does not
// reach into them.
PRECISE float inner(vec2 a, vec2 b)
{
    return a.x * b.x + a.y * b.y;
}

PRECISE float inner(vec3 a, vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

PRECISE vec3 across(vec3 a, vec3 b)
{
    return a.yzx * b.zxy - a.zxy * b.yzx;
}

PRECISE vec3 between(vec3 a, vec3 b, float part)
{
    return a + (b - a) * part;
}
#endif
