// Clusters: STP_CLUSTER points that follow each other in canonical order, culled before any of them is
// projected. src/record/upload_clusters.c makes them. Two texels each, which a CPU device loads at once.
// Needs lib/points.glsl.
layout(set = 0, binding = STP_BINDING_CLUSTERS) uniform usamplerBuffer cluster_texels;

struct Cluster {
    vec3 center; // of a ball that holds the points' centres; camera frame
    float radius;
    vec3 axis; // of a cone that holds their normals
    float sine; // of its half angle; 2: some point has no normal, or they spread over a half space
    float reach; // the largest of their discs' radii
};

Cluster cluster_load(uint cluster)
{
    // Loads are not always masked.
    uint known = min(cluster, (push_count - 1) / STP_CLUSTER);
    vec4 ball = uintBitsToFloat(texelFetch(cluster_texels, int(2 * known)));
    uvec4 cone = texelFetch(cluster_texels, int(2 * known + 1));
    const float r[9] = frame.rotation, t[3] = frame.translation;
    mat3 turn = mat3(r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]);
    vec3 place = vec3(t[0], t[1], t[2]);
    return Cluster(turn * ball.xyz + place, ball.w + 1e-5 * (length(ball.xyz) + length(place)),
                   turn * octahedral_decode(cone.x), uintBitsToFloat(cone.y), uintBitsToFloat(cone.z));
}

// Beyond the edges of the grid; a pixel for where samples lie in theirs.
bool beyond_grid(vec3 at, float r)
{
    vec2 focal = vec2(frame.focal[0], frame.focal[1]), middle = vec2(frame.center[0], frame.center[1]);
    vec2 low = middle - vec2(frame.grid_x, frame.grid_y) + 1;
    vec2 high = low - vec2(frame.grid_width, frame.grid_height) - 2;
    float depth = ORTHOGRAPHIC ? 1 : at.z, slant = ORTHOGRAPHIC ? 0 : 1;
    vec2 below = focal * at.xy + low * depth + r * sqrt(focal * focal + slant * low * low);
    vec2 above = focal * at.xy + high * depth - r * sqrt(focal * focal + slant * high * high);
    return any(lessThan(below, vec2(0))) || any(greaterThan(above, vec2(0)));
}

// True: point_seen would refuse each of its points, however they round.
bool cluster_culled(Cluster c)
{
    // Every normal is in the cone, every point in the ball.
    bool behind =
        ORTHOGRAPHIC ? c.axis.z >= c.sine : dot(c.axis, c.center) >= c.sine * length(c.center) + c.radius;
    bool outside = c.center.z + c.radius < frame.near_depth || c.center.z - c.radius > frame.far_depth;
    return (CULL_BACK && behind) || outside;
}

// False: point_seen or point_pixel would refuse each of its points.
bool cluster_seen(Cluster c)
{
    return !(cluster_culled(c) || beyond_grid(c.center, c.radius));
}

// None of its points is nearer.
float cluster_nearest(Cluster c)
{
    return max(c.center.z - c.radius, frame.near_depth);
}
