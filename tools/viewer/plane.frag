#version 460
// A chequered floor.
layout(push_constant) uniform Push { mat4 clip; vec4 color; } push;
layout(location = 0) in vec2 place;
layout(location = 0) out vec4 color;

void main()
{
    ivec2 field = ivec2(floor(place * 4));
    color = push.color * (((field.x + field.y) & 1) == 0 ? 1.0 : 0.6);
}
