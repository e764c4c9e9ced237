#version 460
layout(push_constant) uniform Push { vec4 clip[3]; vec4 color; } push;

void main()
{
    gl_Position = push.clip[gl_VertexIndex];
}
