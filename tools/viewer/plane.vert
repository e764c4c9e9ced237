#version 460
// A square of two triangles under the scene.
layout(push_constant) uniform Push { mat4 clip; vec4 color; } push;
layout(location = 0) out vec2 place;

void main()
{
    const vec2 corners[6] = vec2[](vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1),
                                   vec2(-1, 1));
    place = corners[gl_VertexIndex];
    gl_Position = push.clip * vec4(place.x, 0, place.y, 1);
}
